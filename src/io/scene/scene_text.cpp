#include "io/scene/scene_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>
#include <utility>

#include "io/files/escaping.hpp"
#include "io/scene/quantity.hpp"
#include "io/scene/read_scene.hpp"
#include "io/scene/write_scene.hpp"

namespace freeplay {
namespace {

/// Alternative spellings of facts, each pair in one table. The first key is removed from a canonical text
/// when the second is set.
constexpr std::pair<std::string_view, std::string_view> spellings[] = {
    {"drives.*.speed", "drives.*.speed_rpm"},
    {"drives.*.torque_table", "drives.*.torque"},
    {"drives.*.against", "drives.*.torque"},
    {"drives.*.synchronous_speed", "drives.*.synchronous_speed_rpm"},
    {"curves.*.period", "curves.*.frequency"},
    {"curves.*.points", "curves.*.file"},
    {"beams.*.elements", "beams.*.frequency_range"},
    {"beams.*.damping", "beams.*.damping_ratio"},
    {"run.duration", "run.revolutions"},
    {"instruments.*.resolution", "instruments.*.counts"}};

std::vector<std::string> names_in(const std::string& key) {
  std::istringstream segments(key);
  std::vector<std::string> names;
  for (std::string name; std::getline(segments, name, '.');) names.push_back(name);
  return names;
}

/// Names that the file itself defines in a table.
std::vector<std::string> file_names(const toml::table& table, const std::string& path,
                                    const SceneSource& source) {
  std::vector<std::string> names;
  for (const auto& [name, node] : table)
    if (!source.made.contains(fmt::format("{}.{}", path, name.str()))) names.emplace_back(name.str());
  return names;
}

bool is_number(const toml::node* node) {
  const auto text = node ? node->value_exact<std::string>() : std::nullopt;
  return node && (node->is_number() || (text && begins_with_number(*text)));
}

/// The greatest absolute number in a value and its lists.
double greatest_number(const toml::node& node) {
  double greatest = 0;
  if (const auto* list = node.as_array())
    for (const auto& item : *list) greatest = std::max(greatest, greatest_number(item));
  return std::max(greatest, std::abs(node.value<double>().value_or(0)));
}

void keep_positions(const toml::node& from, toml::node& to) {
  // No function of toml++ sets a position. The node is not const.
  const_cast<toml::source_region&>(to.source()) = from.source();
  if (const auto* table = from.as_table())
    for (const auto& [name, node] : *table) keep_positions(node, *to.as_table()->get(name.str()));
  if (const auto* list = from.as_array())
    for (std::size_t i = 0; i < list->size(); ++i) keep_positions((*list)[i], (*to.as_array())[i]);
}

}  // namespace

PlacedDocument::PlacedDocument(const PlacedDocument& other) : table(other.table) {
  keep_positions(other.table, table);
}

Path Path::of(std::string_view name) {
  const auto bracket = std::min(name.find('['), name.size());
  Path path{std::string(name.substr(0, bracket))};
  for (auto rest = name.substr(bracket); !rest.empty();) {
    const auto close = std::min(rest.find(']'), rest.size());
    std::size_t place = 0;
    const auto end = rest.data() + close;
    if (rest[0] != '[' || close == rest.size() || std::from_chars(rest.data() + 1, end, place).ptr != end ||
        close < 2)
      throw ModelError(std::string(name), "must end with indices such as [0] or [1][0]");
    path.places.push_back(place);
    rest.remove_prefix(close + 1);
  }
  return path;
}

SceneText::SceneText(const std::string& text, const std::string& name,
                     const std::vector<std::string>& options, bool outside)
    : text_(text),
      outside_(outside),
      source_{.name = name, .reach = outside ? Reach::anywhere : Reach::beside},
      document_(parse_toml(text, name)) {
  for (const auto& given : options) set(given);
}

SceneText SceneText::canonical(const Scene& scene) {
  SceneText s;
  s.source_ = {.name = "scene in code"};
  s.document_ = PlacedDocument(parse_toml(to_toml(scene), ""));
  s.original_ = false;
  s.outside_ = scene.outside;
  s.in_code_ = outside_of(scene);
  s.discard_ = scene.run.discard;
  s.file_ = scene.file;
  return s;
}

SceneText::SceneText(const Scene& scene) {
  const auto facts = to_toml(scene);
  if (!scene.text.empty() && scene.text != facts) try {
      SceneText stated(scene.text, scene.file.string(), scene.overrides, scene.outside);
      if (to_toml(stated.read()) == facts) {
        *this = std::move(stated);
        in_code_ = outside_of(scene);
        return;
      }
    } catch (const SceneError&) {
    }
  *this = canonical(scene);
}

const toml::node* SceneText::find(const Path& path) const {
  const toml::node* node = &document_.table;
  for (const auto& name : names_in(path.key))
    node = node && node->is_table() ? node->as_table()->get(name) : nullptr;
  for (const auto place : path.places)
    node = node && node->is_array() ? node->as_array()->get(place) : nullptr;
  return node;
}

void SceneText::set(const std::string& given) {
  const auto equals = given.find('=');
  const auto bad = [&](const std::string& why) {
    throw SceneError(fmt::format("--set {}: {}", visible(given), why));
  };
  if (equals == given.npos || equals == 0)
    bad("must be KEY=VALUE, for example joints.gudgeon.clearance=1e-3");
  const std::string name = given.substr(0, equals), value = given.substr(equals + 1);
  if (value.empty()) bad("has no value");
  Path path;
  try {
    path = Path::of(name);
  } catch (const ModelError& e) {
    bad(e.message);
  }
  const auto& key = path.key;

  toml::table parsed;
  try {
    parsed = parse_toml("value = " + value, "");
  } catch (const SceneError&) {  // an unquoted text
    parsed.insert("value", value);
  }
  if (parsed.size() != 1) bad("must set one value");

  const auto names = names_in(key);
  if (names.empty() || key.back() == '.' || std::ranges::any_of(names, &std::string::empty))
    bad("has an empty name in its key");
  toml::table* table = &document_.table;
  for (std::size_t i = 0; i + 1 < names.size(); ++i) {
    if (!table->contains(names[i])) {
      if (i == 1) source_.made.emplace(names[0] + "." + names[1], file_names(*table, names[0], source_));
      table->insert(names[i], toml::table{});
    }
    table = table->get_as<toml::table>(names[i]);
    if (!table) bad(fmt::format("{} is a value, not a table", names[i]));
  }
  if (path.places.empty()) {
    table->insert_or_assign(names.back(), std::move(*parsed.get("value")));
  } else {
    if (!is_number(find(path))) {
      const auto whole = canonical(read());
      if (!is_number(whole.find(path))) bad(fmt::format("{} has no such number", key));
      auto& list = table->insert_or_assign(names.back(), *whole.find({key})).first->second;
      keep_positions(*whole.find({key}), list);
    }
    toml::node* list = table->get(names.back());
    for (std::size_t i = 0; i + 1 < path.places.size(); ++i) list = list->as_array()->get(path.places[i]);
    auto& numbers = *list->as_array();
    numbers.replace(numbers.cbegin() + static_cast<std::ptrdiff_t>(path.places.back()),
                    std::move(*parsed.get("value")));
  }
  source_.overridden[key] = given;
  source_.order.push_back(key);
  options_.push_back(given);
}

/// Removes the keys that the key replaces.
void SceneText::erase_replaced(const std::string& key) {
  auto names = names_in(key);
  if (names.size() < 2) return;
  toml::table* table = document_.table.get_as<toml::table>(names.front());
  if (table && names.size() > 2) table = table->get_as<toml::table>(names[1]);
  const auto family = names.front() + (names.size() > 2 ? ".*." : ".");
  for (const auto& [replaced, by] : spellings)
    if (table && by == family + names.back()) table->erase(replaced.substr(family.size()));
}

Scene SceneText::with(const std::string& key, const std::string& value) const try {
  if (key.find('=') != key.npos) throw SceneError("a key has no =");
  const auto given = key + "=" + value;
  auto changed = *this;
  Scene scene;
  if (original_) {
    // Earlier options that become unread by its choice are dropped, as are keys of the file.
    auto options = options_;
    for (bool is_read = false; !is_read;) try {
        changed.set(given);
        scene = changed.read();
        is_read = true;
      } catch (const UnreadKey& e) {
        const auto sets = [&](const std::string& option) {
          return option.starts_with(e.key) && option.find_first_of("[=") == e.key.size();
        };
        if (e.key == key || std::erase_if(options, sets) == 0) throw;
        changed = SceneText(text_, source_.name, options, outside_);
      }
  } else {
    // With `revolutions`, `discard` would count revolutions; keep its value in seconds.
    const bool in_revolutions = key == "run.revolutions";
    changed.erase_replaced(Path::of(key).key);
    if (in_revolutions) changed.document_.table.get_as<toml::table>("run")->erase("discard");
    changed.set(given);
    scene = changed.read();
    if (in_revolutions) {
      scene.run.discard = discard_;
      if (discard_ >= scene.run.duration)
        throw SceneError("run.discard: must be less than the length of the run");
    }
    scene.file = file_;
    scene.outside = outside_;
    scene.text = to_toml(scene);
    scene.overrides.clear();
  }
  put(scene, in_code_);
  return scene;
} catch (const SceneError& e) {
  const auto given = fmt::format("--set {}", visible(key + "=" + value)), what = std::string(e.what());
  if (what.starts_with(given + ":")) throw;
  throw SceneError(fmt::format("{}: {}", given, what));
}

void SceneText::fail(const std::string& key, const std::string& message) const {
  const toml::node* node = nullptr;
  const toml::table* table = &document_.table;
  for (const auto& name : names_in(key)) {
    const auto* next = table ? table->get(name) : nullptr;
    if (!next) break;
    node = next;
    table = next->as_table();
  }
  source_.fail(node, key, message);
}

SceneError located(const Scene& scene, const ModelError& error) {
  const auto file = scene.file.string();
  if (scene.text.empty() || error.key.empty())
    return SceneError(file.empty() ? std::string(error.what()) : fmt::format("{}: {}", file, error.what()));
  try {
    SceneText(scene.text, file, scene.overrides, scene.outside).fail(error.key, error.message);
  } catch (const SceneError& e) {
    return e;
  }
}

void Scene::set(const std::string& key, const std::string& value) {
  *this = SceneText(*this).with(key, value);
}

void Scene::set(const std::string& key, double value) { set(key, fmt::format("{}", value)); }

Parameter::Parameter(const Scene& scene, std::string path) : path_(std::move(path)), text_(scene) {
  const auto canonical = SceneText::canonical(scene);
  bool known = false, in_list = true;
  const auto find_in = [&](const SceneText& text) {
    const auto place = Path::of(path_);
    const auto *node = text.find(place), *whole = text.find({place.key});
    known = known || whole;
    if (node) in_list = node->is_array();
    if (!node || !node->is_number()) return false;
    value_ = *node->value<double>();
    greatest_ = greatest_number(*whole);
    return true;
  };
  // The text of a scene that was changed in code may state the number by another key than the canonical text.
  const auto is_in_original = [&] {
    return !text_.is_original() && !scene.text.empty() &&
           find_in(SceneText(scene.text, scene.file.string(), scene.overrides, scene.outside)) &&
           same_facts(at(value_), scene);
  };
  // A number that the canonical text does not have, as the coordinate of a named point.
  const auto is_with_unit = [&] {
    const auto* node = text_.find(Path::of(path_));
    const auto stated = node ? node->value_exact<std::string>() : std::nullopt;
    if (!stated || !begins_with_number(*stated)) return false;
    const auto quantity = read_quantity(*stated, unit_of(path_));
    value_ = quantity.value, greatest_ = std::abs(value_);
    return quantity.wrong.empty();
  };
  if (!find_in(text_) && !find_in(canonical) && !is_in_original() && !is_with_unit())
    throw ModelError(path_, !known    ? "has no value in this scene; state it there, or correct the name"
                            : in_list ? "is not one number of a list; add indices such as [0] or [1][0]"
                                      : "is not one number; name a key with a number");
  // The text may state the fact by another key, as run.revolutions for run.duration.
  if (text_.is_original()) try {
      (void)at(value_);
    } catch (const SceneError&) {
      text_ = canonical;
    }
}

Scene Parameter::at(double value) const { return text_.with(path_, fmt::format("{}", value)); }

}  // namespace freeplay
