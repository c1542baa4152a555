#include "study/calibration/measured_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/scene/points_file.hpp"
#include "io/scene/section.hpp"
#include "study/runs/case_run.hpp"

namespace freeplay {
namespace {

std::vector<std::string> quantities_of(const Study& study) {
  std::vector<std::string> names;
  for (const auto& m : study.measures) names.push_back(m.name);
  for (const auto& d : study.derived) names.push_back(d.name);
  return names;
}

/// Equal up to the rounding of a change of unit, also near zero.
bool same_place(const Study& study, const std::vector<double>& a, const std::vector<double>& b) {
  for (std::size_t k = 0; k < a.size(); ++k) {
    double size = std::abs(a[k]);
    for (const double x : study.axes[k].values) size = std::max(size, std::abs(x));
    if (!(std::abs(a[k] - b[k]) <= 1e-9 * size)) return false;
  }
  return true;
}

}  // namespace

std::vector<MeasuredQuantity> read_measured_points(const Study& study) {
  const auto file = study.points.string();
  if (study.axes.empty()) throw error_at(study, {"claims"}, "\"points\" needs an axis");
  for (const auto& axis : study.axes)
    for (const char* taken :
         {"quantity", "variant", "formulation", "value", "uncertainty", "measured", "model"})
      if (axis.name == taken)
        throw error_at(study, {"axes", axis.name}, "is the name of another column; rename the axis");
  if (!study.fit.empty()) throw error_at(study, {"fit"}, "does not go with claims = \"points\"");
  const auto fail = [&](const std::string& what) { throw SceneError(fmt::format("{}: {}", file, what)); };
  const auto table = read_text_table(read_text(study.points), fail);
  const auto column = [&](const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(table.header, name) - table.header.begin());
  };
  const auto needed = [&](const std::string& name) {
    if (column(name) == table.header.size()) fail(fmt::format("line 1: the column {} is missing", name));
    return column(name);
  };
  const auto quantity = needed("quantity"), value = needed("value"), uncertainty = column("uncertainty");
  std::vector<std::size_t> axes;
  for (const auto& axis : study.axes) axes.push_back(needed(axis.name));
  const auto known = quantities_of(study);
  std::vector<std::vector<double>> cells;
  for (const auto& one : cases(study)) cells.push_back(one.values);

  std::vector<MeasuredQuantity> list;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto& row = table.rows[i];
    const auto at_line = [&](const std::string& what) {
      fail(fmt::format("line {}: {}", table.line[i], what));
    };
    const auto number = [&](std::size_t k) {
      const auto x = number_in(row[k]);
      if (!x || !std::isfinite(*x)) at_line(fmt::format("{} must be a number", table.header[k]));
      return *x;
    };
    if (row.size() != table.header.size())
      at_line(fmt::format("has {} fields, the header has {}", row.size(), table.header.size()));
    const auto& name = row[quantity];
    if (std::ranges::find(known, name) == known.end())
      at_line(fmt::format("the study has no measure or derived column \"{}\"; it has {}", name,
                          fmt::join(known, ", ")));
    MeasuredPoint point;
    for (std::size_t k = 0; k < axes.size(); ++k) point.at.push_back(number(axes[k]) / study.axes[k].scale);
    if (std::ranges::none_of(cells, [&](const auto& cell) { return same_place(study, point.at, cell); }))
      at_line("the study makes no run at these values of its axes");
    point.value = number(value);
    if (uncertainty < row.size() && !row[uncertainty].empty()) point.uncertainty = number(uncertainty);
    if (point.uncertainty < 0) at_line("uncertainty must be ≥ 0");
    auto found = std::ranges::find(list, name, &MeasuredQuantity::name);
    if (found == list.end()) found = list.insert(list.end(), {name, {}});
    found->points.push_back(point);
  }
  if (list.empty()) fail("has no values");
  return list;
}

QuantityReader::QuantityReader(const Study& study) : names_(quantities_of(study)), derive_(study) {}

double QuantityReader::operator()(const std::string& name, const RunRow& run) const {
  const auto at = static_cast<std::size_t>(std::ranges::find(names_, name) - names_.begin());
  return at < run.measures.size() ? run.measures[at] : derive_(run)[at - run.measures.size()];
}

std::vector<PointAgreement> agreement_with(const Study& study, const std::vector<MeasuredQuantity>& measured,
                                           const std::vector<RunRow>& runs) {
  const QuantityReader quantity(study);
  std::vector<PointAgreement> all;
  for (const auto& v : study.variants)
    for (const auto& formulation : v.formulations)
      for (const auto& m : measured) {
        PointAgreement a{.variant = v.name, .formulation = formulation, .quantity = m.name};
        a.decided = true;
        double squares = 0;
        for (std::size_t i = 0; i < m.points.size(); ++i) {
          const auto& p = m.points[i];
          double sum = 0;
          int starts = 0;
          for (const auto& run : runs) {
            if (run.variant != v.name || run.formulation != formulation ||
                !same_place(study, p.at, run.values))
              continue;
            sum += quantity(m.name, run);
            ++starts;
          }
          const double model = starts > 0 ? sum / starts : std::nan(""), off = model - p.value;
          a.model.push_back(model);
          squares += off * off;
          if (!(std::abs(off) <= std::abs(a.greatest))) a.greatest = off, a.greatest_at = i;
          a.outside += !(std::abs(off) <= 2 * p.uncertainty);
          a.decided = a.decided && p.uncertainty > 0 && std::isfinite(model);
        }
        a.rms = std::sqrt(squares / static_cast<double>(m.points.size()));
        all.push_back(std::move(a));
      }
  return all;
}

}  // namespace freeplay
