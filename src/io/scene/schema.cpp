#include "io/scene/schema.hpp"

#include <algorithm>
#include <map>
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

/// Keys of a study, read by src/study.
constexpr SchemaKey study_keys[] = {
    {"study.title", "text", "", "\"\"", "title of the study"},
    {"study.scene", "text", "", "required", "scene file, relative to the study's"},
    {"study.claims", "text", "", "–",
     "what `validate` compares with: \"flores2011\" (published findings) or \"points\" (measured values)"},
    {"study.points", "text", "", "–",
     "CSV file with the measured values of claims = \"points\": columns quantity, value, uncertainty and "
     "the axes"},
    {"study.fit", "text", "", "–",
     "study with a calibration that `validate` runs first; adds a variant \"calibrated\""},
    {"study.joint", "text or names", "", "all",
     "joints and contacts for the statistics of flights and impacts; `validate` and `calibrate` need one"},
    {"study.accelerometer", "text", "", "–",
     "instrument of the evaluated signal; `validate` and `calibrate` need it"},
    {"study.position", "text", "", "–", "LVDT with the same sampling"},
    {"study.formulations", "names", "", "both", "\"penalty\", \"nonsmooth\""},
    {"study.restitution", "text", "", "\"delivered\"",
     "restitution of the impact law: \"delivered\" (effective value of the penalty law), or \"as-given\" "
     "(input)"},
    {"study.period", "number", "s", "the drive's",
     "duration of one revolution; default: that of the drive of prescribed speed, or the period of the "
     "curves"},
    {"study.revolutions", "number", "", "50", "evaluated periods of each run"},
    {"study.discard", "number", "", "2", "discarded periods before those"},
    {"study.duration", "number", "s", "–",
     "evaluated duration of each run, in place of revolutions and "
     "discard"},
    {"study.discard_time", "number", "s", "0", "before that"},
    {"study.starts", "number", "", "8", "perturbed starts of each case; 1 if a scene has none"},
    {"study.seed", "number", "", "1", "seed of the starts and random points; a whole number"},
    {"study.turn", "number", "", "1", "range of the random initial crank angle, as a share of a revolution"},
    {"study.play", "number", "", "0.9", "range of the random initial offsets, as a share of the clearance"},
    {"study.flight_angle", "number", "degrees", "2", "shortest counted flight, as crank angle"},
    {"study.impact_speed", "number", "m/s", "0.01", "least approach speed of counted impacts"},
    {"study.line_share", "number", "", "0.05",
     "least amplitude of dominant spectral lines, as a share of the greatest ideal acceleration"},
    {"study.sample", "text", "", "–",
     "design of the random values of axes with low and high: \"random\", \"latin-hypercube\" or \"sobol\""},
    {"study.samples", "number", "", "–", "number of random points"},
    {"study.where", "text", "", "–", "condition for running a cell, an expression of the axes"},
    {"study.axes.*.key", "text", "", "–", "scene key that varies; or keys"},
    {"study.axes.*.keys", "names", "", "–", "several keys that vary together"},
    {"study.axes.*.values", "numbers", "", "–",
     "values, as texts with units if needed; for several keys also one list per point, [[a, b], ...]"},
    {"study.axes.*.range", "numbers", "", "–", "[low, high, n]: n evenly spaced values, in place of a list"},
    {"study.axes.*.log_range", "numbers", "", "–", "[low, high, n]: n values with equal ratios"},
    {"study.axes.*.low", "number", "", "–", "least value of an axis with random values"},
    {"study.axes.*.high", "number", "", "–", "greatest value of an axis with random values"},
    {"study.axes.*.spacing", "text", "", "\"linear\"", "distribution of random values; or \"log\""},
    {"study.axes.*.unit", "text", "", "\"\"", "as shown"},
    {"study.axes.*.scale", "number", "", "1", "displayed value / value of the key"},
    {"study.measure.*.column", "text", "", "required",
     "column of trajectory.csv or forces.csv, an instrument, or a number of run.json"},
    {"study.measure.*.reduce", "text", "", "required",
     "\"mean\", \"rms\", \"min\", \"max\", \"peak\", \"first\", \"last\", \"std\", \"quantile\" or \"count\""},
    {"study.measure.*.q", "number", "", "required", "probability of the quantile, from 0 to 1"},
    {"study.measure.*.each", "text", "", "–", "\"period\": reduced over each period, then their mean"},
    {"study.measure.*.at", "text", "", "–",
     "section: only its points are evaluated; \"every period\", \"JOINT.angle crosses VALUE upwards\", "
     "\"each touch\""},
    {"study.derived", "table", "", "–",
     "NAME = \"expression of axes, statistics and measures\", any number of them"},
    {"study.units", "table", "", "–",
     "NAME = \"unit\" of measures and derived quantities, as figures show it; default of a measure: that of its "
     "column"},
    {"study.variants.*.title", "text", "", "its name", "what the variant changes"},
    {"study.variants.*.scene", "text", "", "the study's", "another scene file"},
    {"study.variants.*.set", "names", "", "[]", "keys of the scene, KEY=VALUE"},
    {"study.variants.*.formulations", "names", "", "the study's", "as in the study"},
    {"study.variants.*.starts", "number", "", "the study's", "as in the study"},
    {"study.variants.*.revolutions", "number", "", "the study's", "as in the study"},
    {"study.calibrate.formulation", "text", "", "\"nonsmooth\"", "which is fitted"},
    {"study.calibrate.points", "number", "", "64",
     "number of points of the space-filling design for the "
     "response surface"},
    {"study.calibrate.starts", "number", "", "2", "perturbed starts for each point and target"},
    {"study.calibrate.revolutions", "number", "", "20",
     "evaluated revolutions of each run; at most the complete revolutions of a target's file"},
    {"study.calibrate.refinements", "number", "", "8",
     "greatest number of refinements where the misfit is small; a whole number"},
    {"study.calibrate.leave_out", "true or false", "", "true", "also fit without each target and predict it"},
    {"study.calibrate.unknowns.*.key", "text", "", "required", "scene key to be fitted"},
    {"study.calibrate.unknowns.*.low", "number", "", "required", "least value"},
    {"study.calibrate.unknowns.*.high", "number", "", "required", "greatest value"},
    {"study.calibrate.unknowns.*.scale", "text", "", "\"linear\"", "or \"log\""},
    {"study.calibrate.unknowns.*.unit", "text", "", "\"\"", "as shown"},
    {"study.calibrate.targets.*.set", "names", "", "[]", "keys of the scene for this target, KEY=VALUE"},
    {"study.calibrate.targets.*.statistic", "text", "", "required",
     "statistic of a run (docs/reference/study.md lists them), measure of the study, \"waveform\", or "
     "quantity such as event.1.t"},
    {"study.calibrate.targets.*.value", "number", "", "–", "as measured"},
    {"study.calibrate.targets.*.data", "text", "", "–",
     "measured file for computing the statistic, in place of value"},
    {"study.calibrate.targets.*.tolerance", "number", "", "0.1",
     "relative standard uncertainty of the value; of a waveform 0.01"},
    {"study.calibrate.targets.*.deviation", "number", "", "–",
     "standard uncertainty of a quantity in SI units, in place of tolerance"},
    {"study.bifurcation.axis", "text", "", "the first", "swept axis of the study"},
    {"study.bifurcation.direction", "text", "", "\"both\"",
     "\"up\", \"down\" or \"both\": each value starts from the final state of its neighbour; \"none\""},
    {"study.bifurcation.starts", "number", "", "0", "additional random starts of each value"},
    {"study.bifurcation.formulation", "text", "", "\"nonsmooth\"", "which runs"},
    {"study.bifurcation.set", "names", "", "[]", "keys of the scene, KEY=VALUE"},
    {"study.bifurcation.section", "text", "", "\"every period\"",
     "section at which the motion is recorded: docs/how-to/attractors.md"},
    {"study.bifurcation.period", "number", "s", "of the drive", "period unit of discard and keep"},
    {"study.bifurcation.discard", "number", "", "200", "discarded periods before the recorded points"},
    {"study.bifurcation.keep", "number", "", "60", "recorded periods"},
    {"study.bifurcation.columns", "names", "", "of the section",
     "columns that distinguish attractors; the first is plotted"},
    {"study.bifurcation.tolerance", "number", "", "0.001",
     "tolerance for equal points, relative to a column's scale"},
    {"study.bifurcation.most_period", "number", "", "16", "longest period of the search"},
    {"study.bifurcation.exponents", "true or false", "", "false",
     "largest Lyapunov exponent of each attractor: docs/how-to/attractors.md"},
    {"study.bifurcation.exponent_periods", "number", "", "keep",
     "least number of periods over which it is averaged"},
    {"study.basin.x", "text", "", "the first", "horizontal axis of the study"},
    {"study.basin.y", "text", "", "the second", "vertical axis of the study"},
    {"study.basin.formulation", "text", "", "\"nonsmooth\"", "which runs"},
    {"study.basin.set", "names", "", "[]", "keys of the scene, KEY=VALUE"},
    {"study.basin.section", "text", "", "\"every period\"",
     "section at which the motion is recorded: docs/how-to/attractors.md"},
    {"study.basin.period", "number", "s", "of the drive", "period unit of discard and keep"},
    {"study.basin.discard", "number", "", "200", "discarded periods before the recorded points"},
    {"study.basin.keep", "number", "", "60", "recorded periods"},
    {"study.basin.columns", "names", "", "of the section",
     "columns that distinguish attractors; the first is plotted"},
    {"study.basin.tolerance", "number", "", "0.001",
     "tolerance for equal points, relative to a column's scale"},
    {"study.basin.most_period", "number", "", "16", "longest period of the search"},
    {"study.basin.exponents", "true or false", "", "false",
     "largest Lyapunov exponent of each attractor: docs/how-to/attractors.md"},
    {"study.basin.exponent_periods", "number", "", "keep",
     "least number of periods over which it is averaged"},
    {"study.continue.key", "text", "", "required", "key of the scene with one number; KEY[i] within a list"},
    {"study.continue.from", "number", "", "required",
     "value of the key at which the branch begins; units as in scenes"},
    {"study.continue.to", "number", "", "required", "other end of the range of the key"},
    {"study.continue.start", "number", "", "from",
     "value within the range at which the branch begins; it is followed to both sides"},
    {"study.continue.step", "number", "", "a fiftieth of the range", "greatest step of the key"},
    {"study.continue.set", "names", "", "[]", "keys of the scene, KEY=VALUE"},
    {"study.continue.formulation", "text", "", "\"nonsmooth\"", "\"penalty\" or \"nonsmooth\""},
    {"study.continue.periods", "number", "", "1", "periods of the drive after which the motion repeats"},
    {"study.continue.settle", "number", "", "10", "periods of the drive before the first guess"},
    {"study.continue.period", "number", "s", "of the drive",
     "period of the drives; without a drive, an estimate of that of the motion"},
    {"study.continue.follow_doubled", "number", "", "1",
     "number of successive period doublings whose branches are followed"},
    {"study.continue.most_points", "number", "", "2000", "most motions of a branch"},
    {"study.continue.scale", "number", "", "1", "factor of the values of the key in the figure"},
    {"study.continue.unit", "text", "", "\"\"", "unit of the scaled values"},
    {"study.continue.events", "names", "", "[]",
     "expressions of the columns of branch.csv whose zeros are located on the branches"},
    {"study.continue.second", "text", "", "–",
     "second key, over which the bifurcations are followed: curves of both keys; its value in the scene is the start"},
    {"study.continue.second_from", "number", "", "required", "with second: one end of its range"},
    {"study.continue.second_to", "number", "", "required", "with second: other end of its range"},
    {"study.continue.second_step", "number", "", "a fiftieth of the range",
     "with second: greatest step; that of the first key has the same share of its range"},
    {"study.continue.second_scale", "number", "", "1", "with second: factor of its values in the figure"},
    {"study.continue.second_unit", "text", "", "\"\"", "with second: unit of the scaled values"},
    {"study.continue.curves", "names", "", "all",
     "with second: kinds that are followed: \"fold\", \"flip\", \"torus\", \"grazing\", \"liftoff\""},
};

