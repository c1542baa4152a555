#include "study/settings/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "io/files/digest.hpp"
#include "io/files/visible.hpp"
#include "io/scene/schema.hpp"
#include "io/scene/section.hpp"
#include "io/scene/toml_value.hpp"
#include "measure/turns.hpp"
#include "study/settings/study_parts.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

constexpr Range below_one{[](double x) { return x >= 0 && x < 1; }, "at least 0 and below 1"};
constexpr auto count = study_count;

/// Limit of the runs of one study, which are planned at once and stored in one database.
constexpr double most_runs = 1e6;

std::vector<std::string> formulations(Section& s, std::vector<std::string> fallback) {
  if (!s.has("formulations")) return fallback;
  auto list = s.names("formulations");
  for (const auto& name : list)
    if (!family_named(name))
      s.fail("formulations", fmt::format("\"{}\" is unknown; known are \"{}\"", name,
                                         fmt::join(family_names(), "\" and \"")));
  if (list.empty()) s.fail("formulations", "must name at least one");
  return list;
}

/// The key of KEY=VALUE.
std::string key_of(const std::string& override) { return override.substr(0, override.find_first_of(" =")); }

/// The path of the file that a key names, relative to the study's folder.
std::filesystem::path named_file(Section& s, const char* key, const Study& study) {
  const auto folder = study.file.parent_path();
  const auto name = s.text(key);
  const auto file = folder / name;
  if (study.reach == Reach::beside && !lies_below(file, folder))
    s.fail(key,
           fmt::format("\"{}\" is outside the study's folder; move it there, or pass --allow-outside", name));
  return file;
}

constexpr int most_events = 1000;  // of a fitted run

/// A target such as event.1.t, which is fitted with its derivatives.
Target quantity_target(Section& t, Target x) {
  x.value = t.number("value", any_number);
  if (t.has("deviation") == t.has("tolerance"))
    t.fail("", "needs exactly one of deviation (SI units) and tolerance (relative)");
  if (t.has("deviation"))
    x.deviation = t.number("deviation", positive);
  else
    x.tolerance = t.number("tolerance", positive);
  if (x.deviation == 0 && x.value == 0)
    t.fail("tolerance", "is relative to value, which is 0; give deviation instead");
  t.done("a target");
  return x;
}

Calibration read_calibration(Section s, Study& study) {
  Calibration c;
  c.formulation = families[s.choice("formulation", family_names(), 1)].text;
  c.points = static_cast<int>(s.number("points", count, c.points));
  c.starts = static_cast<int>(s.number("starts", count, c.starts));
  c.revolutions = s.number("revolutions", one_or_more, c.revolutions);
  c.refinements = static_cast<int>(s.number("refinements", whole, c.refinements));
  c.leave_out = s.flag("leave_out", c.leave_out);
  for (auto& [name, table] : s.children("unknowns")) {
    auto& u = table;
    const auto key = u.text("key");
    const auto bound = [&u = u, &key](const char* end) {
      return u.number(Key{end, unit_of(key), {}}, any_number);
    };
    Unknown x{name, key, "", bound("low"), bound("high"), false};
    if (x.high <= x.low) u.fail("high", fmt::format("must be greater than low = {}, is {}", x.low, x.high));
    x.logarithmic = u.choice("scale", {"linear", "log"}, 0) == 1;
    if (x.logarithmic && x.low <= 0) u.fail("low", "must be greater than 0 on a log scale");
    x.unit = u.text("unit", "");
    u.done("an unknown");
    c.unknowns.push_back(x);
  }
  for (auto& [name, t] : s.children("targets")) {
    Target x;
    x.name = name;
    if (t.has("set")) x.overrides = t.names("set");
    x.statistic = t.text("statistic");
    if (x.is_quantity()) {
      // A fit needs the times of all events up to this one, and their derivatives.
      constexpr std::string_view event = "event.";
      if (x.statistic.starts_with(event) &&
          std::strtod(x.statistic.c_str() + event.size(), nullptr) > most_events)
        t.fail("statistic", fmt::format("\"{}\": only the first {} contact events can be targets",
                                        x.statistic, most_events));
      c.targets.push_back(quantity_target(t, std::move(x)));
      continue;
    }
    if (x.is_waveform()) {
      if (!t.has("data")) t.fail("data", "is required for a waveform: the measured file");
      if (study.accelerometer.empty()) t.fail("statistic", "\"waveform\" needs the study's accelerometer");
      x.data = named_file(t, "data", study);
      x.tolerance = t.number("tolerance", positive, 0.01);
      add_measure(study,
                  {.name = x.measure(),
                   .column = study.accelerometer,
                   .reduce = Reduce::rms,
                   .at = {},
                   .waveform = x.data,
                   .digest = digest(read_text(x.data)),
                   .tolerance = x.tolerance,
                   .overrides = x.overrides},
                  t);
      t.done("a target");
      c.targets.push_back(x);
      continue;
    }
    const auto& known = TurnMetrics::names();
    const bool measure =
        std::ranges::find(study.measures, x.statistic, &Measure::name) != study.measures.end();
    if (!measure && std::ranges::find(known, x.statistic) == known.end())
      t.fail("statistic",
             fmt::format("\"{}\" is neither a statistic nor a measure of the study; known are {}, waveform",
                         x.statistic, fmt::join(known, ", ")));
    if (measure && t.has("data"))
      t.fail("statistic", fmt::format("\"{}\" is a measure of a run, which a file of a signal cannot "
                                      "provide; give its value",
                                      x.statistic));
    const auto place = static_cast<TurnMetrics::Name>(std::ranges::find(known, x.statistic) - known.begin());
    if (!measure && TurnMetrics::kind(place) == TurnMetrics::Kind::direction)
      t.fail("statistic",
             fmt::format("\"{}\" is an angle on the circle; the fit of logarithms needs positive quantities",
                         x.statistic));
    if (t.has("value") == t.has("data")) t.fail("", "needs exactly one of value and data");
    if (t.has("value"))
      x.value = t.number("value", any_number);
    else
      x.data = named_file(t, "data", study);
    x.tolerance = t.number("tolerance", positive, 0.1);
    t.done("a target");
    c.targets.push_back(x);
  }
  if (c.unknowns.empty()) s.fail("unknowns", "must name at least one unknown");
  if (c.targets.empty()) s.fail("targets", "must name at least one target");
  const auto other = std::ranges::find_if(
      c.targets, [&](const Target& t) { return t.is_quantity() != c.targets.front().is_quantity(); });
  if (other != c.targets.end())
    s.fail("targets." + other->name + ".statistic",
           fmt::format("\"{}\" and \"{}\" are a quantity of one run and a statistic, which are fitted by "
                       "different methods; calibrate them in two studies",
                       other->statistic, c.targets.front().statistic));
  s.done("[calibrate]");
  return c;
}

