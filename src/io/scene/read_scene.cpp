#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "dynamics/assembly/meshing.hpp"
#include "dynamics/instruments.hpp"
#include "dynamics/point_bodies.hpp"
#include "io/files/visible.hpp"
#include "io/scene/keys_reader.hpp"
#include "io/scene/located.hpp"
#include "io/scene/open_scene.hpp"
#include "io/scene/read_mechanism.hpp"
#include "io/scene/toml_value.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

/// Names that the file itself defines in a table.
std::vector<std::string> file_names(const toml::table& table, const std::string& path,
                                    const SceneSource& source) {
  std::vector<std::string> names;
  for (const auto& [name, node] : table)
    if (!source.made.contains(fmt::format("{}.{}", path, name.str()))) names.emplace_back(name.str());
  return names;
}

/// Whether any text in a table or its subtables equals `word`.
bool names_it(const toml::table& table, const std::string& word) {
  return std::ranges::any_of(table, [&](const auto& item) {
    const auto& node = item.second;
    if (const auto* below = node.as_table()) return names_it(*below, word);
    return node.template value_exact<std::string>() == word;
  });
}

/// Refuses surfaces and lubricants that exist in options only and that nothing names: they would
/// have no effect.
void refuse_made_in_vain(const toml::table& document, const SceneSource& source) {
  for (const auto& [path, beside] : source.made)
    if ((path.starts_with("surfaces.") || path.starts_with("lubricants.")) &&
        !names_it(document, path.substr(path.find('.') + 1)))
      source.refuse_made(path);
}

/// Sets one dotted key of the document. A value that is not valid TOML is taken as a text.
void apply_override(toml::table& root, SceneSource& source, const std::string& given) {
  const auto equals = given.find('=');
  const auto bad = [&](const std::string& why) {
    throw SceneError(fmt::format("--set {}: {}", visible(given), why));
  };
  if (equals == given.npos || equals == 0)
    bad("must be KEY=VALUE, for example joints.gudgeon.clearance=1e-3");
  const std::string key = given.substr(0, equals), value = given.substr(equals + 1);
  if (value.empty()) bad("has no value");

  toml::table parsed;
  try {
    parsed = parse_toml("value = " + value, "");
  } catch (const SceneError&) {  // an unquoted text
    parsed.insert("value", value);
  }
  if (parsed.size() != 1) bad("must set one value");

  toml::table* table = &root;
  std::istringstream segments(key);
  std::string segment;
  std::vector<std::string> names;
  while (std::getline(segments, segment, '.')) names.push_back(segment);
  if (names.empty() || key.back() == '.' || std::ranges::any_of(names, &std::string::empty))
    bad("has an empty name in its key");
  for (std::size_t i = 0; i + 1 < names.size(); ++i) {
    if (!table->contains(names[i])) {
      if (i == 1) source.made.emplace(names[0] + "." + names[1], file_names(*table, names[0], source));
      table->insert(names[i], toml::table{});
    }
    table = table->get_as<toml::table>(names[i]);
    if (!table) bad(fmt::format("{} is a value, not a table", names[i]));
  }
  table->insert_or_assign(names.back(), std::move(*parsed.get("value")));
  source.overridden[key] = given;
  source.order.push_back(key);
}

/// A value as one line of TOML; empty for a table or a date.
std::string line_of(const toml::node& node) {
  if (const auto* list = node.as_array()) {
    std::string out;
    for (const auto& item : *list) out += (out.empty() ? "" : ", ") + line_of(item);
    return fmt::format("[{}]", out);
  }
  if (const auto text = node.value_exact<std::string>()) return toml_quoted(*text);
  if (const auto on = node.value_exact<bool>()) return *on ? "true" : "false";
  const auto x = node.value<double>();
  return x ? toml_number(*x) : "";
}

std::optional<int> read_format(Section& root) {
  constexpr Range known{[](double x) { return x >= 1 && x <= newest_format && x == static_cast<int>(x); },
                        "1 or 2 (later versions may know more)"};
  const auto format = root.maybe_number("format", known);
  if (!format) return std::nullopt;
  return static_cast<int>(*format);
}

