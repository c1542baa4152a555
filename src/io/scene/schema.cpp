#include "io/scene/schema.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "dynamics/instruments.hpp"
#include "io/scene/keys_list.hpp"
#include "io/scene/section.hpp"
#include "io/scene/spelling.hpp"
#include "mechanism/body.hpp"
#include "mechanism/curve.hpp"
#include "mechanism/elements.hpp"
#include "mechanism/ground.hpp"
#include "mechanism/group.hpp"
#include "mechanism/options.hpp"
#include "mechanism/profile.hpp"
#include "mechanism/surface.hpp"

namespace freeplay {
namespace {

/// Lists the keys of all kinds in V, which share one table; `type` or a key selects the kind.
template <class V, std::size_t... I>
void list_kinds(KeysList& list, const char* table, const char* what, std::index_sequence<I...>) {
  list.open(table, what, {std::string(word_of<std::variant_alternative_t<I, V>>())...});
  const auto add = [&]<class X>(X x) {
    list.kind(word_of<X>());
    X::keys(list, x);
    list.leave_group();
  };
  if constexpr (requires { std::variant_alternative_t<0, V>::type; })
    list.kind_row("required", std::vector<Choice<int>>{{0, std::variant_alternative_t<I, V>::type}...});
  (add(std::variant_alternative_t<I, V>{}), ...);
  list.close();
}
template <class V>
void list_kinds(KeysList& list, const char* table, const char* what) {
  list_kinds<V>(list, table, what, std::make_index_sequence<std::variant_size_v<V>>{});
}

}  // namespace

Schema::Schema(std::string root, std::vector<SchemaKey> keys, Tables tables)
    : root_(std::move(root)), keys_(std::move(keys)), tables_(std::move(tables)) {
  const auto add = [&](std::string_view table, std::string_view rest) {
    const auto name = rest.substr(0, rest.find('.'));
    auto& names = names_[std::string(table)];
    if (std::ranges::find(names, name) == names.end()) names.emplace_back(name);
  };
  for (const auto& key : keys_) {
    const std::string_view path = key.path;
    if (root_.empty()) add("", path);
    for (auto dot = path.find('.'); dot != path.npos; dot = path.find('.', dot + 1))
      add(path.substr(0, dot), path.substr(dot + 1));
  }
}

const SchemaKey* Schema::find(std::string_view path) const {
  const auto it = std::ranges::find(keys_, path, &SchemaKey::path);
  return it == keys_.end() ? nullptr : &*it;
}

const std::vector<std::string>& Schema::keys_of(std::string_view table) const {
  static const std::vector<std::string> none;
  const auto it = names_.find(table);
  return it == names_.end() ? none : it->second;
}

std::string_view Schema::what_is(std::string_view table) const {
  const auto it = std::ranges::find(tables_, table, &Tables::value_type::first);
  return it == tables_.end() ? "a table" : std::string_view(it->second);
}

const Schema& scene_schema() {
  static const Schema schema = [] {
    KeysList list;
    list.open("", "a scene");
    list.plain({"format", "", ""}, "number", "2",
               "format of the scene, a whole number; fixes the defaults of that format; 2 is the newest");
    list.plain({"title", "", ""}, "text", "\"\"", "title of the scene in results and figures");
    list.plain({"gravity", "m/s²", ""}, "point", "[0, 0]", "acceleration of gravity in the plane of motion");
    list.facts<Ground>("ground", "[ground]");
    list.facts<Body>("bodies.*", "a body");
    list_kinds<Joint>(list, "joints.*", "a joint");
    list_kinds<Contact>(list, "contacts.*", "a contact");
    list.facts<Group>("groups.*", "a group");
    list.facts<Beam>("beams.*", "a beam");
    list.facts<Lubricant>("lubricants.*", "a lubricant");
    list.facts<Profile>("profiles.*", "a profile");
    list.facts<Surface>("surfaces.*", "a surface");
    list_kinds<Drive>(list, "drives.*", "a drive");
    list.facts<Curve>("curves.*", "a curve");
    list_kinds<Load>(list, "loads.*", "a load");
    list.facts<Configuration>("assembly", "[assembly]");
    list.facts<RunOptions>("run", "[run]");
    list.facts<PenaltyOptions>("penalty", "[penalty]");
    list.facts<NonsmoothOptions>("nonsmooth", "[nonsmooth]");
    std::vector<std::string> kinds;
    for (const auto& choice : instrument_names) kinds.emplace_back(choice.text);
    list.open("instruments.*", "an instrument", kinds);
    list.kind_row("\"accelerometer\"", instrument_names);
    for (const auto& choice : instrument_names) {
      Instrument instrument;
      list.kind(choice.text);
      with_kind(choice.value, [&](auto kind) { kind.keys(list, instrument); });
    }
    list.close();
    list.facts<Tolerance>("tolerances.*", "a tolerance");
    return list.schema("");
  }();
  return schema;
}

std::string_view unit_of(const std::string& name) {
  const auto key = name.substr(0, name.find('['));
  const auto first = key.find('.'), last = key.rfind('.');
  const auto row_of = [&](std::string_view property) {
    return scene_schema().find(first == last ? key : fmt::format("{}.*{}", key.substr(0, first), property));
  };
  const auto* row = row_of(std::string_view(key).substr(std::min(last, key.size())));
  // An entry of a table, such as a named point.
  if (const auto above = last == key.npos || last == 0 ? key.npos : key.rfind('.', last - 1);
      !row && above != key.npos && above > first)
    row = row_of(std::string_view(key).substr(above, last - above));
  const std::string_view unit = row ? std::string_view(row->unit) : "";
  const auto comma = unit.find(", ");  // of the columns of a list of points
  if (key == name || comma == unit.npos) return unit;
  return name.ends_with("[0]") ? unit.substr(0, comma) : unit.substr(comma + 2);
}

namespace {

using Json = nlohmann::ordered_json;

Json of_type(const char* type) { return {{"type", type}}; }

Json list_of(const Json& item) { return {{"type", "array"}, {"items", item}}; }

Json any_of(const std::vector<Json>& choices) {
  if (choices.size() == 1) return choices.front();
  return {{"anyOf", choices}};
}

/// The values of one word of SchemaKey::type. `mixed`: a list may have both points and names.
std::vector<Json> values_of(std::string_view word, bool mixed) {
  const auto text = of_type("string"), number = any_of({of_type("number"), text});  // "0.2 mm" has its unit
  auto point = list_of(number);
  point["minItems"] = point["maxItems"] = 2;
  if (word == "number") return {of_type("number"), text};
  if (word == "numbers") return {list_of(any_of({number, list_of(number)}))};
  if (word == "point") return {point};
  if (word == "points") return {list_of(mixed ? any_of({text, point}) : point)};
  if (word == "names") return {list_of(mixed ? any_of({text, point}) : text)};
  if (word == "table") return {{{"type", "object"}, {"additionalProperties", any_of({text, point})}}};
  return {text};  // text, name or file
}

Json value_of(const SchemaKey& key) {
  if (key.type == "true or false") return of_type("boolean");
  const bool mixed = key.type.find("points or names") != key.type.npos;
  std::vector<Json> choices;
  constexpr std::string_view between = " or ";
  for (std::string_view rest = key.type; !rest.empty();) {
    const auto end = rest.find(between);
    for (auto& value : values_of(rest.substr(0, end), mixed))
      if (std::ranges::find(choices, value) == choices.end()) choices.push_back(std::move(value));
    rest.remove_prefix(end == rest.npos ? rest.size() : end + between.size());
  }
  return any_of(choices);
}

/// Meaning, unit and default of a key.
std::string description_of(const SchemaKey& key) {
  const auto unit = key.unit.empty() ? "" : ", in " + key.unit;
  const auto given = key.fallback == "required" ? "; required"
                     : key.fallback == "–"      ? ""
                                                : "; default: " + key.fallback;
  return key.meaning + unit + given;
}

Json new_table(std::string_view what) {
  return {{"type", "object"},
          {"description", what},
          {"properties", Json::object()},
          {"additionalProperties", false}};
}

/// The subtable `name` of a table; "*" is that of all names chosen by the author.
Json& subtable(Json& table, const std::string& name, std::string_view what) {
  auto& place = name == "*" ? table["additionalProperties"] : table["properties"][name];
  if (!place.is_object()) place = new_table(what);
  return place;
}

}  // namespace

nlohmann::ordered_json json_schema(const Schema& schema) {
  Json document = new_table(schema.what_is(schema.root()));
  document["$schema"] = "http://json-schema.org/draft-04/schema#";
  for (const auto& key : schema.keys()) {
    auto* table = &document;
    auto begin = schema.root().empty() ? 0 : schema.root().size() + 1;
    for (auto dot = key.path.find('.', begin); dot != key.path.npos; dot = key.path.find('.', begin)) {
      table = &subtable(*table, key.path.substr(begin, dot - begin), schema.what_is(key.path.substr(0, dot)));
      begin = dot + 1;
    }
    auto& value = (*table)["properties"][key.path.substr(begin)] = value_of(key);
    value["description"] = description_of(key);
  }
  return document;
}

// Comparison of a document with the schema before it is read.

namespace {

/// A key that is not in the schema.
struct Unknown {
  const toml::node* node;
  std::string path, table, name;
};

/// Keys of options are reported before those of the file, since the user has just typed them.
bool before(const Unknown& a, const Unknown& b) { return a.node->source().begin < b.node->source().begin; }

/// The first unknown key of `table` and its subtables. `path` is the table's dotted key.
std::optional<Unknown> first_unknown(const Schema& schema, const toml::table& table, const std::string& path,
                                     std::string_view pattern) {
  const auto& known = schema.keys_of(pattern);
  const bool names = std::ranges::find(known, "*") != known.end();
  std::optional<Unknown> first;
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    const auto own = path.empty() ? name : fmt::format("{}.{}", path, name);
    const auto below = pattern.empty() ? name : fmt::format("{}.{}", pattern, names ? "*" : name);
    std::optional<Unknown> found;
    if (!names && std::ranges::find(known, name) == known.end())
      found = Unknown{&node, own, std::string(pattern), name};
    else if (const auto* sub = node.as_table(); sub && !schema.find(below))
      found = first_unknown(schema, *sub, own, below);
    if (found && (!first || before(*found, *first))) first = std::move(found);
  }
  return first;
}

/// Suggestion for an unknown key: a nearly equal key of the table, else the table to which the key
/// belongs, else a similar key of the table, else the list of known keys.
std::string remedy(const Schema& schema, const Unknown& unknown) {
  const auto& known = schema.keys_of(unknown.table);
  if (unknown.table == "study" && unknown.name == "study")
    return "; keys of a study are at the root: [axes.NAME], without study";
  const auto near = nearest_word(unknown.name, known);
  const auto suggested = [&] { return fmt::format("; did you mean {}?", near); };
  if (!near.empty() && edit_distance(unknown.name, near) <= 2) return suggested();
  for (const auto& key : schema.keys())
    if (!unknown.node->is_table() && key.path.ends_with("." + unknown.name))
      return fmt::format("; it belongs to {}", key.path.substr(0, key.path.rfind('.')));
  return near.empty() ? listed("there are", known) : suggested();
}

/// Refuses a scene in place of a study and vice versa, before its first key is reported as
/// misspelt.
void refuse_mistaken(const toml::table& document, std::string_view pattern, const SceneSource& source) {
  const bool scene = document.contains("bodies") || document.contains("joints"),
             study = document.contains("scene");
  if (scene == study) return;
  if (pattern == "study" && scene)
    throw SceneError(
        fmt::format("{}: is a scene; a study refers to one by scene = \"{}\": docs/reference/study.md",
                    source.name, std::filesystem::path(source.name).filename().string()));
  if (pattern.empty() && study)
    throw SceneError(fmt::format(
        "{}: is a study, for freeplay sweep, bifurcation or basin; its key scene gives the scene file",
        source.name));
}

}  // namespace

void refuse_unknown_keys(const toml::table& document, std::string_view pattern, const SceneSource& source) {
  refuse_mistaken(document, pattern, source);
  if (const auto unknown = first_unknown(*source.schema, document, "", pattern))
    source.fail(unknown->node, unknown->path,
                fmt::format("is not a key of {}{}", source.schema->what_is(unknown->table),
                            remedy(*source.schema, *unknown)));
}

}  // namespace freeplay
