#include "io/scene/section.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>

#include "io/files/digest.hpp"
#include "io/files/escaping.hpp"
#include "io/files/input_file.hpp"
#include "io/scene/quantity.hpp"
#include "io/scene/schema.hpp"
#include "io/scene/spelling.hpp"
#include "io/scene/toml_text.hpp"
#include "mechanism/magnitude.hpp"
#include "values/name_length.hpp"

namespace freeplay {
namespace {

const toml::table empty_table;

std::string_view kind_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::string:
      return "a text";
    case toml::node_type::integer:
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::table:
      return "a table";
    case toml::node_type::date:
    case toml::node_type::time:
    case toml::node_type::date_time:
      return "a date or time";
    case toml::node_type::none:
      break;
  }
  return "nothing";
}

}  // namespace

bool is_plain_name(std::string_view name) {
  return !name.empty() && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

std::string wrong_name(std::string_view name) {
  if (!is_plain_name(name)) return "a name must be made of letters, digits, _ and -";
  if (name.size() > longest_name)
    return fmt::format("a name must have at most {} characters, has {}", longest_name, name.size());
  return "";
}

std::string unknown_word(std::string_view word, const std::vector<std::string>& words) {
  std::vector<std::string> quoted;
  for (const auto& choice : words) quoted.push_back(toml_quoted(choice));
  return fmt::format("{} is unknown{}", toml_quoted(word),
                     meant(toml_quoted(word), quoted, "one of", Beside::list));
}

void SceneSource::fail(const toml::node* node, const std::string& path, const std::string& message) const {
  for (std::string key = path;;) {
    if (const auto it = overridden.find(key); it != overridden.end())
      throw SceneError(fmt::format("--set {}", visible(it->second)), visible(path), message);
    const auto dot = key.rfind('.');
    if (dot == key.npos) break;
    key.resize(dot);
  }
  const auto table_of = [](const std::string& key) {
    const auto dot = key.rfind('.');
    return dot == key.npos ? "" : key.substr(0, dot);
  };
  std::string options;  // options that set other keys of the same table, or the table itself
  for (const auto& key : order)
    if (const auto table = table_of(key); !table.empty() && (table == path || table == table_of(path)))
      options += fmt::format("{}--set {}", options.empty() ? " (with " : ", ", visible(overridden.at(key)));
  if (!options.empty()) options += ")";
  const auto where = node ? node->source().begin : toml::source_position{};
  throw SceneError(where.line == 0 ? name : fmt::format("{}:{}:{}", name, where.line, where.column),
                   visible(path), message + options);
}

void SceneSource::refuse_made(const std::string& path) const {
  const auto it = made.find(path);
  if (it == made.end()) return;
  const auto dot = path.find('.');
  const auto family = path.substr(0, dot), element = path.substr(dot + 1);
  const auto what = schema->what_is(family + ".*");
  const auto option =
      std::ranges::find_if(order, [&](const auto& key) { return key.starts_with(path + "."); });
  throw SceneError(fmt::format("--set {}", visible(option == order.end() ? path : overridden.at(*option))),
                   visible(path),
                   fmt::format("there is no such {}{}", what.substr(what.find(' ') + 1),
                               meant(element, it->second, "there is")));
}

Section::Section(const toml::table& table, std::string path, std::string pattern, const SceneSource& source)
    : table_(table), path_(std::move(path)), pattern_(std::move(pattern)), source_(&source) {}

std::string Section::full(std::string_view key) const {
  return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
}

const SchemaKey* Section::row_of(std::string_view key) const {
  return source_->schema->find(pattern_.empty() ? std::string(key) : fmt::format("{}.{}", pattern_, key));
}

void Section::lacks(std::string_view key, const std::string& message) const {
  source_->refuse_made(path_);
  fail(key, message);
}

void Section::fail(std::string_view key, const std::string& message) const {
  const toml::node* node = key.empty() ? nullptr : table_.get(key);
  source_->fail(node ? node : &table_, key.empty() ? path_ : full(key), message);
}

const toml::node* Section::take(std::string_view key) {
  assert(row_of(key) && "key not in schema");
  read_.emplace(key);
  return table_.get(key);
}

const toml::node& Section::require(const Requested& key) {
  const auto* node = take(key.name);
  if (node) return *node;
  const auto* row = row_of(key.name);
  lacks(key.name, fmt::format("is missing: {}", !key.meaning.empty() ? key.meaning
                                                : row                ? std::string_view(row->meaning)
                                                                     : "required"));
}

double Section::to_number(const toml::node& node, const Requested& key, Range range, int column) const {
  auto value = node.value<double>();
  const auto text = node.value_exact<std::string>();
  if (text && begins_with_number(*text)) {
    const auto* row = row_of(key.name);
    std::string_view unit = key.unit ? *key.unit : row ? std::string_view(row->unit) : "";
    if (const auto comma = unit.find(", "); comma != unit.npos)
      unit = column == 0 ? unit.substr(0, comma) : unit.substr(comma + 2);
    if (unit == "x and y") unit = column == 0 ? "of x" : "of y";
    const bool free = unit == "of x" || unit == "of y";
    const auto quantity = free ? read_any_quantity(*text) : read_quantity(*text, unit);
    if (!quantity.wrong.empty()) source_->fail(&node, full(key.name), quantity.wrong);
    value = quantity.value;
    if (free) {
      const auto& first = source_->given.try_emplace({path_, std::string(unit)}, quantity.unit).first->second;
      if (first != quantity.unit)
        source_->fail(
            &node, full(key.name),
            fmt::format("{} is {}, but another number of {} is {}", toml_quoted(visible_brief(*text, 60)),
                        quantity_name(quantity.unit), unit.substr(3), quantity_name(first)));
    }
  } else if (!node.is_number() || !value) {
    source_->fail(&node, full(key.name), fmt::format("must be a number, is {}", kind_of(node)));
  }
  const auto* row = row_of(key.name);
  const auto* bounds = row ? magnitude_of(row->unit) : key.unit ? magnitude_of(*key.unit) : nullptr;
  if (const auto wrong =
          wrong_number(*value, range, bounds, text ? toml_quoted(visible_brief(*text, 60)) : std::string());
      !wrong.empty())
    source_->fail(&node, full(key.name), wrong);
  return *value;
}

void Section::require_sense(std::string_view key, std::string_view unit, double x) const {
  if (const auto wrong = beyond_bounds(magnitude_of(unit), x, true); !wrong.empty()) fail(key, wrong);
}

double Section::number(const Requested& key, Range range) { return to_number(require(key), key, range); }

std::optional<double> Section::number_or(std::string_view word, const Requested& key, Range range) {
  const auto* node = take(key.name);
  if (!node) return std::nullopt;
  if (const auto text = node->value_exact<std::string>()) {
    if (*text == word) return std::nullopt;
    if (!begins_with_number(*text))
      source_->fail(node, full(key.name),
                    fmt::format("must be a number or \"{}\", is {}", word, toml_quoted(*text)));
  }
  return to_number(*node, key, range);
}

bool Section::flag(std::string_view key) {
  const auto& node = require(key);
  const auto value = node.value_exact<bool>();
  if (!value) source_->fail(&node, full(key), fmt::format("must be true or false, is {}", kind_of(node)));
  return *value;
}

std::string Section::text(const Requested& key) {
  const auto& node = require(key);
  const auto value = node.value_exact<std::string>();
  if (!value)
    source_->fail(&node, full(key.name), fmt::format("must be a text in quotes, is {}", kind_of(node)));
  return *value;
}

Vec2 Section::to_point(const toml::node& node, const Requested& key) const {
  const auto* list = node.as_array();
  if (!list || list->size() != 2)
    source_->fail(&node, full(key.name),
                  fmt::format("must be a pair [x, y], is {}",
                              list ? fmt::format("a list of {}", list->size()) : std::string(kind_of(node))));
  return {to_number((*list)[0], key, any_number, 0), to_number((*list)[1], key, any_number, 1)};
}

Vec2 Section::point(const Requested& key) { return to_point(require(key), key); }

std::vector<Vec2> Section::points(const Requested& key) { return points(key, nullptr); }

std::vector<Vec2> Section::points(const Requested& key,
                                  const std::function<Vec2(std::size_t, const std::string&)>& named) {
  const auto& node = require(key);
  const auto* list = node.as_array();
  if (!list || list->empty())
    source_->fail(
        &node, full(key.name),
        fmt::format("must be a list of pairs [[a, b], ...], is {}", list ? "an empty one" : kind_of(node)));
  std::vector<Vec2> result;
  for (const auto& item : *list)
    if (const auto name = item.value_exact<std::string>(); named && name)
      result.push_back(named(result.size(), *name));
    else
      result.push_back(to_point(item, key));
  return result;
}

std::vector<std::string> Section::names(std::string_view key) {
  const auto& node = require(key);
  std::vector<std::string> result;
  const auto* list = node.as_array();
  if (list)
    for (const auto& item : *list)
      if (const auto value = item.value_exact<std::string>()) result.push_back(*value);
  if (!list || result.size() != list->size())
    source_->fail(&node, full(key), fmt::format("must be a list of names, is {}", kind_of(node)));
  return result;
}

bool Section::is_text(std::string_view key) const {
  const auto* node = table_.get(key);
  return node && node->is_string();
}

bool Section::is_list_of_lists(std::string_view key) const {
  const auto* node = table_.get(key);
  const auto* list = node ? node->as_array() : nullptr;
  return list && !list->empty() && list->front().is_array();
}

std::vector<std::pair<std::string, Vec2>> Section::named_points(const Requested& key) {
  const auto& node = require(key);
  const auto* table = node.as_table();
  if (!table)
    source_->fail(&node, full(key.name),
                  fmt::format("must be a table of points, {{ A = [x, y], ... }}, is {}", kind_of(node)));
  std::vector<std::pair<std::string, Vec2>> result;
  for (const auto& [name, point] : *table) {
    const auto own = fmt::format("{}.{}", key.name, name.str());
    if (const auto wrong = wrong_name(name.str()); !wrong.empty()) source_->fail(&point, full(own), wrong);
    Requested one(own);
    one.unit = key.unit;
    result.emplace_back(name.str(), to_point(point, one));
  }
  return result;
}

std::vector<double> Section::numbers(const Requested& key) {
  const auto& node = require(key);
  const auto* list = node.as_array();
  if (!list || list->empty())
    source_->fail(&node, full(key.name),
                  fmt::format("must be a list of numbers, is {}", list ? "an empty one" : kind_of(node)));
  std::vector<double> result;
  for (const auto& item : *list) result.push_back(to_number(item, key, any_number));
  return result;
}

std::vector<std::vector<double>> Section::rows(std::string_view key,
                                               const std::vector<std::string_view>& units) {
  const auto& node = require(key);
  const auto* list = node.as_array();
  if (!list || list->empty())
    source_->fail(&node, full(key),
                  fmt::format("must be a list of lists [[a, b], ...], is {}", kind_of(node)));
  std::vector<std::vector<double>> result;
  for (const auto& item : *list) {
    const auto* row = item.as_array();
    if (!row || row->size() != units.size())
      source_->fail(&item, full(key),
                    fmt::format("must be a list of {} numbers, is {}", units.size(),
                                row ? fmt::format("one of {}", row->size()) : std::string(kind_of(item))));
    auto& numbers = result.emplace_back();
    for (std::size_t i = 0; i < units.size(); ++i) {
      Requested one(key);
      one.unit = units[i];
      numbers.push_back(to_number((*row)[i], one, any_number));
    }
  }
  return result;
}

std::vector<std::string> Section::name_or_names(std::string_view key) {
  return is_text(key) ? std::vector{text(key)} : names(key);
}

std::vector<std::pair<std::string, std::string>> Section::texts(std::string_view key) {
  const auto* node = take(key);
  if (!node) return {};
  const auto* table = node->as_table();
  if (!table)
    source_->fail(node, full(key),
                  fmt::format("must be a table of texts, NAME = \"...\", is {}", kind_of(*node)));
  std::vector<std::pair<toml::source_position, std::pair<std::string, std::string>>> placed;
  for (const auto& [name, item] : *table) {
    const auto own = fmt::format("{}.{}", key, name.str());
    const auto value = item.value_exact<std::string>();
    if (!value)
      source_->fail(&item, full(own), fmt::format("must be a text in quotes, is {}", kind_of(item)));
    placed.push_back({item.source().begin, {std::string(name.str()), *value}});
  }
  std::ranges::stable_sort(placed, [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::pair<std::string, std::string>> result;
  for (auto& [where, pair] : placed) result.push_back(std::move(pair));
  return result;
}

int Section::choice(std::string_view key, const std::vector<std::string>& choices) {
  const auto value = text(key);
  const auto it = std::ranges::find(choices, value);
  if (it == choices.end()) fail(key, unknown_word(value, choices));
  return static_cast<int>(it - choices.begin());
}

std::filesystem::path Section::named_file(std::string_view key) {
  const auto name = text(key);
  const auto folder = std::filesystem::path(source_->name).parent_path();
  auto file = folder / name;
  if (source_->reach == Reach::beside && !lies_below(file, folder))
    fail(key, fmt::format("{} is outside the {}'s folder; move it there, or pass --allow-outside",
                          toml_quoted(name), source_->schema->what_is(source_->schema->root()).substr(2)));
  return file;
}

std::string Section::named_text(std::string_view key) {
  const auto file = named_file(key);
  try {
    auto content = read_file(file, most_of_a_text);
    source_->files.push_back({text(key), digest(content)});
    return content;
  } catch (const SceneError& e) {
    fail(key, e.what());
  }
}

Section Section::child(std::string_view key) {
  read_.emplace(key);
  const auto* node = table_.get(key);
  if (node && !node->is_table()) fail(key, fmt::format("must be a table, is {}", kind_of(*node)));
  return {node ? *node->as_table() : empty_table, full(key),
          pattern_.empty() ? std::string(key) : fmt::format("{}.{}", pattern_, key), *source_};
}

std::vector<std::pair<std::string, Section>> Section::children(std::string_view key) {
  Section parent = child(key);
  // A table made by an option has no position in the file. If the option gave it as a whole, its
  // position is in the option's text.
  const auto option = [&](const std::string& name, const toml::node& node) -> std::size_t {
    const auto path = parent.full(name);
    const auto& given = source_->order;
    const auto made = std::ranges::find_if(given, [&](const std::string& set) {
      return set == path || (node.source().begin.line == 0 && set.starts_with(path + "."));
    });
    return made == given.end() ? 0 : static_cast<std::size_t>(made - given.begin()) + 1;
  };
  std::vector<std::tuple<std::size_t, toml::source_position, std::string>> order;
  for (const auto& [name, node] : parent.table_) {
    if (!node.is_table()) parent.fail(name.str(), fmt::format("must be a table, is {}", kind_of(node)));
    if (const auto wrong = wrong_name(name.str()); !wrong.empty()) parent.fail(name.str(), wrong);
    const std::string own(name.str());
    order.emplace_back(option(own, node), node.source().begin, own);
  }
  std::ranges::stable_sort(order, [](const auto& a, const auto& b) {
    return std::get<0>(a) != std::get<0>(b) ? std::get<0>(a) < std::get<0>(b)
                                            : std::get<1>(a) < std::get<1>(b);
  });
  std::vector<std::pair<std::string, Section>> result;
  for (const auto& [made, where, name] : order)
    result.emplace_back(name, Section(*parent.table_.get_as<toml::table>(name), parent.full(name),
                                      fmt::format("{}.*", parent.pattern_), *source_));
  return result;
}

void Section::done(const std::string& kind) const {
  for (const auto& [name, node] : table_) {
    if (read_.contains(name.str())) continue;
    fail(name.str(), fmt::format("does not apply to {}", kind));
  }
}

}  // namespace freeplay
