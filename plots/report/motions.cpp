#include "plots/report/motions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/escaping.hpp"
#include "io/files/input_file.hpp"
#include "plots/report/facts.hpp"
#include "plots/report/page.hpp"
#include "values/table.hpp"

namespace freeplay::report {
namespace {

using nlohmann::json;
using Path = std::filesystem::path;

constexpr std::size_t most_table_rows = 1000;          // of a table
constexpr std::uint64_t most_of_a_picture = 4u << 20;  // bytes

std::string nine_digits(const json& value) { return text_of(value, 9); }

/// Whether the last part of a path names an error, which has few digits.
bool is_error(std::string_view path) {
  return path.ends_with("residual") || path.ends_with("_error") || path.ends_with("_error_per_s");
}

/// An error as text.
std::string error_digits(const json& value) {
  return value.is_number() ? fmt::format("{:.3g}", value.get<double>()) : "–";
}

/// nine_digits() of a member of an object, error_digits() of an error.
std::string part(const json& object, const char* key) {
  if (!object.is_object() || !object.contains(key)) return "–";
  return is_error(key) ? error_digits(object.at(key)) : nine_digits(object.at(key));
}

json number_of(const JsonFile& file, const std::string& path) {
  const auto* value = file.find(path);
  return value ? *value : json();
}

/// A list of the file; empty if there is none.
json list_of(const JsonFile& file, const std::string& path) {
  const auto* value = file.find(path);
  return value && value->is_array() ? *value : json::array();
}

/// Table of the list at `path`: a column for each pair of title and key.
json list_table(const std::string& title, const json& list,
                const std::vector<std::pair<std::string, const char*>>& columns) {
  Table table;
  for (const auto& column : columns) table.column(column.first);
  for (const auto& one : list) {
    if (table.rows().size() == most_table_rows)
      return page_table(fmt::format("{}, the first {} of {}", title, most_table_rows, list.size()), table);
    std::vector<Table::Cell> row;
    for (const auto& column : columns) row.emplace_back(part(one, column.second));
    table.row(std::move(row));
  }
  return page_table(title, table);
}

/// Table of values of the file with their names; without those that it lacks.
json value_table(const std::string& title, const JsonFile& file,
                 const std::vector<std::pair<std::string, const char*>>& values) {
  Table table;
  for (const auto& [name, path] : values) {
    const auto* value = file.find(path);
    if (!value || value->is_null()) continue;
    if (const auto text = is_error(path) ? error_digits(*value) : nine_digits(*value); !text.empty())
      table.row(name, text);
  }
  return page_table(title, table);
}

/// Adds a table that is not empty; a wide one has the width of the page.
void add_table(json& document, json table, bool wide = false) {
  if (wide) table["wide"] = true;
  if (!table["rows"].empty()) document["tables"].push_back(std::move(table));
}

/// Multipliers, which are pairs of numbers in the file, with their moduli.
json multipliers_table(const json& list) {
  Table table("real part,imaginary part,modulus");
  for (const auto& m : list)
    if (m.is_array() && m.size() == 2 && m[0].is_number() && m[1].is_number() &&
        table.rows().size() < most_table_rows)
      table.row(nine_digits(m[0]), nine_digits(m[1]),
                nine_digits(std::hypot(m[0].get<double>(), m[1].get<double>())));
  return page_table("Floquet multipliers", table);
}

void add_orbit(const JsonFile& file, json& document) {
  add_table(document, value_table("Periodic motion", file,
                                  {{"stable", "stable"},
                                   {"period, s", "period_s"},
                                   {"number of periods", "periods"},
                                   {"residual", "residual"},
                                   {"change with finer steps, in the unit of the residual", "step_error"},
                                   {"Newton steps", "iterations"},
                                   {"time of the section, s", "state.t"},
                                   {"change of the shifted coordinates, m or rad", "shift.change"}}));
  add_table(document, multipliers_table(list_of(file, "multipliers")));
  add_table(document, list_table("Contact onsets of the motion", list_of(file, "impacts"),
                                 {{"t, s", "time"}, {"joint", "joint"}, {"approach speed, m/s", "speed"}}));
  add_table(document,
            list_table("Contacts that last during the whole motion", list_of(file, "lasting"),
                       {{"joint", "joint"}, {"least force, N", "least_force"}, {"at t, s", "time"}}));
}

/// The list with values of a key at `name` in the unit of the study, which the head of the column names.
json scaled(json list, const char* name, const JsonFile& file) {
  const auto scale = number_of(file, "continue.scale");
  for (auto& one : list)
    if (scale.is_number() && one.is_object() && one.contains(name) && one[name].is_number())
      one[name] = scale.get<double>() * one[name].get<double>();
  return list;
}

void add_branches(const JsonFile& file, json& document) {
  const auto unit = file.text_or_empty("continue.unit");
  const auto key = file.text_or_empty("continue.key") + (unit.empty() ? "" : ", " + unit);
  add_table(document,
            list_table("Bifurcations", scaled(list_of(file, "continue.bifurcations"), "parameter", file),
                       {{"kind", "kind"},
                        {key, "parameter"},
                        {"period, s", "period_s"},
                        {"branch", "branch"},
                        {"joint", "joint"},
                        {"what follows", "follows"},
                        {"new branch", "new_branch"},
                        {"residual", "residual"}}),
            true);
  add_table(
      document,
      list_table("Branches of periodic motions", list_of(file, "continue.branches"),
                 {{"branch", "branch"}, {"motions", "points"}, {"begins at", "begins"}, {"ends", "ends"}}),
      true);
  auto curves = scaled(list_of(file, "continue.second.curves"), "parameter", file);
  for (auto& curve : curves)
    if (curve.is_object() && curve.contains("ends") && curve["ends"].is_array() && curve["ends"].size() == 2)
      curve["first end"] = curve["ends"][0], curve["last end"] = curve["ends"][1];
  add_table(document,
            list_table("Curves over " + file.text_or_empty("continue.second.key"), curves,
                       {{"curve", "curve"},
                        {"kind", "kind"},
                        {"begins at " + key, "parameter"},
                        {"points", "points"},
                        {"first end", "first end"},
                        {"last end", "last end"}}),
            true);
}

void add_exponents(const JsonFile& file, json& document) {
  auto list = list_of(file, "exponents");
  for (auto& e : list)
    if (e.is_object() && part(e, "per_s") == "–") e["per_s"] = "−∞";
  add_table(document, list_table("Lyapunov exponents", list,
                                 {{"1/s", "per_s"},
                                  {"standard error, 1/s", "standard_error_per_s"},
                                  {"per period", "per_period"},
                                  {"reason", "reason"}}));
  auto sum = value_table("Sum of the exponents", file,
                         {{"sum, 1/s", "sum_per_s"},
                          {"its standard error, 1/s", "sum_standard_error_per_s"},
                          {"predicted by divergence and impacts, 1/s", "sum_predicted_per_s"},
                          {"part of the divergence, 1/s", "divergence_per_s"},
                          {"part of the impacts, 1/s", "impacts_part_per_s"},
                          {"not predicted", "not_predicted"}});
  if (const auto found = number_of(file, "sum_per_s"), predicted = number_of(file, "sum_predicted_per_s");
      found.is_number() && predicted.is_number())
    sum["rows"].push_back(
        {"sum minus prediction, 1/s", fmt::format("{:.3g}", found.get<double>() - predicted.get<double>())});
  add_table(document, sum);
  add_table(document, value_table("Run of the exponents", file,
                                  {{"excluded transient, s", "transient_s"},
                                   {"evaluated time, s", "duration_s"},
                                   {"batches", "batches"},
                                   {"contact onsets", "impacts"},
                                   {"period of the drives, s", "period_s"},
                                   {"time over that of a run alone", "cost_over_run"},
                                   {"ended early", "stopped"}}));
}

/// The figures of one kind of results, as far as the folder has them.
void add_pictures(const Path& folder, const std::vector<std::pair<const char*, const char*>>& figures,
                  json& document) {
  constexpr std::string_view signature = "\x89PNG\r\n\x1a\n";
  for (const auto& [name, title] : figures) {
    const auto file = folder / "figures" / (std::string(name) + ".png");
    std::error_code none;
    if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(file, none))) continue;
    const auto bytes = read_file(file, most_of_a_picture);
    if (bytes.starts_with(signature))
      document["pictures"].push_back({{"title", title}, {"png", base64(bytes)}});
  }
}