/// Visits each setting of a study that affects the digits of single runs, to read it or to write it
/// into an identity. The number of runs and their evaluation are not included.
template <class Visit>
void each_setting(Study& study, Visit&& visit) {
  visit("joint", study.joints);
  visit("accelerometer", study.accelerometer);
  visit("position", study.position);
  visit("restitution", study.matched);
  visit("discard", study.discard, non_negative);
  visit("seed", study.seed);
  visit("turn", study.perturbation.turn, zero_to_one);
  visit("play", study.perturbation.play, below_one);
  visit("flight_angle", study.flight_angle, non_negative);
  visit("impact_speed", study.impact_speed, non_negative);
  visit("line_share", study.line_share, positive);
}

/// Reads a setting; the present value is the default.
struct ReadSetting {
  Section& root;
  void operator()(const char* key, std::string& value) { value = root.text(key, value); }
  void operator()(const char* key, std::vector<std::string>& value) {
    if (root.has(key)) value = root.name_or_names(key);
  }
  void operator()(const char* key, double& value, Range range) { value = root.number(key, range, value); }
  void operator()(const char* key, std::uint64_t& value) {
    value = static_cast<std::uint64_t>(root.number(key, whole, static_cast<double>(value)));
  }
  void operator()(const char* key, bool& matched) {
    matched = root.choice(key, {"delivered", "as-given"}, matched ? 0 : 1) == 0;
  }
};

struct SaySetting {
  std::string& text;
  void say(const char* key, const std::string& value) { text += fmt::format("{} = {}\n", key, value); }
  void operator()(const char* key, const std::string& value) { say(key, toml_quoted(value)); }
  void operator()(const char* key, const std::vector<std::string>& value) {
    std::string list;
    for (const auto& name : value) list += (list.empty() ? "" : ", ") + toml_quoted(name);
    say(key, value.size() == 1 ? list : value.empty() ? "\"\"" : fmt::format("[{}]", list));
  }
  void operator()(const char* key, double value, Range) { say(key, toml_number(value)); }
  void operator()(const char* key, std::uint64_t value) { say(key, fmt::format("{}", value)); }
  void operator()(const char* key, bool matched) { say(key, matched ? "\"delivered\"" : "\"as-given\""); }
};

}  // namespace

std::string settings_text(Study study) {
  std::string text;
  each_setting(study, SaySetting{text});
  if (study.period) text += fmt::format("period = {}\n", toml_number(*study.period));
  for (const auto& measure : study.measures) text += said(measure);
  return text;
}

SceneError error_at(const Study& study, const std::vector<std::string>& path, const std::string& message) {
  const toml::table document = parse_toml(study.text, study.file.string());
  const toml::node* node = &document;
  for (const auto& name : path) {
    const auto* table = node->as_table();
    if (const auto* inner = table ? table->get(name) : nullptr) node = inner;
  }
  try {
    SceneSource{.name = study.file.string()}.fail(node, fmt::format("{}", fmt::join(path, ".")), message);
  } catch (const SceneError& placed) {
    return placed;
  }
}

