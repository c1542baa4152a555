#include "study/study.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "io/section.hpp"
#include "measure/turns.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

constexpr Range below_one{[](double x) { return x >= 0 && x < 1; }, "at least 0 and below 1"};
constexpr Range count{
    [](double x) { return x >= 1 && x <= 1e6 && x == static_cast<double>(static_cast<int>(x)); },
    "a whole number from 1"};

std::vector<std::string> formulations(Section& s, std::vector<std::string> fallback) {
  if (!s.has("formulations")) return fallback;
  auto list = s.names("formulations");
  for (const auto& name : list)
    if (!family_named(name))
      s.fail("formulations",
             fmt::format("\"{}\" is none; \"{}\" are", name, fmt::join(family_names(), "\" and \"")));
  if (list.empty()) s.fail("formulations", "must name at least one");
  return list;
}

/// The key of KEY=VALUE.
std::string key_of(const std::string& override) { return override.substr(0, override.find_first_of(" =")); }

Axis read_axis(const std::string& name, Section& s) {
  std::vector<std::string_view> columns(TurnMetrics::names().begin(), TurnMetrics::names().end());
  for (const char* column : {"run", "variant", "formulation", "start", "status", "reason"})
    columns.emplace_back(column);
  if (std::ranges::find(columns, name) != columns.end())
    s.fail("", fmt::format("\"{}\" is a column of the results; give the axis another name", name));
  Axis a;
  a.name = name;
  a.key = s.text("key");
  a.values = s.numbers("values");
  a.unit = s.text("unit", "");
  a.scale = s.number("scale", positive, 1);
  s.done("an axis");
  return a;
}

Calibration read_calibration(Section s, const std::filesystem::path& folder) {
  Calibration c;
  c.formulation = families[s.choice("formulation", family_names(), 1)].text;
  c.points = static_cast<int>(s.number("points", count, c.points));
  c.starts = static_cast<int>(s.number("starts", count, c.starts));
  c.revolutions = s.number("revolutions", one_or_more, c.revolutions);
  for (auto& [name, u] : s.children("unknowns")) {
    Unknown x{name, u.text("key"), "", u.number("low", any_number), u.number("high", any_number), false};
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
    const auto& known = TurnMetrics::names();
    if (std::ranges::find(known, x.statistic) == known.end())
      t.fail("statistic", fmt::format("\"{}\" is none; there are {}", x.statistic, fmt::join(known, ", ")));
    if (t.has("value") == t.has("data")) t.fail("", "needs exactly one of value and data");
    if (t.has("value"))
      x.value = t.number("value", any_number);
    else
      x.data = folder / t.text("data");
    x.tolerance = t.number("tolerance", positive, 0.1);
    t.done("a target");
    c.targets.push_back(x);
  }
  if (c.unknowns.empty()) s.fail("unknowns", "must name at least one unknown");
  if (c.targets.empty()) s.fail("targets", "must name at least one target");
  s.done("[calibrate]");
  return c;
}

}  // namespace

Study read_study(const std::filesystem::path& file) {
  Study study;
  study.file = file;
  study.text = read_text(file);
  const SceneSource source{file.string(), {}};
  const toml::table document = parse_toml(study.text, file.string());
  Section root(document, "", "study", source);
  study.title = root.text("title", "");
  const auto folder = file.parent_path();
  study.scene = folder / root.text("scene");
  study.claims = root.text("claims", "");
  if (root.has("fit")) study.fit = folder / root.text("fit");
  study.joint = root.text("joint", "");
  study.accelerometer = root.text("accelerometer", "");
  study.position = root.text("position", "");
  const auto both = formulations(root, family_names());
  study.matched = root.choice("restitution", {"delivered", "as-given"}, 0) == 0;
  study.revolutions = root.number("revolutions", one_or_more, 50);
  study.discard = root.number("discard", non_negative, 2);
  study.starts = static_cast<int>(root.number("starts", count, 8));
  study.seed = static_cast<std::uint64_t>(root.number("seed", whole, 1));
  study.perturbation = {root.number("turn", zero_to_one, 1), root.number("play", below_one, 0.9)};
  study.flight_angle = root.number("flight_angle", non_negative, study.flight_angle);
  study.impact_speed = root.number("impact_speed", non_negative, study.impact_speed);
  study.line_share = root.number("line_share", positive, study.line_share);
  for (auto& [name, s] : root.children("axes")) {
    auto axis = read_axis(name, s);
    for (const auto& other : study.axes)
      if (other.key == axis.key)
        s.fail("key", fmt::format("{} varies already by axis {}", axis.key, other.name));
    study.axes.push_back(std::move(axis));
  }
  for (auto& [name, s] : root.children("variants")) {
    Variant v{name,         s.text("title", name), study.scene, {}, formulations(s, both),
              study.starts, study.revolutions};
    if (s.has("scene")) v.scene = folder / s.text("scene");
    if (s.has("set")) v.overrides = s.names("set");
    v.starts = static_cast<int>(s.number("starts", count, v.starts));
    v.revolutions = s.number("revolutions", one_or_more, v.revolutions);
    for (const auto& o : v.overrides) {
      for (const auto& axis : study.axes)
        if (key_of(o) == axis.key)
          s.fail("set", fmt::format("{} is what axis {} varies", axis.key, axis.name));
    }
    s.done("a variant");
    study.variants.push_back(v);
  }
  if (study.variants.empty())
    study.variants.push_back({"given", "as given", study.scene, {}, both, study.starts, study.revolutions});
  if (root.has("calibrate")) study.calibration = read_calibration(root.child("calibrate"), folder);
  root.done("a study");
  return study;
}

}  // namespace freeplay
