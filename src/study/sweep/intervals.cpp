#include "study/sweep/intervals.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace freeplay {

Interval interval(const std::vector<double>& values) {
  Interval s;
  const double nan = std::nan("");
  s.least = INFINITY;
  s.greatest = -INFINITY;
  for (double x : values) {
    if (!std::isfinite(x)) continue;
    ++s.count;
    s.mean += x;
    s.least = std::min(s.least, x);
    s.greatest = std::max(s.greatest, x);
  }
  if (s.count == 0) return {0, nan, nan, nan, nan, nan};
  s.mean /= s.count;
  s.low = s.high = nan;
  if (s.count < 2) return s;
  double squares = 0;
  for (double x : values)
    if (std::isfinite(x)) squares += (x - s.mean) * (x - s.mean);
  const double t = boost::math::quantile(boost::math::students_t(s.count - 1), 0.975);
  const double half = t * std::sqrt(squares / (s.count - 1) / s.count);
  s.low = s.mean - half;
  s.high = s.mean + half;
  return s;
}

Interval interval_of_directions(const std::vector<double>& degrees) {
  std::vector<double> known;
  for (double x : degrees)
    if (std::isfinite(x)) known.push_back(x);
  const double mean = mean_angle(known);
  for (double& x : known) x = half_circle(x - mean);
  auto s = interval(known);
  if (s.count == 0) return s;
  const double half = 0.5 * (s.high - s.low);
  s.mean = mean;
  s.low = half < 90 ? mean - half : std::nan("");
  s.high = half < 90 ? mean + half : std::nan("");
  s.least += mean;
  s.greatest += mean;
  return s;
}

Interval within_range(Interval s, TurnMetrics::Kind kind) {
  const double half = 0.5 * (s.high - s.low), x = s.mean;
  if (std::isnan(half)) return s;
  if (kind == TurnMetrics::Kind::positive) {
    s.low = x > 0 ? x * std::exp(-half / x) : 0;
    s.high = x > 0 ? x * std::exp(half / x) : 0;
  } else if (kind == TurnMetrics::Kind::share) {
    const auto at = [x](double e) { return 1 / (1 + (1 - x) / x * std::exp(e)); };
    const bool inside = x > 0 && x < 1;
    s.low = inside ? at(half / (x * (1 - x))) : x;
    s.high = inside ? at(-half / (x * (1 - x))) : x;
  }
  return s;
}

static Interval of_starts(const std::vector<double>& values, TurnMetrics::Name metric) {
  const auto kind = TurnMetrics::kind(metric);
  if (kind == TurnMetrics::Kind::direction) return interval_of_directions(values);
  const auto s = interval(values);
  return s.low < 0 || (kind == TurnMetrics::Kind::share && s.high > 1) ? within_range(s, kind) : s;
}

Interval cell(const std::vector<RunRow>& runs, const std::string& variant, const std::string& formulation,
              const std::vector<double>& values, TurnMetrics::Name metric) {
  return Cells(runs).of(variant, formulation, values, metric);
}

Cells::Cells(const std::vector<RunRow>& runs) {
  for (const auto& r : runs) runs_[{r.variant, r.formulation, r.values}].push_back(&r);
}

const std::vector<const RunRow*>& Cells::at(const std::string& variant, const std::string& formulation,
                                            const std::vector<double>& values) const {
  static const std::vector<const RunRow*> none;
  const auto found = runs_.find({variant, formulation, values});
  return found == runs_.end() ? none : found->second;
}

Interval Cells::of(const std::string& variant, const std::string& formulation,
                   const std::vector<double>& values, TurnMetrics::Name metric) const {
  std::vector<double> list;
  for (const auto* r : at(variant, formulation, values)) list.push_back(r->metric[metric]);
  return of_starts(list, metric);
}

}  // namespace freeplay
