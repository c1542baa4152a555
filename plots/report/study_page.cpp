#include "plots/report/study_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/files/escaping.hpp"
#include "io/files/input_file.hpp"
#include "measure/turns.hpp"
#include "mechanism/error.hpp"
#include "plots/report/facts.hpp"
#include "plots/report/thinning.hpp"
#include "plots/studies/sweep_runs.hpp"
#include "plots/tables/table.hpp"
#include "study/store/database.hpp"

namespace freeplay::report {
namespace {

using nlohmann::json;
using Statement = Database::Statement;

constexpr std::size_t most_runs = 5000;       // limit of the runs of a sweep on a page
constexpr std::size_t most_points = 120'000;  // limit, of a diagram
constexpr long values_of_a_sparkline = 64;

bool has(const Database& database, const char* name) {
  Statement s(database, "SELECT 1 FROM sqlite_master WHERE name = ?");
  return s.bind(std::string(name)).step();
}

/// Acceleration over the last turn of a run, found by its digest; empty if there is none.
json sparkline(Statement& of_run, const std::string& run) {
  of_run.again();
  of_run.bind(run);
  auto list = json::array();
  if (!of_run.step()) return list;
  const auto values = of_run.floats(0);
  Thinning thinned(static_cast<long>(values.size()), 1, values_of_a_sparkline);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double y = values[i];
    thinned.take(static_cast<double>(i), {&y, 1});
  }
  thinned.finish();
  return numbers(thinned.column(0), 3);
}

/// The option -o of a study's command; empty for the default folder out/NAME of the study file.
std::string output_of(const char* verb, const std::filesystem::path& file,
                      const std::filesystem::path& folder) {
  const auto place = std::filesystem::absolute(folder).lexically_normal();
  const auto name = place.filename().string();
  const bool in_out = place.parent_path().filename() == "out";
  auto usual = file.stem() == "study" || file.stem() == "scene" ? file.parent_path().filename().string()
                                                                : file.stem().string();
  if (std::string_view(verb) != "sweep") usual += fmt::format("-{}", verb);
  if (in_out && name == usual) return "";
  return " -o " + shell_words({in_out ? "out/" + name : name});
}

/// The command that repeats a study. STUDY stands for its file if an older version wrote the folder.
std::string command_of(const char* verb, const JsonFile* facts, const std::filesystem::path& folder) {
  const auto file = facts ? facts->text_or_empty("provenance.study_file") : "";
  const auto* outside = facts ? facts->find("provenance.allow_outside") : nullptr;
  return fmt::format("freeplay {} {}{}{}", verb, file.empty() ? "STUDY" : shell_words({file}),
                     outside && outside->is_boolean() && outside->get<bool>() ? " --allow-outside" : "",
                     output_of(verb, file, folder));
}

/// The titles of a study and of its scene.
void set_titles(const JsonFile& facts, json& document) {
  const auto scene = facts.text_or_empty("provenance.title"),
             study = facts.text_or_empty("provenance.study_title");
  document["title"] = study.empty() ? scene : study;
  document["scene_title"] = scene;
}

json axis_of(const json& axis) {
  json out = {{"scale", 1.0}};
  const auto text = [&](const char* part) {
    return axis.contains(part) && axis[part].is_string() ? axis[part].get<std::string>() : "";
  };
  for (const char* part : {"name", "unit"}) out[part] = text(part);
  out["key"] = text("key").empty() ? "" : shell_words({text("key")});
  if (axis.contains("scale") && axis["scale"].is_number()) out["scale"] = axis["scale"];
  return out;
}

json axis_of(const JsonFile& facts, const std::string& at) {
  const auto* axis = facts.find(at);
  return axis_of(axis && axis->is_object() ? *axis : json::object());
}

/// Measures and derived columns of the study, which the page shows before the statistics.
std::vector<std::string> own_columns(const std::vector<std::string>& names, std::size_t axes) {
  const auto statistics = TurnMetrics::names();
  std::vector<std::string> own;
  for (std::size_t k = axes; k < names.size(); ++k)
    if (std::ranges::find(statistics, names[k]) == std::end(statistics)) own.push_back(names[k]);
  return own;
}

/// Adds the units of these columns, as the figures state them.
void add_units(const std::filesystem::path& folder, const std::vector<std::string>& columns, json& document) {
  try {
    const plots::SweepRuns runs(folder);
    for (const auto& name : columns)
      if (const auto& unit = runs.quantity(name).unit; !unit.empty()) document["units"][name] = unit;
  } catch (const SceneError&) {
    // Without a finished run, or without a value of a column, there is no number to which a unit applies.
  }
}

/// Adds titles, units and commands from sweep.json, which older versions did not write.
void describe_sweep(const std::filesystem::path& folder, std::size_t axes, json& document) {
  if (!std::filesystem::exists(folder / "sweep.json")) {
    document["commands"] = {command_of("sweep", nullptr, folder)};
    return;
  }
  const JsonFile facts(folder / "sweep.json");
  set_titles(facts, document);
  document["commands"] = {command_of("sweep", &facts, folder)};
  if (const auto verdict = facts.text_or_empty("verdict"); !verdict.empty()) document["verdict"] = verdict;
  if (const auto* list = facts.find("sweep.axes"); list && list->is_array() && list->size() == axes) {
    document["axis_facts"] = json::array();
    for (const auto& axis : *list)
      document["axis_facts"].push_back(axis_of(axis.is_object() ? axis : json::object()));
  }
  if (const auto* units = facts.find("sweep.units"); units && units->is_object())
    for (const auto& [name, unit] : units->items())
      if (unit.is_string()) document["units"][name] = unit;
  if (const auto* variants = facts.find("sweep.variants"); variants && variants->is_array())
    for (const auto& variant : *variants) {
      if (!variant.is_object()) continue;
      const auto name = variant.value("name", json());
      std::string set;
      if (variant.contains("overrides") && variant["overrides"].is_array())
        for (const auto& one : variant["overrides"])
          if (one.is_string()) set += " --set " + shell_words({one.get<std::string>()});
      const auto scene = variant.value("scene", json());
      if (scene.is_string() && name.is_string())
        document["variants"][name.get<std::string>()] = {{"scene", shell_words({scene.get<std::string>()})},
                                                         {"set", set}};
    }
  document["provenance"] = provenance_table({{"sweep", &facts}});
  document["scene"] =
      facts.text_or_empty("provenance.study") + "\n\n# the scene\n" + facts.text_or_empty("provenance.scene");
}

json sweep_document(const std::filesystem::path& folder) {
  const Database database(folder / "sweep.db", Database::Access::read);
  const bool named = has(database, "named");
  if (!named && !has(database, "runs"))
    throw SceneError((folder / "sweep.db").string() + ": contains no runs of a sweep");
  const std::string from = named ? "named" : "runs";
  json document = {{"kind", "sweep"}, {"title", ""}, {"runs", json::array()}};
  Statement count(database, "SELECT count(*) FROM " + from);
  document["all"] = count.step() ? count.whole(0) : 0;
  const bool traced = has(database, "traces");
  Statement trace(database,
                  traced ? "SELECT acceleration FROM traces WHERE run = ?" : "SELECT NULL WHERE ? = ''");
  Statement rows(database, "SELECT * FROM " + from + " ORDER BY variant, formulation, start");
  const auto statistics = TurnMetrics::names();
  std::vector<int> places;
  std::vector<std::string> names;
  std::size_t axes = 0;
  bool begun = false;
  while (rows.step()) {
    if (!begun) {
      bool of_axes = true;
      for (int k = 0; k < rows.columns(); ++k) {
        const auto name = rows.name(k);
        if (name == "run" || name == "variant" || name == "formulation" || name == "start" ||
            name == "status" || name == "reason" || name == "run id")
          continue;
        of_axes = of_axes && std::ranges::find(statistics, name) == std::end(statistics);
        axes += of_axes;
        names.push_back(name), places.push_back(k);
      }
      begun = true;
    }
    if (document["runs"].size() == most_runs) break;
    json run = {{"texts", json::array()}, {"values", json::array()}};
    std::string key;
    for (int k = 0; k < rows.columns(); ++k) {
      if (rows.name(k) == "run") key = rows.text(k);
      for (const char* text : {"variant", "formulation", "status", "reason"})
        if (rows.name(k) == text) run[text] = rows.text(k);
      if (rows.name(k) == "start") run["start"] = rows.whole(k);
    }
    for (std::size_t k = 0; k < places.size(); ++k) {
      const bool none = rows.absent(places[k]) || rows.is_text(places[k]);
      // Values of axes have all digits: they stand in the command that repeats the run.
      run["values"].push_back(none       ? json()
                              : k < axes ? json(rows.number(places[k]))
                                         : json(rounded(rows.number(places[k]), 6)));
    }
    run.erase("texts");
    run["key"] = key;
    run["line"] = sparkline(trace, key);
    document["runs"].push_back(std::move(run));
  }
  document["columns"] = names;
  document["axes"] = axes;
  const auto own = own_columns(names, axes);
  document["first"] = own.empty() ? std::string(statistics[TurnMetrics::ratio_median]) : own.front();
  document["own"] = own;
  describe_sweep(folder, axes, document);
  if (std::filesystem::exists(folder / "sweep.json")) add_units(folder, own, document);
  return document;
}

/// Points of a bifurcation or cells of a basin, as columns of the table by name.
json attractors_document(const std::filesystem::path& folder, const std::string& kind) {
  const JsonFile facts(folder / (kind + ".json"));
  json document = {{"kind", kind}};
  set_titles(facts, document);
  plots::Rows rows(folder / (kind + ".csv"));
  const auto& names = rows.names();
  std::vector<std::vector<double>> numbers_of(names.size());
  std::vector<std::vector<std::string>> words_of(names.size());
  const auto is_word = [&](std::size_t k) {
    return names[k] == "branch" || names[k] == "kind" || names[k] == "doubt";
  };
  // Coordinates of the axes, with enough digits for the command that repeats the run.
  const auto is_axis = [](const std::string& name) { return name == "value" || name == "x" || name == "y"; };
  long all = 0;
  std::size_t kept = 0;
  while (rows.next()) {
    ++all;
    if (kept == most_points) continue;
    ++kept;
    for (std::size_t k = 0; k < names.size(); ++k)
      if (is_word(k))
        words_of[k].push_back(rows.name(k));
      else
        numbers_of[k].push_back(rows.maybe_number(k));
  }
  document["all"] = all;
  document["columns"] = json::array();
  for (std::size_t k = 0; k < names.size(); ++k)
    document["columns"].push_back(
        is_word(k) ? json{{"name", names[k]}, {"words", words_of[k]}}
                   : json{{"name", names[k]}, {"y", numbers(numbers_of[k], is_axis(names[k]) ? 15 : 6)}});
  for (const char* part : {"axis", "x", "y"})
    if (facts.find(kind + "." + part)) document[part] = axis_of(facts, kind + "." + part);
  document["formulation"] = facts.text_or_empty(kind + ".formulation");
  document["section"] = facts.text_or_empty(kind + ".section");
  const auto scene = facts.text_or_empty("provenance.scene_file");
  document["scene_file"] = shell_words({scene});
  document["overrides"] = overrides_of(facts);
  document["provenance"] = provenance_table({{kind, &facts}});
  document["scene"] =
      facts.text_or_empty("provenance.study") + "\n\n# the scene\n" + facts.text_or_empty("provenance.scene");
  document["commands"] = {command_of(kind.c_str(), &facts, folder)};
  return document;
}

}  // namespace

bool holds_study(const std::filesystem::path& folder) {
  return std::ranges::any_of(std::array{"sweep.db", "bifurcation.csv", "basin.csv"},
                             [&](const char* name) { return std::filesystem::exists(folder / name); });
}

json study_document(const std::filesystem::path& folder) {
  json document;
  for (const char* kind : {"bifurcation", "basin"})
    if (document.is_null() && std::filesystem::exists(folder / (std::string(kind) + ".csv")))
      document = attractors_document(folder, kind);
  if (document.is_null()) document = sweep_document(folder);
  document["notes"] = json::array();
  document["tables"] = json::array();
  return document;
}

}  // namespace freeplay::report