/// Keys of a figure style, read by plots/drawing/style.cpp.
constexpr SchemaKey style_keys[] = {
    {"style.font", "text", "", "\"DejaVu Sans\"", "installed font family of texts"},
    {"style.font_size", "number", "", "7", "font size on paper, in points of 1/72 in, 4 to 40"},
    {"style.line_width", "number", "", "1", "factor of the default line widths, 0.2 to 10"},
    {"style.colours", "text or names", "", "–",
     "of penalty, nonsmooth, the ideal joint and further curves, taken in turn: \"#rrggbb\" or names; or "
     "\"okabe-ito\""},
    {"style.monochrome", "true or false", "", "false", "black lines, distinguished by dashes and marks"},
    {"style.size", "text", "", "–",
     "width required by a journal: \"one-column\" (90 mm), \"one-and-a-half-column\" (140), \"two-column\" "
     "(190), \"springer-one-column\" (84), \"springer-two-column\" (174), \"ieee-one-column\" (88.9), "
     "\"ieee-two-column\" (181.9), \"slide\" (254)"},
    {"style.width", "number", "", "each figure's own",
     "width on paper in mm, or with its unit, \"9 cm\"; or size"},
    {"style.height", "number", "", "each figure's own", "height on paper in mm, likewise"},
    {"style.format", "text or names", "", "\"pdf\"",
     "for papers: \"pdf\", \"svg\", \"eps\", \"cairolatex\"; \"png\" for no other. A PNG is drawn in any case"},
};