/// Applies the defaults of an older format to absent keys.
void take_old_defaults(int format, bool step_given, NonsmoothOptions& o) {
  if (format >= 2) return;
  if (!o.scheme) o.scheme = Scheme::moreau_jean;
  if (!step_given) o.step = 1e-5;
}

/// Limit of the samples of one channel in a run: 60 GB of signals.csv, far below the number at
/// which consecutive times would round to the same double.
constexpr double most_samples = 1e9;

Instrument read_instrument(const Mechanism& mechanism, double duration, const std::string& name, Section& s) {
  Instrument i;
  i.name = name;
  i.kind = static_cast<Instrument::Kind>(
      s.choice("type", words<Instrument::Kind>(), static_cast<int>(Instrument::Kind::accelerometer)));
  with_kind(i.kind, [&](auto kind) {
    const Ground nameless;  // instruments cannot name points of the ground
    KeysReader reader(s, mechanism, nameless);
    kind.keys(reader, i);
    reader.check(i.sampling * duration <= most_samples, "sampling", "must be at most ",
                 most_samples / duration, " Hz, for a run of ", duration, " s: ", most_samples, " samples");
    if (i.kind == Instrument::Kind::encoder)
      for (const int body : i.pair)
        reader.check(body == ground || !mechanism.bodies[static_cast<std::size_t>(body)].point, "joint",
                     "has no angle, since one of its bodies is a point body");
    s.done(std::string(kind.what));
  });
  return i;
}

}  // namespace

Scene parse_scene(const std::string& text, const std::string& name, const std::vector<std::string>& overrides,
                  bool outside) {
  Scene scene;
  scene.file = name;
  scene.text = text;
  scene.overrides = overrides;
  scene.outside = outside;
  SceneSource source{.name = name, .reach = outside ? Reach::anywhere : Reach::beside};
  toml::table document = parse_toml(text, name);
  for (const auto& o : overrides) apply_override(document, source, o);

  refuse_unknown_keys(document, "", source);
  refuse_made_in_vain(document, source);

  Section root(document, "", "", source);
  scene.format = read_format(root);
  scene.mechanism = read_mechanism(root);
  const auto options = [&](const char* table, auto& o, const auto& complete) {
    auto section = root.child(table);
    read_keys(section, scene.mechanism, o, {}, complete);
  };
  const auto as_read = [](const auto&) {};
  options("run", scene.run, as_read);
  options("penalty", scene.penalty, as_read);
  const bool step_given = root.child("nonsmooth").has("step");
  options("nonsmooth", scene.nonsmooth, [&](NonsmoothOptions& o) {
    take_old_defaults(scene.format.value_or(newest_format), step_given, o);
  });
  for (auto& [key, s] : root.children("instruments"))
    scene.instruments.push_back(read_instrument(scene.mechanism, scene.run.duration, key, s));
  root.done("a scene");
  located_in(scene, [&] {
    check_point_bodies(scene.mechanism);
    set_phases(scene.mechanism);
  });
  scene.idle = source.idle;
  scene.files = source.files;
  return scene;
}

std::optional<std::string> spelled_value(const Scene& scene, const std::string& key) {
  auto document = parse_toml(scene.text, scene.file.string());
  SceneSource source{.name = scene.file.string()};
  for (const auto& o : scene.overrides) apply_override(document, source, o);
  const toml::node* node = &document;
  std::istringstream segments(key);
  for (std::string name; node && std::getline(segments, name, '.');)
    node = node->is_table() ? node->as_table()->get(name) : nullptr;
  const auto line = node ? line_of(*node) : "";
  return line.empty() ? std::nullopt : std::optional(line);
}

Scene read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides, bool outside) {
  return parse_scene(read_text(file), file.string(), overrides, outside);
}

std::shared_ptr<const Scene> open_scene(const std::filesystem::path& file,
                                        const std::vector<std::string>& overrides, bool outside) {
  return std::make_shared<const Scene>(read_scene(file, overrides, outside));
}

}  // namespace freeplay
