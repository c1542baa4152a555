#include "study/runs/initial_value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/closing.hpp"
#include "dynamics/assembly/stated.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "io/files/escaping.hpp"
#include "io/scene/points_file.hpp"
#include "io/scene/quantity.hpp"
#include "io/scene/spelling.hpp"
#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

/// A key of a body, with its place among the body's coordinates or rates.
struct BodyKey {
  const char *name, *unit;
  std::size_t place;
  bool rate;
};
constexpr BodyKey body_keys[] = {{"position[0]", "m", 0, false},  {"position[1]", "m", 1, false},
                                 {"angle", "rad", 2, false},      {"velocity[0]", "m/s", 0, true},
                                 {"velocity[1]", "m/s", 1, true}, {"angular_velocity", "rad/s", 2, true}};

[[noreturn]] void refuse(const std::string& key, const std::string& why) {
  throw SceneError(fmt::format("--vary {}: {}", visible_brief(key), why));
}

/// Half the range, from its text.
double half_of(const std::string& key, const std::string& text, const char* unit) {
  const auto plain = number_in(text);
  const auto read = plain ? Quantity{*plain} : read_quantity(text, unit);
  if (!read.wrong.empty()) refuse(key, read.wrong);
  if (!(read.value > 0) || !std::isfinite(read.value))
    refuse(key, fmt::format("must be a positive number in {}, half the range", unit));
  return read.value;
}

[[noreturn]] void refuse_change(const Mechanism& mechanism, const std::vector<InitialValue>& values,
                                const OpenJoint& open, bool rate) {
  for (const auto& value : values)
    if (value.rate == rate)
      refuse(
          value.key,
          fmt::format("cannot be varied by {:.4g} {}, since {} {} by {:.4g} {}{}; vary a smaller range, or "
                      "a value that no joint or drive determines",
                      value.half, value.unit, key_of(mechanism, open),
                      open.overlap ? "then overlaps" : "is then violated", open.amount,
                      open.angular ? "rad" : "m", rate ? "/s" : ""));
  throw SceneError("--vary: there is no value");
}

InitialValue initial_value(const Mechanism& mechanism, const std::string& text) {
  const auto equals = text.rfind('=');
  if (equals == text.npos) refuse(text, "must be KEY=RANGE, such as bodies.wheel.angle=0.01");
  const auto key = text.substr(0, equals);
  if (!mechanism.beams.empty())
    refuse(key, "a mechanism with beams cannot vary initial values, since the beams would begin strained");
  std::vector<std::string> keys;
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b)
    for (const auto& of : body_keys) {
      if (mechanism.bodies[b].point && of.place == 2) continue;
      keys.push_back(fmt::format("bodies.{}.{}", mechanism.bodies[b].name, of.name));
      if (keys.back() == key)
        return {key, of.unit, planar::first(b) + of.place, of.rate,
                half_of(key, text.substr(equals + 1), of.unit)};
    }
  refuse(key, "is no initial value of a body" + meant(key, keys, "there is:"));
}

}  // namespace

std::vector<InitialValue> initial_values(const Mechanism& mechanism, const std::vector<std::string>& texts) {
  std::vector<InitialValue> list;
  for (const auto& text : texts) {
    auto value = initial_value(mechanism, text);
    if (std::ranges::find(list, value.key, &InitialValue::key) != list.end())
      refuse(value.key, "is given twice; give one range");
    list.push_back(std::move(value));
  }
  return list;
}

void displace(const Mechanism& mechanism, const std::vector<InitialValue>& values,
              const std::vector<double>& by, State& state, const StopToken& stop) {
  const System system(mechanism);
  std::vector<char> positions(state.q.size()), rates(state.v.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto c = values[i].coordinate;
    (values[i].rate ? state.v : state.q)[c] += by[i];
    (values[i].rate ? rates : positions)[c] = true;
  }
  if (any(positions)) {
    const Closing closing(mechanism, system, stop, {system.mass(), positions});
    auto best = state.q;
    if (!(closing.open(state.q) <= closing.accepted()) &&
        (std::ranges::count(positions, 0) == 0 || !closing.close(state.q, best)))
      refuse_change(mechanism, values, worst_open_joint(system, best), false);
  }
  const auto wanted = state.v;
  const auto violated = assemble_velocities(mechanism, system, rates, state);
  const double length = length_scale(system), speed = speed_scale(mechanism, wanted, length);
  for (std::size_t c = 0; c < rates.size(); ++c)
    if (rates[c] && std::abs(state.v[c] - wanted[c]) * (system.is_angle(static_cast<int>(c)) ? length : 1) >
                        silent_change * speed)
      refuse_change(mechanism, values, violated, true);
}

}  // namespace freeplay