/// Lists the keys of all kinds in V, which share one table; `type` or a key selects the kind.
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
  list.plain({"format", "", ""}, "number", "2",
             "format of the scene, a whole number; fixes the defaults of that format; 2 is the newest");
  list.plain({"title", "", ""}, "text", "\"\"", "title of the scene in results and figures");
  list.plain({"gravity", "m/s²", ""}, "point", "[0, 0]", "acceleration of gravity in the plane of motion");
  list_facts<Ground>(list, "ground");
  list_facts<Body>(list, "bodies.*");
  list_kinds<Joint>(list, "joints.*");
  list_kinds<Contact>(list, "contacts.*");
  list_facts<Group>(list, "groups.*");
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

/// All keys, made once. Their texts live as long as the program.
const std::vector<SchemaKey>& keys() {
  static const auto rows = scene_rows();
  static const auto list = [] {
    std::vector<SchemaKey> keys;
    for (const auto& r : rows) keys.push_back({r.path, r.type, r.unit, r.fallback, r.meaning});
    keys.insert(keys.end(), std::begin(study_keys), std::end(study_keys));
    keys.insert(keys.end(), std::begin(style_keys), std::end(style_keys));
    return keys;
  }();
  return list;
}

/// Descriptions of tables.
constexpr std::pair<std::string_view, std::string_view> tables[] = {
    {"", "a scene"},
    {"ground", "[ground]"},
    {"bodies.*", "a body"},
    {"joints.*", "a joint"},
    {"contacts.*", "a contact"},
    {"groups.*", "a group"},
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
    {"study.measure.*", "a measure"},
    {"study.variants.*", "a variant"},
    {"study.calibrate", "[calibrate]"},
    {"study.calibrate.unknowns.*", "an unknown"},
    {"study.calibrate.targets.*", "a target"},
    {"study.bifurcation", "[bifurcation]"},
    {"study.basin", "[basin]"},
    {"study.continue", "[continue]"},
    {"style", "a style"}};

}  // namespace

