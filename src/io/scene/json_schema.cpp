#include "io/scene/json_schema.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace freeplay {
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

}  // namespace freeplay
