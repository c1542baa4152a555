#include "io/schema.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include "io/keys_list.hpp"
#include "model/body.hpp"
#include "model/curve.hpp"
#include "model/elements.hpp"
#include "model/instruments.hpp"
#include "model/options.hpp"
#include "model/surface.hpp"

namespace freeplay {
namespace {

/// Keys of a study, which src/study reads.
constexpr SchemaKey study_keys[] = {
    {"study.title", "text", "", "\"\"", "what the study asks"},
    {"study.scene", "text", "", "required", "scene file, relative to the study's"},
    {"study.claims", "text", "", "–", "list of published findings to judge: \"flores2011\""},
    {"study.fit", "text", "", "–",
     "study whose calibration `validate` runs first; adds a variant \"calibrated\""},
    {"study.joint", "text", "", "–", "contact that flights and impacts are taken from; sweeps need it"},
    {"study.accelerometer", "text", "", "–", "instrument whose signal is judged; sweeps need it"},
    {"study.position", "text", "", "–", "LVDT of the same sampling"},
    {"study.formulations", "names", "", "both", "\"penalty\", \"nonsmooth\""},
    {"study.restitution", "text", "", "\"delivered\"",
     "the impact law's: \"delivered\" by the penalty law, or \"as-given\""},
    {"study.revolutions", "number", "", "50", "counted in each run"},
    {"study.discard", "number", "", "2", "revolutions before those"},
    {"study.starts", "number", "", "8", "perturbed starts of each case"},
    {"study.seed", "number", "", "1", "of the starts, a whole number"},
    {"study.turn", "number", "", "1", "share of a turn that the crank's start angle is drawn from"},
    {"study.play", "number", "", "0.9", "share of the clearance that loose parts start within"},
    {"study.flight_angle", "number", "degrees", "2",
     "flights count that last at least this turn of the crank"},
    {"study.impact_speed", "number", "m/s", "0.01", "impacts count that approach at least this fast"},
    {"study.line_share", "number", "", "0.05",
     "a line of the spectrum is dominant from this share of the ideal greatest acceleration"},
    {"study.axes.*.key", "text", "", "required", "scene key that varies"},
    {"study.axes.*.values", "numbers", "", "required", "what it takes"},
    {"study.axes.*.unit", "text", "", "\"\"", "as shown"},
    {"study.axes.*.scale", "number", "", "1", "shown value over the key's"},
    {"study.variants.*.title", "text", "", "its name", "what it switches on"},
    {"study.variants.*.scene", "text", "", "the study's", "another scene file"},
    {"study.variants.*.set", "names", "", "[]", "keys of the scene, KEY=VALUE"},
    {"study.variants.*.formulations", "names", "", "the study's", "as in the study"},
    {"study.variants.*.starts", "number", "", "the study's", "as in the study"},
    {"study.variants.*.revolutions", "number", "", "the study's", "as in the study"},
    {"study.calibrate.formulation", "text", "", "\"nonsmooth\"", "which is fitted"},
    {"study.calibrate.points", "number", "", "64", "of the space-filling set that the surface is fitted to"},
    {"study.calibrate.starts", "number", "", "2", "perturbed starts of each point and target"},
    {"study.calibrate.revolutions", "number", "", "20", "counted in each run"},
    {"study.calibrate.unknowns.*.key", "text", "", "required", "scene key that is fitted"},
    {"study.calibrate.unknowns.*.low", "number", "", "required", "least value"},
    {"study.calibrate.unknowns.*.high", "number", "", "required", "greatest value"},
    {"study.calibrate.unknowns.*.scale", "text", "", "\"linear\"", "or \"log\""},
    {"study.calibrate.unknowns.*.unit", "text", "", "\"\"", "as shown"},
    {"study.calibrate.targets.*.set", "names", "", "[]", "keys of the scene for this target, KEY=VALUE"},
    {"study.calibrate.targets.*.statistic", "text", "", "required", "of a run; docs/study.md lists them"},
    {"study.calibrate.targets.*.value", "number", "", "–", "as measured"},
    {"study.calibrate.targets.*.data", "text", "", "–",
     "measured file that the statistic is computed from, instead"},
    {"study.calibrate.targets.*.tolerance", "number", "", "0.1",
     "relative standard uncertainty of the value"},
};

/// The rows of all kinds in V: of one table that `type` or a key of its own chooses from.
template <class V, std::size_t... I>
void list_kinds(KeysList& list, const char* table, std::index_sequence<I...>) {
  const std::vector<std::string> kinds{std::string(word_of<std::variant_alternative_t<I, V>>())...};
  list.open(table, kinds);
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
void list_kinds(KeysList& list, const char* table) {
  list_kinds<V>(list, table, std::make_index_sequence<std::variant_size_v<V>>{});
}
template <class X>
void list_facts(KeysList& list, const char* table) {
  list.open(table);
  X x;
  X::keys(list, x);
  list.close();
}

std::vector<KeysList::Row> scene_rows() {
  KeysList list;
  list.open("");
  list.plain(
      {"format", "", ""}, "number", "2",
      "format of the scene, a whole number; one that is stated keeps its meaning when defaults change; 2 is "
      "the newest");
  list.plain({"title", "", ""}, "text", "\"\"", "what the scene is; stands in results and figures");
  list.plain({"gravity", "m/s²", ""}, "point", "[0, 0]", "acceleration of gravity in the plane of motion");
  list_facts<Body>(list, "bodies.*");
  list_kinds<Joint>(list, "joints.*");
  list_kinds<Contact>(list, "contacts.*");
  list_facts<Lubricant>(list, "lubricants.*");
  list_facts<Surface>(list, "surfaces.*");
  list_kinds<Drive>(list, "drives.*");
  list_facts<Curve>(list, "curves.*");
  list_kinds<Load>(list, "loads.*");
  list_facts<Configuration>(list, "assembly");
  list_facts<RunOptions>(list, "run");
  list_facts<PenaltyOptions>(list, "penalty");
  list_facts<NonsmoothOptions>(list, "nonsmooth");
  list.open("instruments.*", [] {
    std::vector<std::string> kinds;
    for (const auto& choice : instrument_names) kinds.emplace_back(choice.text);
    return kinds;
  }());
  list.kind_row("\"accelerometer\"", instrument_names);
  for (const auto& choice : instrument_names) {
    Instrument instrument;
    list.kind(choice.text);
    with_kind(choice.value, [&](auto kind) { kind.keys(list, instrument); });
  }
  list.close();
  return list.take();
}

/// All rows, made once; texts live as long as the program.
const std::vector<SchemaKey>& keys() {
  static const auto rows = scene_rows();
  static const auto list = [] {
    std::vector<SchemaKey> keys;
    for (const auto& r : rows) keys.push_back({r.path, r.type, r.unit, r.fallback, r.meaning});
    keys.insert(keys.end(), std::begin(study_keys), std::end(study_keys));
    return keys;
  }();
  return list;
}

/// What the tables of the schema describe.
constexpr std::pair<std::string_view, std::string_view> tables[] = {
    {"", "a scene"},
    {"bodies.*", "a body"},
    {"joints.*", "a joint"},
    {"contacts.*", "a contact"},
    {"lubricants.*", "a lubricant"},
    {"surfaces.*", "a surface"},
    {"drives.*", "a drive"},
    {"curves.*", "a curve"},
    {"loads.*", "a load"},
    {"assembly", "[assembly]"},
    {"run", "[run]"},
    {"penalty", "[penalty]"},
    {"nonsmooth", "[nonsmooth]"},
    {"instruments.*", "an instrument"},
    {"study", "a study"},
    {"study.axes.*", "an axis"},
    {"study.variants.*", "a variant"},
    {"study.calibrate", "[calibrate]"},
    {"study.calibrate.unknowns.*", "an unknown"},
    {"study.calibrate.targets.*", "a target"}};

int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int above = row[j];
      row[j] = std::min({row[j - 1] + 1, above + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

}  // namespace

std::span<const SchemaKey> schema() { return keys(); }

const SchemaKey* find_key(std::string_view path) {
  const auto it = std::ranges::find(keys(), path, &SchemaKey::path);
  return it == keys().end() ? nullptr : &*it;
}

std::string_view unit_of(const std::string& key) {
  const auto first = key.find('.'), last = key.rfind('.');
  const auto* row = find_key(first == last ? key : key.substr(0, first) + ".*" + key.substr(last));
  return row ? row->unit : "";
}

std::vector<std::string> keys_of(std::string_view table) {
  std::vector<std::string> names;
  for (const auto& key : keys()) {
    auto path = key.path;
    const bool of_study = path.starts_with("study.");
    if (table.empty() ? of_study : !path.starts_with(std::string(table) + ".")) continue;
    if (!table.empty()) path.remove_prefix(table.size() + 1);
    const std::string name(path.substr(0, path.find('.')));
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  return names;
}

std::string_view what_is(std::string_view table) {
  const auto it = std::ranges::find(tables, table, &std::pair<std::string_view, std::string_view>::first);
  return it == std::end(tables) ? "a table" : it->second;
}

std::string nearest_word(std::string_view word, const std::vector<std::string>& words) {
  std::string best;
  int least = 1000;
  for (const auto& candidate : words)
    if (const int d = edit_distance(word, candidate);
        d < least && d <= static_cast<int>(std::max(word.size(), candidate.size())) / 2) {
      least = d;
      best = candidate;
    }
  return best;
}

}  // namespace freeplay
