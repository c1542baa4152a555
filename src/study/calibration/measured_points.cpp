#include "study/calibration/measured_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/files/input_file.hpp"
#include "io/scene/points_file.hpp"
#include "study/runs/case_run.hpp"

namespace freeplay {
namespace {

std::vector<std::string> quantities_of(const Study& study) {
  std::vector<std::string> names;
  for (const auto& m : study.measures) names.push_back(m.name);
  for (const auto& d : study.derived) names.push_back(d.name);
  return names;
}

/// Equal up to the rounding of a change of unit.
bool same_place(const std::vector<double>& a, const std::vector<double>& b) {
  return std::ranges::equal(a, b,
                            [](double x, double y) { return std::abs(x - y) <= 1e-9 * std::abs(x + y); });
}

}  // namespace

std::vector<MeasuredQuantity> read_measured_points(const Study& study) {
  const auto file = study.points.string();
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
      const auto x = k < row.size() ? number_in(row[k]) : std::nullopt;
      if (!x) at_line(fmt::format("{} must be a number", table.header[k]));
      return *x;
    };
    const std::string name = quantity < row.size() ? row[quantity] : "";
    if (std::ranges::find(known, name) == known.end())
      at_line(fmt::format("the study has no measure or derived column \"{}\"; it has {}", name,
                          fmt::join(known, ", ")));
    MeasuredPoint point;
    for (std::size_t k = 0; k < axes.size(); ++k) point.at.push_back(number(axes[k]) / study.axes[k].scale);
    if (std::ranges::none_of(cells, [&](const auto& cell) { return same_place(cell, point.at); }))
      at_line("the study makes no run at these values of its axes");
    point.value = number(value);
    if (uncertainty < table.header.size()) point.uncertainty = number(uncertainty);
    if (point.uncertainty < 0) at_line("uncertainty must be ≥ 0");
    auto found = std::ranges::find(list, name, &MeasuredQuantity::name);
    if (found == list.end()) found = list.insert(list.end(), {name, {}});
    found->points.push_back(point);
  }
  if (list.empty()) fail("has no values");
  return list;
}

std::vector<PointAgreement> agreement_with(const Study& study, const std::vector<MeasuredQuantity>& measured,
                                           const std::vector<RunRow>& runs) {
  const Deriver derive(study);
  const auto known = quantities_of(study);
  std::vector<PointAgreement> all;
  for (const auto& v : study.variants)
    for (const auto& formulation : v.formulations)
      for (const auto& m : measured) {
        const auto at = static_cast<std::size_t>(std::ranges::find(known, m.name) - known.begin());
        PointAgreement a{.variant = v.name, .formulation = formulation, .quantity = m.name};
        a.decided = true;
        double squares = 0;
        for (std::size_t i = 0; i < m.points.size(); ++i) {
          const auto& p = m.points[i];
          double sum = 0;
          int starts = 0;
          for (const auto& run : runs) {
            if (run.variant != v.name || run.formulation != formulation || !same_place(run.values, p.at))
              continue;
            sum += at < run.measures.size() ? run.measures[at] : derive(run)[at - run.measures.size()];
            ++starts;
          }
          const double model = starts > 0 ? sum / starts : std::nan(""), off = model - p.value;
          a.model.push_back(model);
          squares += off * off;
          if (std::abs(off) > std::abs(a.greatest)) a.greatest = off, a.greatest_at = i;
          a.outside += !(std::abs(off) <= 2 * p.uncertainty);
          a.decided = a.decided && p.uncertainty > 0 && std::isfinite(model);
        }
        a.rms = std::sqrt(squares / static_cast<double>(m.points.size()));
        all.push_back(std::move(a));
      }
  return all;
}

}  // namespace freeplay
