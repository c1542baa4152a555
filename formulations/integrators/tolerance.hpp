// Scales of the accepted errors. L is the length of the mechanism, its longest arm if it has one
// (System::size()), ℓ the smallest clearance (without contacts L), and V the greatest of ℓΩ
// (drives), √(gℓ) (gravity) and 10⁻³ ℓ/s. If neither drives nor gravity set a speed, V is the
// greatest initial speed of a body relative to the bodies that it may contact, or the greatest
// speed that loads and drives give a body of mass m within ℓ: √(F ℓ/m) or, for drives against time
// without mean, their greatest impulse max |∫ F dt|/m. The scales are
//
//     positions ℓ,    angles ℓ/L,    velocities V + |v|,    angular velocities V/L + |ω|.
//
// First-order states of elements have their own scales (System::state_scale).
//
// The lower limit of a contact's v₀ is 10⁻³ V unless the scene gives one: a contact that begins at
// rest has no approach speed for its damping.
#pragma once

#include "formulations/integrators/methods.hpp"

namespace freeplay {

struct Mechanism;
struct State;
class System;

struct Scales {
  double length = 1;         ///< ℓ, m
  double angle = 1;          ///< ℓ/L, rad
  double speed = 1;          ///< V, m/s
  double angular_speed = 1;  ///< V/L, rad/s
  /// m/s, speed of the bodies: V with the arm instead of the clearance, or the initial speed
  double fastest = 1;
  /// s, in which the fastest component changes: 1/Ω of drives, without drives ℓ/V; |ẏ|/|ÿ| of
  /// prescribed motions, from the greatest of each (1/ω of a sine).
  double time = 1;
  /// neither drives nor gravity set a speed: V and time depend on the initial state and loads only
  bool guessed = false;
};

/// Accepted errors of [q, v]; further components of an integrated vector have no error control.
ErrorNorm motion_norm(const System& system, const Scales& scales, double tolerance);

/// Adds the elements' first-order states, from place `offset` of the integrated vector.
void add_states(ErrorNorm& norm, const System& system, int offset);

Scales make_scales(const Mechanism& mechanism, const System& system, const State& start);

/// Greatest speed (m/s) of bodies relative to the bodies that they may contact; rotation counts at
/// the longest arm.
double greatest_speed(const System& system, const double* v);

}  // namespace freeplay