/// A command that repeats the results, to be called in the folder of the page.
std::string motion_command(const char* verb, const JsonFile& file) {
  const auto scene = file.text_or_empty("provenance.scene_file");
  const auto formulation = file.text_or_empty("formulation");
  return fmt::format("freeplay {} {}{}{}", verb, scene.empty() ? "SCENE" : shell_words({scene}),
                     formulation.empty() ? "" : " --formulation " + shell_words({formulation}),
                     overrides_of(file));
}

std::string orbit_command(const JsonFile& file) {
  auto command = motion_command("orbit", file);
  for (const auto& [option, path] :
       {std::pair{"--periods", "periods"}, {"--settle", "settle"}, {"--period", "period_given_s"}})
    if (const auto value = number_of(file, path); value.is_number())
      command += fmt::format(" {} {}", option, value.dump());
  for (const auto& one : list_of(file, "shift.coordinates"))
    if (one.is_string()) command += " --shift " + shell_words({one.get<std::string>()});
  return command;
}

/// The command of `continue`; STUDY stands for a study that the file does not name.
std::string continue_command(const JsonFile& file) {
  const auto study = file.text_or_empty("provenance.study_file");
  return "freeplay continue " + (study.empty() ? "STUDY" : shell_words({study}));
}

struct MotionKind {
  const char* name;  ///< as data.kind of the page
  const char* file;
  void (*add)(const JsonFile&, json&);
  std::string (*command)(const JsonFile&);
  std::vector<std::pair<const char*, const char*>> figures;
};
const std::vector<MotionKind>& motion_kinds() {
  static const std::vector<MotionKind> list = {
      {"orbit",
       "orbit.json",
       add_orbit,
       orbit_command,
       {{"orbit", "Phase portraits"}, {"multipliers", "Multipliers and the unit circle"}}},
      {"continue",
       "continue.json",
       add_branches,
       continue_command,
       {{"branch", "Branches"}, {"curves", "Curves of bifurcations over two keys"}}},
      {"lyapunov",
       "lyapunov.json",
       add_exponents,
       [](const JsonFile& file) { return motion_command("lyapunov", file); },
       {{"lyapunov", "Convergence of the exponents"}}}};
  return list;
}

}  // namespace

