#include "study/calibration/measured_points.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "io/scene/points_file.hpp"
#include "io/scene/section.hpp"
#include "study/runs/case_run.hpp"
#include "study/verdicts/verdicts.hpp"

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

/// Values of a study's measures and derived columns, by name.
class QuantityReader {
 public:
  explicit QuantityReader(const Study& study) : names_(quantities_of(study)), derive_(study) {}
  /// The value in one run; NaN: absent.
  double operator()(const std::string& name, const RunRow& run) const {
    const auto at = static_cast<std::size_t>(std::ranges::find(names_, name) - names_.begin());
    return at < run.measures.size() ? run.measures[at] : derive_(run)[at - run.measures.size()];
  }

 private:
  std::vector<std::string> names_;
  Deriver derive_;
};

/// With columns that name a run, and then `columns`.
Table table_of_runs(const Study& study, std::initializer_list<const char*> columns) {
  Table table("quantity,variant,formulation");
  for (const auto& axis : study.axes) table.column(axis.name);
  for (const char* name : columns) table.column(name);
  return table;
}

/// A row of such a table.
void add(Table& table, const Study& study, const std::string& quantity, const auto& run,
         const std::vector<double>& at, std::initializer_list<double> numbers) {
  std::vector<Table::Cell> row{quantity, run.variant, run.formulation};
  for (std::size_t k = 0; k < at.size(); ++k) row.emplace_back(at[k] * study.axes[k].scale);
  row.insert(row.end(), numbers.begin(), numbers.end());
  table.row(std::move(row));
}

/// The place of a measured point in words.
std::string place(const Study& study, const MeasuredPoint& point) {
  std::string text;
  for (std::size_t k = 0; k < point.at.size(); ++k) {
    const auto& axis = study.axes[k];
    text += fmt::format("{}{} = {:.6g}{}{}", k > 0 ? ", " : "", axis.name, point.at[k] * axis.scale,
                        axis.unit.empty() ? "" : " ", axis.unit);
  }
  return text;
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
  TextRows rows(read_text(study.points));
  if (!rows.next()) fail("has no header with the names of its columns");
  const auto header = rows.fields();
  if (header.size() == 1)
    if (const auto what = wrong_separator(header.front()); !what.empty()) fail(what);
  const auto column = [&](const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(header, name) - header.begin());
  };
  const auto needed = [&](const std::string& name) {
    if (column(name) == header.size()) fail(fmt::format("line 1: the column {} is missing", name));
    return column(name);
  };
  const auto quantity = needed("quantity"), value = needed("value"), uncertainty = column("uncertainty");
  std::vector<std::size_t> axes;
  for (const auto& axis : study.axes) axes.push_back(needed(axis.name));
  const auto known = quantities_of(study);
  std::vector<std::vector<double>> cells;
  for (const auto& one : cases(study)) cells.push_back(one.values);

  std::vector<MeasuredQuantity> list;
  while (rows.next()) {
    const auto& row = rows.fields();
    const auto at_line = [&](const std::string& what) {
      fail(fmt::format("line {}: {}", rows.number(), what));
    };
    const auto number = [&](std::size_t k) {
      const auto x = number_in(row[k]);
      if (!x || !std::isfinite(*x)) at_line(fmt::format("{} must be a number", header[k]));
      return *x;
    };
    if (row.size() != header.size()) at_line(wrong_count(row.size(), header.size()));
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

std::vector<PointAgreement> agreement_with(const Study& study, const std::vector<MeasuredQuantity>& measured,
                                           const std::vector<RunRow>& runs) {
  const QuantityReader quantity(study);
  std::vector<PointAgreement> all;
  for (const auto& v : study.variants)
    for (const auto& formulation : v.formulations)
      for (const auto& m : measured) {
        PointAgreement a{
            .variant = v.name, .formulation = formulation, .quantity = m.name, .points = m.points};
        a.decided = true;
        double squares = 0;
        std::size_t greatest_at = 0;
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
          if (!(std::abs(off) <= std::abs(a.greatest))) a.greatest = off, greatest_at = i;
          a.outside += !(std::abs(off) <= 2 * p.uncertainty);
          a.decided = a.decided && p.uncertainty > 0 && std::isfinite(model);
        }
        a.greatest_at = place(study, m.points[greatest_at]);
        a.rms = std::sqrt(squares / static_cast<double>(m.points.size()));
        all.push_back(std::move(a));
      }
  return all;
}

std::string conclusion(const Study& study, const std::vector<PointAgreement>& all) {
  std::vector<PointsAgreement> models;
  for (const auto& v : study.variants)
    for (const auto& formulation : v.formulations) {
      auto worst = Agreement::Verdict::agrees;
      double squares = 0;
      int count = 0;
      for (const auto& a : all) {
        if (a.variant != v.name || a.formulation != formulation) continue;
        worst = std::max(worst, a.verdict());
        for (std::size_t i = 0; i < a.points.size(); ++i)
          squares += std::pow((a.model[i] - a.points[i].value) / a.points[i].value, 2), ++count;
      }
      models.push_back({fmt::format("{} [{}]", v.title, formulation), worst, std::sqrt(squares / count)});
    }
  return verdict(models);
}

nlohmann::json to_json(const Study& study, const std::vector<PointAgreement>& all) {
  nlohmann::json out;
  for (const auto& axis : study.axes) out["axes"].push_back({{"name", axis.name}, {"unit", axis.unit}});
  for (const auto& v : study.variants) out["variants"].push_back({{"name", v.name}, {"title", v.title}});
  for (const auto& a : all) {
    if (a.variant == all.front().variant && a.formulation == all.front().formulation)
      out["quantities"].push_back(a.quantity);
    out["agreement"].push_back({{"variant", a.variant},
                                {"formulation", a.formulation},
                                {"quantity", a.quantity},
                                {"rms", a.rms},
                                {"greatest", a.greatest},
                                {"greatest_at", a.greatest_at},
                                {"outside", a.decided ? nlohmann::json(a.outside) : nlohmann::json()},
                                {"points", a.model.size()},
                                {"verdict", text_of(a.verdict())}});
  }
  out["verdict"] = conclusion(study, all);
  return out;
}

Table points_table(const Study& study, const std::vector<PointAgreement>& all) {
  auto table = table_of_runs(study, {"measured", "uncertainty", "model"});
  for (const auto& a : all)
    for (std::size_t i = 0; i < a.points.size(); ++i) {
      const auto& p = a.points[i];
      add(table, study, a.quantity, a, p.at, {p.value, p.uncertainty, a.model[i]});
    }
  return table;
}

Table curves_table(const Study& study, const std::vector<MeasuredQuantity>& measured,
                   const std::vector<RunRow>& runs) {
  auto table = table_of_runs(study, {"model"});
  const QuantityReader quantity(study);
  for (const auto& m : measured)
    for (const auto& run : runs) add(table, study, m.name, run, run.values, {quantity(m.name, run)});
  return table;
}

}  // namespace freeplay
