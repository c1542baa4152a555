#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <functional>
#include <sstream>
#include <utility>

#include "dynamics/assembly/meshing.hpp"
#include "dynamics/instruments.hpp"
#include "dynamics/point_bodies.hpp"
#include "io/files/visible.hpp"
#include "io/scene/keys_reader.hpp"
#include "io/scene/located.hpp"
#include "io/scene/open_scene.hpp"
#include "io/scene/quantity.hpp"
#include "io/scene/read_mechanism.hpp"
#include "io/scene/stated_number.hpp"
#include "io/scene/write_scene.hpp"
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

/// The value of a key in a document, or the number at its places in it; nullptr if there is none.
toml::node* find_node(toml::table& document, const IndexedKey& k) {
  toml::node* node = &document;
  std::istringstream segments(k.key);
  for (std::string name; node && std::getline(segments, name, '.');)
    node = node->is_table() ? node->as_table()->get(name) : nullptr;
  for (const auto place : k.places) node = node && node->is_array() ? node->as_array()->get(place) : nullptr;
  return node;
}

/// Sets one dotted key of the document, or a number within its list. A value that is not valid TOML is taken as a
/// text. A list that the document does not have, or in which a name or a grid stands for numbers, is that of
/// `canonical()`.
void apply_override(toml::table& root, SceneSource& source, const std::string& given,
                    const std::function<toml::table()>& canonical) {
  const auto equals = given.find('=');
  const auto bad = [&](const std::string& why) {
    throw SceneError(fmt::format("--set {}: {}", visible(given), why));
  };
  if (equals == given.npos || equals == 0)
    bad("must be KEY=VALUE, for example joints.gudgeon.clearance=1e-3");
  const std::string name = given.substr(0, equals), value = given.substr(equals + 1);
  if (value.empty()) bad("has no value");
  IndexedKey place;
  try {
    place = indexed_key(name);
  } catch (const ModelError& e) {
    bad(e.message);
  }
  const auto& key = place.key;

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
  if (place.places.empty()) {
    table->insert_or_assign(names.back(), std::move(*parsed.get("value")));
  } else {
    const auto is_number = [](const toml::node* node) {
      const auto text = node ? node->value_exact<std::string>() : std::nullopt;
      return node && (node->is_number() || (text && begins_with_number(*text)));
    };
    if (!is_number(find_node(root, place))) {
      auto whole = canonical();
      if (!is_number(find_node(whole, place))) bad(fmt::format("{} has no such number", key));
      table->insert_or_assign(names.back(), std::move(*find_node(whole, {key, {}})));
    }
    auto list = place;
    list.places.pop_back();
    auto& numbers = *find_node(root, list)->as_array();
    numbers.replace(numbers.cbegin() + static_cast<std::ptrdiff_t>(place.places.back()),
                    std::move(*parsed.get("value")));
  }
  source.overridden[key] = given;
  source.order.push_back(key);
}

/// The document of a scene's text with its options.
toml::table stated_document(const std::string& text, SceneSource& source,
                            const std::vector<std::string>& overrides, bool outside) {
  auto document = parse_toml(text, source.name);
  for (auto given = overrides.begin(); given != overrides.end(); ++given)
    apply_override(document, source, *given, [&] {
      const auto before = parse_scene(text, source.name, {overrides.begin(), given}, outside);
      return parse_toml(to_toml(before), "");
    });
  return document;
}

/// The greatest absolute number in a value and its lists.
double greatest_number(const toml::node& node) {
  double greatest = 0;
  if (const auto* list = node.as_array())
    for (const auto& item : *list) greatest = std::max(greatest, greatest_number(item));
  return std::max(greatest, std::abs(node.value<double>().value_or(0)));
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
  const auto document = stated_document(text, source, overrides, outside);

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

IndexedKey indexed_key(std::string_view name) {
  const auto bracket = std::min(name.find('['), name.size());
  IndexedKey k{std::string(name.substr(0, bracket)), {}};
  for (auto rest = name.substr(bracket); !rest.empty();) {
    const auto close = std::min(rest.find(']'), rest.size());
    std::size_t place = 0;
    const auto end = rest.data() + close;
    if (rest[0] != '[' || close == rest.size() || std::from_chars(rest.data() + 1, end, place).ptr != end ||
        close < 2)
      throw ModelError(std::string(name), "must end with indices such as [0] or [1][0]");
    k.places.push_back(place);
    rest.remove_prefix(close + 1);
  }
  return k;
}

StatedNumber stated_number(const Scene& scene, const std::string& name) {
  const auto k = indexed_key(name);
  const auto facts = to_toml(scene);
  SceneSource source{.name = scene.file.string()};
  std::vector<toml::table> documents;
  documents.push_back(stated_document(scene.text, source, scene.overrides, scene.outside));
  documents.push_back(parse_toml(facts, ""));
  if (!equals_its_text(scene, facts)) std::swap(documents.front(), documents.back());
  const toml::node* last = nullptr;
  for (auto& document : documents) {
    const auto* node = find_node(document, k);
    if (node && node->is_number())
      return {*node->value<double>(), greatest_number(*find_node(document, {k.key, {}}))};
    if (node) last = node;
  }
  const bool known = std::ranges::any_of(documents, [&](auto& d) { return find_node(d, {k.key, {}}); });
  throw ModelError(name, !known ? "has no value in this scene; state it there, or correct the name"
                         : !last || last->is_array()
                             ? "is not one number of a list; add indices such as [0] or [1][0]"
                             : "is not one number; name a key with a number");
}

Scene read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides, bool outside) {
  return parse_scene(read_text(file), file.string(), overrides, outside);
}

std::shared_ptr<const Scene> open_scene(const std::filesystem::path& file,
                                        const std::vector<std::string>& overrides, bool outside) {
  return std::make_shared<const Scene>(read_scene(file, overrides, outside));
}

}  // namespace freeplay
