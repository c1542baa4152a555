// Initial values of bodies that random starts vary. A value x becomes x + d, with d uniform in
// [−h, h). Other coordinates change by the least mass-weighted amount that keeps the joints, drives
// and contacts closed:
//
//     min ½ (q − q₀)ᵀ M (q − q₀)   subject to   Φ(q) = 0,   g(q) ≥ 0,   q_c = x + d,
//
// and likewise the velocities, subject to G v + Φ_t = 0 (src/dynamics/assembly/assembly.hpp).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "values/stop.hpp"

namespace freeplay {

struct Mechanism;
struct State;

/// An initial value and its range.
struct InitialValue {
  std::string key;             ///< bodies.NAME.angle, bodies.NAME.velocity[1]
  const char* unit = "";       ///< m, rad, m/s or rad/s
  std::size_t coordinate = 0;  ///< index into q, or into v of a rate
  bool rate = false;
  double half = 0;  ///< h > 0, in the unit
};

/// Reads texts KEY=H, where H is a number in SI or has a unit. Throws SceneError for another key than
/// that of a position, angle or velocity of a body of the mechanism, and for a repeated one.
std::vector<InitialValue> initial_values(const Mechanism& mechanism, const std::vector<std::string>& texts);

/// Changes the values by these amounts, and the other coordinates such that `mechanism` stays
/// closed. Throws SceneError, with the joint, drive or contact, if it prevents the change.
void displace(const Mechanism& mechanism, const std::vector<InitialValue>& values,
              const std::vector<double>& by, State& state, const StopToken& stop);

}  // namespace freeplay