bool holds_motions(const Path& folder) {
  return std::filesystem::exists(folder / "continue.json") ||
         std::filesystem::exists(folder / "lyapunov.json");
}

json motions_document(const Path& folder) {
  json document = {{"notes", json::array()}, {"tables", json::array()}};
  for (const auto& kind : motion_kinds()) {
    if (!std::filesystem::exists(folder / kind.file)) continue;
    const JsonFile file(folder / kind.file);
    document["kind"] = kind.name;
    const auto study = file.text_or_empty("provenance.study_title"),
               scene = file.text_or_empty("provenance.title");
    document["title"] = study.empty() ? scene : study;
    document["scene_title"] = scene;
    document["provenance"] = provenance_table({{kind.name, &file}});
    const auto text = file.text_or_empty("provenance.study");
    document["scene"] =
        (text.empty() ? "" : text + "\n\n# the scene\n") + file.text_or_empty("provenance.scene");
  }
  document["commands"] = json::array();
  return document;
}

void add_motions(const Path& folder, json& document) {
  json later = std::move(document["tables"]);
  document["tables"] = json::array();
  for (const auto& kind : motion_kinds()) {
    if (!std::filesystem::exists(folder / kind.file)) continue;
    const JsonFile file(folder / kind.file);
    kind.add(file, document);
    add_pictures(folder, kind.figures, document);
    document["commands"].push_back(kind.command(file));
  }
  for (auto& table : later) document["tables"].push_back(std::move(table));
}

}  // namespace freeplay::report
