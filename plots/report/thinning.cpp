#include "plots/report/thinning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace freeplay::report {

double rounded(double x, int digits) {
  if (!std::isfinite(x)) return x;
  char text[40];
  const auto* end = fmt::format_to_n(text, sizeof text, "{:.{}g}", x, digits).out;
  double out = x;
  std::from_chars(text, end, out);
  return out == 0 ? 0 : out;  // avoids −0
}

Thinning::Thinning(long rows, std::size_t columns, long most) : columns_(columns) {
  const long buckets = std::max(1L, most / 2);
  each_ = rows <= most ? 1 : std::max(1L, (rows + buckets - 1) / buckets);
}

void Thinning::take(double t, std::span<const double> values) {
  if (whole()) {
    t_.push_back(t);
    for (std::size_t k = 0; k < columns_.size(); ++k) columns_[k].values.push_back(values[k]);
    return;
  }
  if (filled_ == 0) from_ = t;
  to_ = t;
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    auto& c = columns_[k];
    const double y = values[k];
    if (std::isnan(y)) continue;
    if (!c.any) c.least = c.greatest = y, c.rises = true;
    if (y < c.least) c.least = y, c.rises = false;
    if (y > c.greatest) c.greatest = y, c.rises = true;
    c.any = true;
  }
  if (++filled_ == each_) close();
}

void Thinning::close() {
  const double length = to_ - from_;
  t_.push_back(from_ + 0.25 * length);
  t_.push_back(from_ + 0.75 * length);
  for (auto& c : columns_) {
    const double least = c.any ? c.least : NAN, greatest = c.any ? c.greatest : NAN;
    c.values.push_back(c.rises ? least : greatest);
    c.values.push_back(c.rises ? greatest : least);
    c.any = false;
  }
  filled_ = 0;
}

void Thinning::finish() {
  if (filled_ > 0) close();
}

nlohmann::json numbers(const std::vector<double>& list, int digits) {
  auto out = nlohmann::json::array();
  for (const double x : list)
    if (const double y = rounded(x, digits); y == std::trunc(y) && std::abs(y) < 1e15)
      out.push_back(static_cast<std::int64_t>(y));  // writes 0 instead of 0.0
    else
      out.push_back(y);
  return out;
}

}  // namespace freeplay::report
