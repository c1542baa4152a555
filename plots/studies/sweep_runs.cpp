#include "plots/studies/sweep_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <tuple>

#include "io/files/escaping.hpp"
#include "io/files/input_file.hpp"
#include "io/scene/spelling.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "plots/tables/run_facts.hpp"
#include "study/store/database.hpp"
#include "study/sweep/sweep_table.hpp"

namespace freeplay::plots {
namespace {

/// Unit of a measure: as the study states it, none for a count, or that of the measured column.
std::string unit_of_measure(const JsonFile& document, const Scene* scene, const std::string& path) {
  if (const auto* given = document.find(path + "unit"); given && given->is_string())
    return given->get<std::string>();
  if (document.text(path + "reduce") == "count") return "";
  const auto column = document.text(path + "column");
  auto unit = scene ? unit_of_instrument(*scene, column) : "";
  if (unit.empty()) unit = unit_of_column(column);
  return std::string(unit.empty() ? number_of_run(column).unit : unit);
}

const nlohmann::json& list_of(const JsonFile& document, const char* path) {
  const auto* list = document.find(path);
  if (!list || !list->is_array()) document.fail(path, "must be a list");
  return *list;
}

/// Columns of a statement by name.
class Places {
 public:
  explicit Places(const Database::Statement& rows) {
    for (int i = 0; i < rows.columns(); ++i) names_.push_back(rows.name(i));
  }
  /// Throws SceneError if the database has no such column.
  int at(std::string_view name, const std::filesystem::path& file) const {
    const auto it = std::ranges::find(names_, name);
    if (it == names_.end())
      throw SceneError(fmt::format("{}: has no column {} that sweep.json names; run `freeplay sweep` again",
                                   file.string(), visible_brief(name, 60)));
    return static_cast<int>(it - names_.begin());
  }

 private:
  std::vector<std::string> names_;
};

}  // namespace

std::string name_with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : fmt::format("{} ({})", name, unit);
}

std::string unknown_name(const char* what, const std::string& name, const NamesByKind& lists) {
  std::vector<std::string> all;
  for (const auto& [kind, names] : lists) all.insert(all.end(), names.begin(), names.end());
  auto said = fmt::format("unknown {} {}", what, visible_brief(name, 60));
  if (name.find_first_of("+*/^()") != name.npos)
    said += "; a study is plotted by names, not by expressions; a sweep may define one in [derived]";
  else if (const auto near = nearest_word(name, all); !near.empty())
    said += fmt::format("; did you mean {}?", near);
  return said + listed_names(lists);
}