std::span<const SchemaKey> schema() { return keys(); }

bool of_scene(const SchemaKey& key) {
  return !key.path.starts_with("study.") && !key.path.starts_with("style.");
}

const SchemaKey* find_key(std::string_view path) {
  const auto it = std::ranges::find(keys(), path, &SchemaKey::path);
  return it == keys().end() ? nullptr : &*it;
}

std::string_view unit_of(const std::string& name) {
  const auto key = name.substr(0, name.find('['));
  const auto first = key.find('.'), last = key.rfind('.');
  const auto* row = find_key(first == last ? key : key.substr(0, first) + ".*" + key.substr(last));
  if (!row || key == name) return row ? row->unit : "";
  const auto comma = row->unit.find(", ");  // of the columns of a list of points
  if (comma == row->unit.npos) return row->unit;
  return name.ends_with("[0]") ? row->unit.substr(0, comma) : row->unit.substr(comma + 2);
}

const std::vector<std::string>& keys_of(std::string_view table) {
  using Names = std::map<std::string, std::vector<std::string>, std::less<>>;
  static const auto all = [] {  // found once, since every scene of a sweep asks for them
    Names found;
    const auto add = [&](std::string_view in, std::string_view name) {
      auto& names = found[std::string(in)];
      if (std::ranges::find(names, name) == names.end()) names.emplace_back(name);
    };
    for (const auto& key : keys()) {
      if (of_scene(key)) add("", key.path.substr(0, key.path.find('.')));
      for (auto dot = key.path.find('.'); dot != key.path.npos; dot = key.path.find('.', dot + 1)) {
        const auto rest = key.path.substr(dot + 1);
        add(key.path.substr(0, dot), rest.substr(0, rest.find('.')));
      }
    }
    return found;
  }();
  static const std::vector<std::string> none;
  const auto it = all.find(table);
  return it == all.end() ? none : it->second;
}

std::string_view what_is(std::string_view table) {
  const auto it = std::ranges::find(tables, table, &std::pair<std::string_view, std::string_view>::first);
  return it == std::end(tables) ? "a table" : it->second;
}

}  // namespace freeplay
