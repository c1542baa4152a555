#include "plots/report/facts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/files/escaping.hpp"
#include "plots/tables/columns.hpp"
#include "values/table.hpp"
#include "values/warning.hpp"

namespace freeplay::report {
namespace {

using nlohmann::json;

std::string shown(const json& value) { return value.is_structured() ? "" : text_of(value, 6); }

/// The words of a key such as greatest_impulse_N_s, with its unit after a comma.
std::string words_of(const std::string& key) {
  const auto number = plots::number_of_run(key);
  return number.words + (number.unit.empty() ? "" : ", " + number.unit);
}

/// Table of objects, one for each file or null: one row per key, one column per file.
json side_by_side(const std::string& title, const std::vector<RunFacts>& runs,
                  const std::vector<const json*>& objects, const std::string& unit) {
  Table table("");
  std::vector<std::string> keys;
  for (const auto& run : runs) table.column(run.name);
  for (const auto* object : objects) {
    if (!object) continue;
    for (const auto& [key, value] : object->items())
      if (!value.is_structured() && std::ranges::find(keys, key) == keys.end()) keys.push_back(key);
  }
  for (const auto& key : keys) {
    std::vector<Table::Cell> row{words_of(key) + unit};
    for (const auto* object : objects)
      row.emplace_back(object && object->contains(key) ? shown(object->at(key)) : "–");
    table.row(std::move(row));
  }
  return page_table(title, table);
}

/// The objects at `path` in the files.
std::vector<const json*> objects_at(const std::vector<RunFacts>& runs, const std::string& path) {
  std::vector<const json*> list;
  for (const auto& run : runs) {
    const auto* object = run.json->find(path);
    list.push_back(object && object->is_object() ? object : nullptr);
  }
  return list;
}

void add(json& list, json table) {
  if (!table["rows"].empty()) list.push_back(std::move(table));
}

}  // namespace

std::string text_of(const json& value, int digits) {
  if (value.is_number_float()) return fmt::format("{:.{}g}", value.get<double>(), digits);
  if (value.is_number_integer()) return fmt::format("{}", value.get<std::int64_t>());
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_string()) return value.get<std::string>();
  return "–";
}

json page_table(const std::string& title, const Table& table) {
  auto rows = json::array();
  for (const auto& row : table.rows()) {
    auto& cells = rows.emplace_back(json::array());
    for (const auto& cell : row) std::visit([&](const auto& x) { cells.push_back(x); }, cell);
  }
  return {{"title", title}, {"head", table.columns()}, {"rows", std::move(rows)}};
}

json tables(const std::vector<RunFacts>& runs) {
  constexpr std::size_t most = 40;  // limit of contacts
  auto list = json::array();
  const auto add_at = [&](const char* title, const char* path, const char* unit) {
    add(list, side_by_side(title, runs, objects_at(runs, path), unit));
  };
  add_at("Energy balance, whole run", "energy_J", ", J");
  add_at("Energy after the discarded time", "window.energy_J", ", J");
  // Names of contacts may contain dots, so that they cannot be part of a path.
  const auto all = objects_at(runs, "contacts");
  std::vector<std::string> contacts;
  for (const auto* some : all)
    if (some)
      for (const auto& [name, value] : some->items())
        if (value.is_object() && std::ranges::find(contacts, name) == contacts.end())
          contacts.push_back(name);
  for (std::size_t i = 0; i < std::min(most, contacts.size()); ++i) {
    std::vector<const json*> found;
    for (const auto* some : all) {
      const auto contact = some ? some->find(contacts[i]) : json::const_iterator();
      found.push_back(some && contact != some->end() && contact->is_object() ? &*contact : nullptr);
    }
    add(list, side_by_side("Contact " + contacts[i], runs, found, ""));
  }
  if (contacts.size() > most)
    list.push_back(page_table(fmt::format("{} more contacts in run.json", contacts.size() - most), Table()));
  add_at("Computational work", "work", "");
  add_at("Cost", "cost", "");
  return list;
}

