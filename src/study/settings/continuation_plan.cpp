#include "study/settings/continuation_plan.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "io/scene/schema.hpp"
#include "io/scene/section.hpp"
#include "study/settings/study_parts.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

constexpr Range doublings{
    [](double x) { return x >= 0 && x <= 10 && x == static_cast<double>(static_cast<int>(x)); },
    "a whole number from 0 to 10"};

SecondKeyPlan read_second_key(Section& s, const std::string& first) {
  SecondKeyPlan p;
  p.key = s.text("second");
  if (p.key == first) s.fail("second", "must differ from key");
  const auto number_of_key = [&](const char* name, const Range& range) {
    return s.number(Key{name, unit_of(p.key), {}}, range);
  };
  p.from = number_of_key("second_from", any_number);
  p.to = number_of_key("second_to", any_number);
  if (p.from == p.to) s.fail("second_to", fmt::format("must differ from second_from = {}", p.from));
  if (s.has("second_step")) p.step = number_of_key("second_step", positive);
  if (s.has("curves"))
    for (const auto& name : s.names("curves")) {
      const auto known = std::ranges::find_if(bifurcation_names, [&](const char* n) { return name == n; });
      const auto kind = static_cast<BifurcationKind>(known - bifurcation_names.begin());
      if (known == bifurcation_names.end() || kind >= BifurcationKind::sequence)
        s.fail("curves",
               fmt::format("\"{}\" is no kind of curve; use fold, flip, torus, grazing or liftoff", name));
      p.kinds.push_back(kind);
    }
  p.scale = s.number("second_scale", positive, p.scale);
  p.unit = s.text("second_unit", p.unit);
  return p;
}

}  // namespace

ContinuationPlan read_continuation(Section s) {
  ContinuationPlan p;
  p.key = s.text("key");
  const auto number_of_key = [&](const char* name) {
    return s.number(Key{name, unit_of(p.key), {}}, any_number);
  };
  p.from = number_of_key("from");
  p.to = number_of_key("to");
  if (p.from == p.to) s.fail("to", fmt::format("must differ from from = {}", p.from));
  if (s.has("start")) {
    p.start = number_of_key("start");
    if (!(*p.start >= std::min(p.from, p.to) && *p.start <= std::max(p.from, p.to)))
      s.fail("start", fmt::format("must be from {} to {}", std::min(p.from, p.to), std::max(p.from, p.to)));
  }
  if (s.has("step")) p.step = s.number(Key{"step", unit_of(p.key), {}}, positive);
  if (s.has("set")) p.overrides = s.names("set");
  for (const auto& set : p.overrides)
    if (set.substr(0, set.find_first_of(" =")) == p.key)
      s.fail("set", fmt::format("{} is varied by the continuation", p.key));
  p.formulation = families[s.choice("formulation", family_names(), 1)].text;
  p.periods = static_cast<int>(s.number("periods", study_count, p.periods));
  p.settle = s.number("settle", non_negative, p.settle);
  p.period = s.maybe_number("period", positive);
  p.follow_doubled = static_cast<int>(s.number("follow_doubled", doublings, p.follow_doubled));
  p.most_points = static_cast<int>(s.number("most_points", study_count, p.most_points));
  p.scale = s.number("scale", positive, p.scale);
  p.unit = s.text("unit", p.unit);
  if (s.has("events")) p.events = s.names("events");
  if (s.has("second")) p.second = read_second_key(s, p.key);
  s.done("[continue]");
  return p;
}

}  // namespace freeplay