SweepRuns::SweepRuns(const std::filesystem::path& folder) {
  const auto file = folder / "sweep.db";
  if (!std::filesystem::exists(folder / "sweep.json"))
    throw SceneError(fmt::format(
        "{}: has no sweep.json with the axes and units; run `freeplay sweep STUDY -o {}` again, which finds "
        "the stored runs and writes it",
        folder.string(), folder.string()));
  const JsonFile document(folder / "sweep.json");
  for (std::size_t i = 0; i < list_of(document, "sweep.axes").size(); ++i) {
    const auto path = fmt::format("sweep.axes.{}.", i);
    const auto* drawn = document.find(path + "drawn");
    axes_.push_back({document.text(path + "name"), document.text_or_empty(path + "unit"),
                     document.number(path + "scale"), drawn && drawn->is_boolean() && drawn->get<bool>()});
  }
  const auto& statistics = TurnMetrics::names();
  for (std::size_t i = 0; i < statistics.size(); ++i)
    quantities_.push_back({std::string(statistics[i]),
                           std::string(unit_of(static_cast<TurnMetrics::Name>(i))),
                           SweepQuantity::Of::statistic, i});
  const auto scene = scene_in(document);
  std::size_t place = 0;
  for (std::size_t i = 0; i < list_of(document, "sweep.measures").size(); ++i) {
    const auto path = fmt::format("sweep.measures.{}.", i);
    auto column = document.text(path + "column");
    if (document.text(path + "reduce") != "last" || number_of_run(column).element.empty() ||
        *quantity_of_column(column).name.text())
      column.clear();  // not a number of run.json
    quantities_.push_back({document.text(path + "name"), unit_of_measure(document, scene.get(), path),
                           SweepQuantity::Of::measure, place++, std::move(column)});
  }
  for (std::size_t i = 0; i < list_of(document, "sweep.derived").size(); ++i) {
    const auto path = fmt::format("sweep.derived.{}.", i);
    quantities_.push_back({document.text(path + "name"), document.text_or_empty(path + "unit"),
                           SweepQuantity::Of::derived, place++});
  }

  const Database database(file, Database::Access::read);
  Database::Statement rows(database, "SELECT * FROM named WHERE status = 'finished'");
  const Places places(rows);
  const int variant = places.at("variant", file), formulation = places.at("formulation", file),
            start = places.at("start", file);
  std::vector<int> of_axes, of_quantities;
  for (const auto& a : axes_) of_axes.push_back(places.at(a.name, file));
  for (const auto& q : quantities_) of_quantities.push_back(places.at(q.name, file));
  while (rows.step()) {
    RunRow row{
        {}, rows.text(variant), rows.text(formulation), static_cast<int>(rows.whole(start)), {}, {}, {}, {}};
    for (const int c : of_axes) row.values.push_back(rows.number(c));
    row.measures.resize(place);
    for (std::size_t i = 0; i < quantities_.size(); ++i) {
      const auto& q = quantities_[i];
      const double value = rows.absent(of_quantities[i]) ? NAN : rows.number(of_quantities[i]);
      (q.of == SweepQuantity::Of::statistic ? row.metric[q.place] : row.measures[q.place]) = value;
    }
    rows_.push_back(std::move(row));
  }
  if (rows_.empty()) throw SceneError(file.string() + ": contains no finished run");
  std::ranges::stable_sort(
      rows_, {}, [](const RunRow& r) { return std::tie(r.variant, r.formulation, r.values, r.start); });
  for (const auto& r : rows_)
    if (cells_.empty() || std::tie(cells_.back().variant, cells_.back().formulation, cells_.back().values) !=
                              std::tie(r.variant, r.formulation, r.values))
      cells_.push_back({r.variant, r.formulation, r.values});
  // Statistics that no run has cannot be drawn.
  std::erase_if(quantities_, [&](const SweepQuantity& q) {
    return q.of == SweepQuantity::Of::statistic &&
           std::ranges::none_of(rows_, [&](const RunRow& r) { return std::isfinite(r.metric[q.place]); });
  });
}

const SweepQuantity& SweepRuns::quantity(const std::string& name) const {
  const auto it = std::ranges::find(quantities_, name, &SweepQuantity::name);
  if (it == quantities_.end()) throw SceneError("--y: " + unknown(name));
  return *it;
}

std::string SweepRuns::unknown(const std::string& name) const {
  std::vector<std::pair<std::string, std::vector<std::string>>> lists{
      {"measures", {}}, {"derived", {}}, {"statistics", {}}};
  for (const auto& q : quantities_)
    lists[q.of == SweepQuantity::Of::measure   ? 0
          : q.of == SweepQuantity::Of::derived ? 1
                                               : 2]
        .second.push_back(q.name);
  return unknown_name("measure", name, lists);
}

std::size_t SweepRuns::axis(const std::string& name) const {
  const auto it = std::ranges::find(axes_, name, &SweepAxis::name);
  if (it != axes_.end()) return static_cast<std::size_t>(it - axes_.begin());
  std::vector<std::string> names;
  for (const auto& a : axes_) names.push_back(a.name);
  throw SceneError("--x: " + unknown_name("axis", name, {{"axes", names}}));
}

Interval SweepRuns::at(const SweepCell& cell, const SweepQuantity& quantity) const {
  const auto before = [](const RunRow& r, const SweepCell& c) {
    return std::tie(r.variant, r.formulation, r.values) < std::tie(c.variant, c.formulation, c.values);
  };
  std::vector<RunRow> runs;
  for (auto it = std::lower_bound(rows_.begin(), rows_.end(), cell, before);
       it != rows_.end() && it->variant == cell.variant && it->formulation == cell.formulation &&
       it->values == cell.values;
       ++it)
    runs.push_back(*it);
  if (quantity.of == SweepQuantity::Of::statistic)
    return freeplay::cell(runs, cell.variant, cell.formulation, cell.values,
                          static_cast<TurnMetrics::Name>(quantity.place));
  std::vector<double> values;
  for (const auto& r : runs) values.push_back(r.measures[quantity.place]);
  return interval(values);
}

}  // namespace freeplay::plots
