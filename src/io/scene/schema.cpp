#include "io/scene/schema.hpp"

#include <algorithm>
#include <vector>

#include "dynamics/instruments.hpp"
#include "io/scene/keys_list.hpp"
#include "mechanism/body.hpp"
#include "mechanism/curve.hpp"
#include "mechanism/elements.hpp"
#include "mechanism/ground.hpp"
#include "mechanism/group.hpp"
#include "mechanism/options.hpp"
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
    list.facts<Lubricant>("lubricants.*", "a lubricant");
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
    return list.schema("");
  }();
  return schema;
}

std::string_view unit_of(const std::string& name) {
  const auto key = name.substr(0, name.find('['));
  const auto first = key.find('.'), last = key.rfind('.');
  const auto* row = scene_schema().find(first == last ? key : key.substr(0, first) + ".*" + key.substr(last));
  const std::string_view unit = row ? std::string_view(row->unit) : "";
  const auto comma = unit.find(", ");  // of the columns of a list of points
  if (key == name || comma == unit.npos) return unit;
  return name.ends_with("[0]") ? unit.substr(0, comma) : unit.substr(comma + 2);
}

}  // namespace freeplay