json markdown_tables(const std::filesystem::path& file) {
  auto list = json::array();
  std::istringstream in(read_file(file, most_of_a_text));
  std::string line, said;
  bool in_table = false;
  const auto cells = [](const std::string& text) {
    auto row = json::array();
    std::size_t at = 1;
    while (at < text.size()) {
      const auto to = text.find('|', at);
      if (to == text.npos) break;
      auto cell = text.substr(at, to - at);
      const auto first = cell.find_first_not_of(' ');
      row.push_back(first == cell.npos ? "" : cell.substr(first, cell.find_last_not_of(' ') - first + 1));
      at = to + 1;
    }
    return row;
  };
  const auto say = [&] {
    if (!said.empty()) list.push_back({{"text", said}});
    said.clear();
  };
  while (std::getline(in, line)) {
    // \* is *
    for (std::size_t at = 0; (at = line.find("\\*", at)) != line.npos; ++at) line.erase(at, 1);
    if (line.starts_with("| ---")) continue;
    if (line.starts_with('|')) {
      say();
      if (!in_table)
        list.push_back({{"title", ""}, {"head", cells(line)}, {"rows", json::array()}});
      else
        list.back()["rows"].push_back(cells(line));
      in_table = true;
      continue;
    }
    in_table = false;
    if (line.empty())
      say();
    else if (line.starts_with("## "))
      say(), said = line.substr(3);
    else if (!line.starts_with('#'))
      said += (said.empty() ? "" : "\n") + line;
  }
  say();
  return list;
}

json notes(const std::vector<RunFacts>& runs) {
  auto list = json::array();
  const auto add_note = [&](bool doubtful, const std::string& text) {
    if (std::ranges::any_of(list, [&](const json& n) { return n["text"] == text; })) return;
    list.push_back({{"doubtful", doubtful}, {"text", text}});
  };
  for (const auto& run : runs) {
    const auto status = run.json->text_or_empty("ending.status"),
               reason = run.json->text_or_empty("ending.reason");
    if (!status.empty() && status != "finished")
      add_note(true,
               fmt::format("{}: the run is {}{}{}", run.name, status, reason.empty() ? "" : ": ", reason));
    if (const auto* said = run.json->find("notes"); said && said->is_array())
      for (const auto& note : *said)
        if (note.is_string()) {
          const auto text = note.get<std::string>();
          add_note(is_warning(text), run.name + ": " + text);
        }
  }
  std::stable_sort(list.begin(), list.end(), [](const json& a, const json& b) {
    return a["doubtful"].get<bool>() && !b["doubtful"].get<bool>();
  });
  return list;
}

json provenance_table(const std::vector<RunFacts>& files) {
  Table table("");
  for (const auto& file : files) table.column(file.name);
  for (const auto& [path, what] : {std::pair{"provenance.version", "freeplay"},
                                   {"provenance.commit", "commit"},
                                   {"provenance.identity.digest", "digest of the identity"},
                                   {"provenance.scene_file", "scene"},
                                   {"provenance.format_note", "format"}}) {
    std::vector<Table::Cell> row{what};
    bool said = false;
    for (const auto& file : files) {
      auto text = file.json->text_or_empty(path);
      said = said || !text.empty();
      row.emplace_back(std::move(text));
    }
    if (said) table.row(std::move(row));
  }
  std::vector<Table::Cell> made{"program"};
  for (const auto& file : files) {
    std::string text;
    if (const auto* lines = file.json->find("provenance.identity.program"); lines && lines->is_array())
      for (const auto& line : *lines)
        if (line.is_string()) text += (text.empty() ? "" : ", ") + line.get<std::string>();
    made.emplace_back(std::move(text));
  }
  table.row(std::move(made));
  return page_table("Provenance", table);
}

std::string overrides_of(const JsonFile& file) {
  std::string out;
  if (const auto* list = file.find("provenance.overrides"); list && list->is_array())
    for (const auto& one : *list)
      if (one.is_string()) out += " --set " + shell_words({one.get<std::string>()});
  return out;
}

}  // namespace freeplay::report
