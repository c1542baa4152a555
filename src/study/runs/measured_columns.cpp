#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "facade/simulation.hpp"
#include "io/files/escaping.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/schema.hpp"
#include "mechanism/scene.hpp"
#include "simulation/statistics.hpp"
#include "simulation/table_rows.hpp"
#include "study/runs/measurer.hpp"

namespace freeplay {

// Columns and numbers that measures of a study can use, and messages about unknown ones.

namespace {

/// All numbers in run.json, by their paths. Paths of numbers of a contact begin with the contact's
/// name.
void numbers_of(const nlohmann::json& node, const std::string& path, std::map<std::string, double>& all) {
  if (node.is_number()) all[path] = node.get<double>();
  if (!node.is_object()) return;
  for (const auto& [key, inner] : node.items()) {
    // These do not describe the motion.
    if (path.empty() && (key == "cost" || key == "ending")) continue;
    const bool contacts = path.empty() && key == "contacts";
    numbers_of(inner, contacts ? "" : path.empty() ? key : path + "." + key, all);
  }
}

/// Short list of columns for messages, "crank, rod .x .y; gudgeon .ex .ey": names with equal parts
/// are grouped. Limited in length.
std::string shown(const std::vector<std::string>& names) {
  std::vector<std::pair<std::string, std::string>> owners;  // owners and their parts
  for (const auto& name : names) {
    const auto dot = name.find('.');
    const auto owner = name.substr(0, dot), part = dot == name.npos ? "" : " " + name.substr(dot);
    const auto known = std::ranges::find(owners, owner, &std::pair<std::string, std::string>::first);
    if (known == owners.end())
      owners.emplace_back(owner, part);
    else if (known->second.find(part) == std::string::npos)
      known->second += part;
  }
  std::vector<std::pair<std::string, std::string>> parts;  // parts and their owners
  for (const auto& [owner, part] : owners) {
    const auto known = std::ranges::find(parts, part, &std::pair<std::string, std::string>::first);
    if (known == parts.end())
      parts.emplace_back(part, owner);
    else
      known->second += ", " + owner;
  }
  std::string text;
  constexpr std::size_t longest = 600;
  for (const auto& [part, all] : parts) {
    const auto piece = (text.empty() ? "" : "; ") + all + part;
    if (text.size() + piece.size() > longest) return text + "; ...";
    text += piece;
  }
  return text.empty() ? "none" : text;
}

std::vector<std::string> names_of(const std::vector<Column>& columns) {
  std::vector<std::string> names;
  for (const auto& c : columns) names.push_back(c.name());
  return names;
}

}  // namespace

std::map<std::string, double> numbers_of(const Result& result) {
  std::map<std::string, double> all;
  numbers_of(to_json(result), "", all);
  return all;
}

void require_columns(const Study& study, const Scene& scene, Simulation& simulation, CountedTime time) {
  if (study.measures.empty()) return;
  const Measurer measurer(study, scene, simulation.layout(), time);
  const auto trajectory = names_of(trajectory_columns(simulation.layout()));
  const auto forces = names_of(force_columns(simulation.layout()));
  auto others = simulation.layout().channels;
  const auto requested = measurer.numbers_of_runs();
  if (requested.empty()) return;
  ContactStatistics contacts(0);
  WindowStatistics window(0, time.to);
  auto result =
      simulation.run({.until = simulation.t(), .observers = {&contacts, &window}, .keep_events = false});
  contacts.into(result);
  window.into(result);
  const auto numbers = numbers_of(result);
  for (const auto& m : requested) {
    if (numbers.contains(m.column)) {
      if (m.each_period || m.reduce != Reduce::last)
        throw error_at(
            study, {"measure", m.name, m.each_period ? "each" : "reduce"},
            fmt::format("{} is one number for the whole window; use reduce = \"last\", without each",
                        visible(m.column)));
      continue;
    }
    std::vector<std::string> all = trajectory;
    all.insert(all.end(), forces.begin(), forces.end());
    const auto& contacts_of = simulation.layout().contacts;
    const auto of_contact = [&](const std::string& name) {
      return std::ranges::count(contacts_of, name.substr(0, name.find('.'))) > 0;
    };
    for (const bool wanted : {true, false})
      for (const auto& [name, value] : numbers)
        if (of_contact(name) == wanted) others.push_back(name);
    all.insert(all.end(), others.begin(), others.end());
    const auto near = nearest_word(m.column, all);
    throw error_at(
        study, {"measure", m.name, "column"},
        fmt::format(
            "\"{}\" is not a column{} are\n  trajectory: {}\n  forces: {}\n  instruments and run.json: {}",
            visible(m.column), near.empty() ? "; there" : fmt::format(", did you mean {}? There", near),
            shown(trajectory), shown(forces), shown(others)));
  }
}

}  // namespace freeplay
