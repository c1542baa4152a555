#include "study/attractors/attractor_plan.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "io/scene/section.hpp"
#include "study/settings/study.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

constexpr Range periods{
    [](double x) { return x >= 0 && x <= 1e7 && x == static_cast<double>(static_cast<long>(x)); },
    "a whole number from 0"};
constexpr Range some_periods{
    [](double x) { return x >= 1 && x <= 1e7 && x == static_cast<double>(static_cast<long>(x)); },
    "a whole number from 1"};
constexpr Range below_half{[](double x) { return x > 0 && x < 0.5; }, "greater than 0 and below 0.5"};

std::size_t axis_of(Section& s, const char* key, const std::vector<Axis>& axes, std::size_t otherwise) {
  if (axes.empty()) s.fail(key, "the study has no axes; add [axes.NAME] with key and values");
  const auto fixed = [&](std::size_t i) {
    if (axes[i].drawn)
      s.fail(key, fmt::format("axis {} has random values; give it values or a range", axes[i].name));
    return i;
  };
  if (!s.has(key) && axes.size() > otherwise) return fixed(otherwise);
  const auto name = s.text(key);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (axes[i].name == name) return fixed(i);
    names.push_back(axes[i].name);
  }
  s.fail(key, fmt::format("\"{}\" is not an axis of the study; {} {}", name, fmt::join(names, ", "),
                          names.size() > 1 ? "are" : "is"));
}

void read_common(Section& s, AttractorPlan& p) {
  p.formulation = families[s.choice("formulation", family_names(), 1)].text;
  if (s.has("set")) p.overrides = s.names("set");
  p.section = s.text("section", p.section);
  p.period = s.maybe_number("period", positive);
  p.discard = s.number("discard", periods, p.discard);
  p.keep = s.number("keep", some_periods, p.keep);
  if (s.has("columns")) p.columns = s.names("columns");
  p.tolerance = s.number("tolerance", below_half, p.tolerance);
  p.most_period = static_cast<int>(s.number("most_period", some_periods, p.most_period));
  p.exponents = s.flag("exponents", p.exponents);
  p.exponent_periods = s.maybe_number("exponent_periods", some_periods);
  if (p.exponent_periods && !p.exponents) s.fail("exponent_periods", "needs exponents = true");
}

/// Refuses a key that both the axis and `set` give.
void refuse_twice_set(Section& s, const AttractorPlan& p, const Axis& axis) {
  for (const auto& set : p.overrides) {
    const auto key = set.substr(0, set.find_first_of(" ="));
    if (key == axis.key || std::ranges::count(axis.others, key) > 0)
      s.fail("set", fmt::format("{} is varied by axis {}", key, axis.name));
  }
}

}  // namespace

BifurcationPlan read_bifurcation(Section s, const std::vector<Axis>& axes) {
  BifurcationPlan p;
  p.axis = axis_of(s, "axis", axes, 0);
  const int direction = s.choice("direction", {"up", "down", "both", "none"}, 2);
  p.up = direction == 0 || direction == 2;
  p.down = direction == 1 || direction == 2;
  p.starts = static_cast<int>(s.number("starts", periods, p.starts));
  if (!p.up && !p.down && p.starts == 0)
    s.fail("starts", "with direction = \"none\" there must be at least one start");
  read_common(s, p);
  refuse_twice_set(s, p, axes[p.axis]);
  s.done("[bifurcation]");
  return p;
}

BasinPlan read_basin(Section s, const std::vector<Axis>& axes) {
  BasinPlan p;
  p.x = axis_of(s, "x", axes, 0);
  p.y = axis_of(s, "y", axes, 1);
  if (p.x == p.y) s.fail("y", "must differ from axis x");
  read_common(s, p);
  for (const auto axis : {p.x, p.y}) refuse_twice_set(s, p, axes[axis]);
  s.done("[basin]");
  return p;
}

}  // namespace freeplay