SceneError in_study(const Study& study, const SceneError& error) {
  const std::string what = error.what();
  constexpr std::string_view option = "--set ";
  if (!what.starts_with(option)) return error;
  std::vector<std::string> tables;  // path of the table that sets the option
  std::string message;
  // `opening`: beginning of the options that an element sets. The rest of the option may contain
  // the value, then the message.
  const auto look = [&](const std::vector<std::string>& family, const std::string& name,
                        const std::string& opening) {
    const auto end = what.find(": ", option.size() + opening.size() - 1);
    if (!tables.empty() || !std::string_view(what).substr(option.size()).starts_with(opening) ||
        end == what.npos)
      return;
    tables = family;
    tables.push_back(name);
    message = what.substr(end + 2);
  };
  const auto sets = [&](const std::vector<std::string>& family, const auto& x) {
    for (const auto& set : x.overrides) look(family, x.name, visible(set) + ":");
  };
  const auto set_in = [&](const char* table, const auto& plan) {
    if (!plan) return;
    for (const auto& set : plan->overrides) look({}, table, visible(set) + ":");
  };
  set_in("bifurcation", study.bifurcation);
  set_in("basin", study.basin);
  set_in("continue", study.continuation);
  for (const auto& axis : study.axes) {
    look({"axes"}, axis.name, axis.key + "=");
    for (const auto& key : axis.others) look({"axes"}, axis.name, key + "=");
  }
  for (const auto& variant : study.variants) sets({"variants"}, variant);
  if (study.calibration) {
    for (const auto& x : study.calibration->unknowns) look({"calibrate", "unknowns"}, x.name, x.key + "=");
    for (const auto& x : study.calibration->targets) sets({"calibrate", "targets"}, x);
  }
  if (tables.empty()) return error;
  return error_at(study, tables, message);
}

Study read_study(const std::filesystem::path& file, Reach reach) {
  Study study;
  study.reach = reach;
  study.file = file;
  study.text = read_text(file);
  const SceneSource source{.name = file.string()};
  const toml::table document = parse_toml(study.text, file.string());
  refuse_unknown_keys(document, "study", source);
  Section root(document, "", "study", source);
  study.title = root.text("title", "");
  study.scene = named_file(root, "scene", study);
  study.claims = root.text("claims", "");
  if (root.has("points")) study.points = named_file(root, "points", study);
  if ((study.claims == "points") != root.has("points"))
    root.fail("claims", "\"points\" and the key points go together; one of them is missing");
  if (root.has("fit")) study.fit = named_file(root, "fit", study);
  const auto both = formulations(root, family_names());
  study.revolutions = root.number("revolutions", one_or_more, 50);
  study.starts_given = root.has("starts");
  study.starts = static_cast<int>(root.number("starts", count, 8));
  study.discard = 2;
  each_setting(study, ReadSetting{root});
  read_windows(root, study);
  read_axes(root, study);
  read_measures(root, study);
  for (auto& [name, s] : root.children("variants")) {
    Variant v{name,         s.text("title", name), study.scene, {}, formulations(s, both),
              study.starts, study.revolutions};
    if (s.has("scene")) v.scene = named_file(s, "scene", study);
    if (s.has("set")) v.overrides = s.names("set");
    v.starts = static_cast<int>(s.number("starts", count, v.starts));
    v.revolutions = s.number("revolutions", one_or_more, v.revolutions);
    study.in_periods |= s.has("revolutions");
    if (s.has("revolutions") && study.duration)
      s.fail("revolutions", "counts periods, but the study's duration is in seconds");
    if (s.has("starts")) study.starts_given = true;
    for (const auto& o : v.overrides)
      for (const auto& axis : study.axes)
        if (key_of(o) == axis.key || std::ranges::count(axis.others, key_of(o)) > 0)
          s.fail("set", fmt::format("{} is varied by axis {}", key_of(o), axis.name));
    s.done("a variant");
    study.variants.push_back(v);
  }
  if (study.variants.empty())
    study.variants.push_back({"given",
                              study.title.empty() ? "the scene without variants" : study.title,
                              study.scene,
                              {},
                              both,
                              study.starts,
                              study.revolutions});
  if (root.has("calibrate")) study.calibration = read_calibration(root.child("calibrate"), study);
  if (root.has("bifurcation")) study.bifurcation = read_bifurcation(root.child("bifurcation"), study.axes);
  if (root.has("basin")) study.basin = read_basin(root.child("basin"), study.axes);
  if (root.has("continue")) study.continuation = read_continuation(root.child("continue"));
  root.done("a study");
  require_expressions(study);
  double runs = 0;
  for (const auto& v : study.variants) runs += v.starts * static_cast<double>(v.formulations.size());
  for (const auto& axis : study.axes)
    if (!axis.drawn) runs *= static_cast<double>(axis.values.size());
  if (study.sampling) runs *= study.samples;
  if (runs > most_runs)
    throw SceneError(fmt::format(
        "{}: has {:.3g} runs, above the limit of {:.0f}: give its axes fewer values, or divide it into "
        "several studies",
        file.string(), runs, most_runs));
  return study;
}

}  // namespace freeplay
