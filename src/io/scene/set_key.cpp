#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "io/files/visible.hpp"
#include "io/scene/stated_number.hpp"
#include "io/scene/write_scene.hpp"
#include "mechanism/outside.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

/// Alternative spellings of facts, each pair in one table. The first key is removed from a
/// canonical text when the second is set.
constexpr std::pair<std::string_view, std::string_view> spellings[] = {
    {"drives.*.speed", "drives.*.speed_rpm"},
    {"drives.*.torque_table", "drives.*.torque"},
    {"drives.*.against", "drives.*.torque"},
    {"drives.*.synchronous_speed", "drives.*.synchronous_speed_rpm"},
    {"curves.*.period", "curves.*.frequency"},
    {"curves.*.points", "curves.*.file"},
    {"run.duration", "run.revolutions"},
    {"instruments.*.resolution", "instruments.*.counts"}};

/// table.NAME.key as table.*.key.
std::string pattern_of(const std::string& key) {
  const auto first = key.find('.'), last = key.rfind('.');
  return first == last ? key : key.substr(0, first) + ".*" + key.substr(last);
}

/// A canonical text without the lines that setting `set` replaces, and without the key `dropped`.
std::string make_way(const std::string& text, const std::string& set, std::string_view dropped) {
  std::string out;
  for (const auto& line : canonical_lines(text)) {
    const bool same_table = line.key.substr(0, line.key.rfind('.')) == set.substr(0, set.rfind('.'));
    const bool gives_way = same_table && std::ranges::any_of(spellings, [&](const auto& s) {
                             return s.first == pattern_of(line.key) && s.second == pattern_of(set);
                           });
    if (line.key != dropped && !gives_way) out += line.line + '\n';
  }
  return out;
}

/// Parses the scene with one more option. Earlier options that become unread by its choice are
/// dropped, as are keys of the file.
Scene parse_with(const Scene& scene, const std::string& given, const std::string& key) {
  auto options = scene.overrides;
  options.push_back(given);
  for (;;) try {
      return parse_scene(scene.text, scene.file.string(), options, scene.outside);
    } catch (const UnreadKey& e) {
      const auto sets = [&](const std::string& option) {
        return option.starts_with(e.key) && option.find_first_of("[=") == e.key.size();
      };
      if (e.key == key || std::erase_if(options, sets) == 0) throw;
    }
}

}  // namespace

bool equals_its_text(const Scene& scene, const std::string& facts) {
  if (scene.text.empty() || scene.text == facts) return false;
  try {
    return to_toml(parse_scene(scene.text, scene.file.string(), scene.overrides, scene.outside)) == facts;
  } catch (const SceneError&) {
    return false;
  }
}

void Scene::set(const std::string& key, const std::string& value) try {
  if (key.find('=') != key.npos) throw SceneError("a key has no =");
  const auto given = key + "=" + value;
  const auto facts = to_toml(*this);
  Scene changed;
  if (equals_its_text(*this, facts)) {
    changed = parse_with(*this, given, key);
  } else {
    // With `revolutions`, `discard` would count revolutions; keep its value in seconds.
    const bool in_revolutions = key == "run.revolutions";
    changed = parse_scene(make_way(facts, key.substr(0, key.find('[')), in_revolutions ? "run.discard" : ""),
                          "scene in code", {given});
    if (in_revolutions) {
      changed.run.discard = run.discard;
      if (run.discard >= changed.run.duration)
        throw SceneError("run.discard: must be less than the length of the run");
    }
    changed.file = file;
    changed.outside = outside;
    changed.text = to_toml(changed);
    changed.overrides.clear();
  }
  put(changed, outside_of(*this));
  *this = std::move(changed);
} catch (const SceneError& e) {
  const auto given = fmt::format("--set {}", visible(key + "=" + value)), what = std::string(e.what());
  if (what.starts_with(given + ":")) throw;
  throw SceneError(fmt::format("{}: {}", given, what));
}

void Scene::set(const std::string& key, double value) { set(key, fmt::format("{}", value)); }

}  // namespace freeplay
