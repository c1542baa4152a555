#include "study/settings/continuation_plan.hpp"

#include <fmt/format.h>

#include "io/scene/schema.hpp"
#include "io/scene/section.hpp"
#include "study/settings/study_parts.hpp"

namespace freeplay {
namespace {

constexpr Range doublings{
    [](double x) { return x >= 0 && x <= 10 && x == static_cast<double>(static_cast<int>(x)); },
    "a whole number from 0 to 10"};

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
  if (s.has("step")) p.step = s.number(Key{"step", unit_of(p.key), {}}, positive);
  if (s.has("set")) p.overrides = s.names("set");
  for (const auto& set : p.overrides)
    if (set.substr(0, set.find_first_of(" =")) == p.key)
      s.fail("set", fmt::format("{} is varied by the continuation", p.key));
  p.periods = static_cast<int>(s.number("periods", study_count, p.periods));
  p.settle = s.number("settle", non_negative, p.settle);
  p.period = s.maybe_number("period", positive);
  p.follow_doubled = static_cast<int>(s.number("follow_doubled", doublings, p.follow_doubled));
  p.most_points = static_cast<int>(s.number("most_points", study_count, p.most_points));
  p.scale = s.number("scale", positive, p.scale);
  p.unit = s.text("unit", p.unit);
  s.done("[continue]");
  return p;
}

}  // namespace freeplay
