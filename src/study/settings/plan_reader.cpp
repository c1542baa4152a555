// What concerns several keys of [calibrate], [bifurcation], [basin] or [continue] of a study, or
// other tables.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "io/files/digest.hpp"
#include "measure/turns.hpp"
#include "study/settings/study_reader.hpp"

namespace freeplay {
namespace {

constexpr int most_events = 1000;  // of a fitted run

/// Refuses a key that is varied and also set.
void refuse_twice_set(Section& s, const std::vector<std::string>& overrides, const std::string& key,
                      const std::string& by) {
  for (const auto& set : overrides)
    if (set.substr(0, set.find_first_of(" =")) == key)
      s.fail("set", fmt::format("{} is varied by {}", key, by));
}

}  // namespace

std::vector<BifurcationKind> read_curve_kinds(Section& s, std::string_view key) {
  std::vector<BifurcationKind> kinds;
  for (const auto& name : s.names(key)) {
    const auto known = std::ranges::find_if(bifurcation_names, [&](const char* n) { return name == n; });
    const auto kind = static_cast<BifurcationKind>(known - bifurcation_names.begin());
    if (known == bifurcation_names.end() || kind >= BifurcationKind::sequence)
      s.fail(key, fmt::format("\"{}\" is no kind of curve; use fold, flip, torus, grazing or liftoff", name));
    kinds.push_back(kind);
  }
  return kinds;
}

void StudyReader::axis_of(const Key& key, std::size_t& axis, std::size_t otherwise) {
  const auto& axes = study_.axes;
  if (axes.empty()) s_.fail(key.name, "the study has no axes; add [axes.NAME] with key and values");
  axis = otherwise;
  if (s_.has(key.name) || axes.size() <= otherwise) {
    const auto name = s_.text(key.name);
    std::vector<std::string> names;
    for (const auto& a : axes) names.push_back(a.name);
    axis = static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
    if (axis == axes.size())
      s_.fail(key.name, fmt::format("\"{}\" is not an axis of the study; {} {}", name, fmt::join(names, ", "),
                                    names.size() > 1 ? "are" : "is"));
  }
  if (axes[axis].drawn)
    s_.fail(key.name, fmt::format("axis {} has random values; give it values or a range", axes[axis].name));
}

void StudyReader::finish(Unknown& u) {
  if (u.high <= u.low) s_.fail("high", fmt::format("must be greater than low = {}, is {}", u.low, u.high));
  if (u.logarithmic && u.low <= 0) s_.fail("low", "must be greater than 0 on a log scale");
}

/// A target such as event.1.t, which is fitted with its derivatives.
void StudyReader::finish_quantity(Target& x) {
  // A fit needs the times of all events up to this one, and their derivatives.
  constexpr std::string_view event = "event.";
  if (x.statistic.starts_with(event) &&
      std::strtod(x.statistic.c_str() + event.size(), nullptr) > most_events)
    s_.fail("statistic",
            fmt::format("\"{}\": only the first {} contact events can be targets", x.statistic, most_events));
  x.value = s_.number("value", any_number);
  if (s_.has("deviation") == s_.has("tolerance"))
    s_.fail("", "needs exactly one of deviation (SI units) and tolerance (relative)");
  if (x.deviation == 0 && x.value == 0)
    s_.fail("tolerance", "is relative to value, which is 0; give deviation instead");
}

void StudyReader::finish(Target& x) {
  if (x.is_quantity()) return finish_quantity(x);
  if (!s_.has("tolerance")) x.tolerance = x.is_waveform() ? 0.01 : 0.1;
  if (x.is_waveform()) {
    if (!s_.has("data")) s_.fail("data", "is required for a waveform: the measured file");
    if (study_.accelerometer.empty()) s_.fail("statistic", "\"waveform\" needs the study's accelerometer");
    Measure measure{.name = x.measure(),
                    .column = study_.accelerometer,
                    .reduce = Reduce::rms,
                    .at = {},
                    .waveform = x.data,
                    .digest = digest(read_text(x.data)),
                    .tolerance = x.tolerance,
                    .overrides = x.overrides};
    finish(measure);
    study_.measures.push_back(std::move(measure));
    return;
  }
  const auto& known = TurnMetrics::names();
  const bool measure =
      std::ranges::find(study_.measures, x.statistic, &Measure::name) != study_.measures.end();
  if (!measure && std::ranges::find(known, x.statistic) == known.end())
    s_.fail("statistic",
            fmt::format("\"{}\" is neither a statistic nor a measure of the study; known are {}, waveform",
                        x.statistic, fmt::join(known, ", ")));
  if (measure && s_.has("data"))
    s_.fail("statistic", fmt::format("\"{}\" is a measure of a run, which a file of a signal cannot "
                                     "provide; give its value",
                                     x.statistic));
  const auto place = static_cast<TurnMetrics::Name>(std::ranges::find(known, x.statistic) - known.begin());
  if (!measure && TurnMetrics::kind(place) == TurnMetrics::Kind::direction)
    s_.fail("statistic",
            fmt::format("\"{}\" is an angle on the circle; the fit of logarithms needs positive quantities",
                        x.statistic));
  if (s_.has("value") == s_.has("data")) s_.fail("", "needs exactly one of value and data");
}

void StudyReader::finish(Calibration& c) {
  const auto other = std::ranges::find_if(
      c.targets, [&](const Target& t) { return t.is_quantity() != c.targets.front().is_quantity(); });
  if (other != c.targets.end())
    s_.fail("targets." + other->name + ".statistic",
            fmt::format("\"{}\" and \"{}\" are a quantity of one run and a statistic, which are fitted by "
                        "different methods; calibrate them in two studies",
                        other->statistic, c.targets.front().statistic));
}

void StudyReader::refuse_varied(const AttractorPlan& p, std::initializer_list<std::size_t> axes) {
  for (const auto place : axes) {
    const auto& axis = study_.axes[place];
    refuse_twice_set(s_, p.overrides, axis.key, "axis " + axis.name);
    for (const auto& key : axis.others) refuse_twice_set(s_, p.overrides, key, "axis " + axis.name);
  }
}

void StudyReader::finish(ContinuationPlan& p) {
  if (p.from == p.to) s_.fail("to", fmt::format("must differ from from = {}", p.from));
  const auto [low, high] = std::minmax(p.from, p.to);
  if (p.start && !(*p.start >= low && *p.start <= high))
    s_.fail("start", fmt::format("must be from {} to {}", low, high));
  refuse_twice_set(s_, p.overrides, p.key, "the continuation");
  if (!p.second) return;
  if (p.second->key == p.key) s_.fail("second", "must differ from key");
  if (p.second->from == p.second->to)
    s_.fail("second_to", fmt::format("must differ from second_from = {}", p.second->from));
}

}  // namespace freeplay
