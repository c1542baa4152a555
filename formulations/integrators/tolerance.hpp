// The scales that errors are measured by. With ℓ the smallest clearance (without contacts the longest arm), L
// the longest arm, and V the greatest of ℓΩ (drives), √(gℓ) (gravity) and 10⁻³ ℓ/s; where neither drives nor gravity set
// a pace, the greatest of a body at the start against what it may touch and of what loads and drives give a body of mass m
// within ℓ, √(F ℓ/m), or by their greatest impulse, max |∫ F dt|/m, where they act against time without mean:
//
//     positions ℓ,    angles ℓ/L,    velocities V + |v|,    angular velocities V/L + |ω|.
//
// First-order states of elements have scales of their own (System::state_scale).
//
// The floor of a contact's v₀ is 10⁻³ V unless the scene gives one: a contact that begins at rest has no
// approach speed to scale its damping with.
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
  double fastest = 1;  ///< m/s, that bodies move with: V by the arm instead of the clearance, or of the start
  /// s, in which the fastest component changes: 1/Ω of drives, without one ℓ/V; |ẏ|/|ÿ| of prescribed motions, by the
  /// greatest of each (1/ω of a sine).
  double time = 1;
  bool guessed = false;  ///< neither drives nor gravity set a pace: V and time are of the start alone
};

/// Accepted errors of [q, v]; what follows in an integrated vector is carried along without control.
ErrorNorm motion_norm(const System& system, const Scales& scales, double tolerance);

/// Adds the elements' first-order states, from place `offset` of the integrated vector.
void add_states(ErrorNorm& norm, const System& system, int offset);

Scales make_scales(const Mechanism& mechanism, const System& system, const State& start);

/// Of bodies against what they may touch (m/s), their turning at the longest arm.
double greatest_speed(const System& system, const double* v);

}  // namespace freeplay
