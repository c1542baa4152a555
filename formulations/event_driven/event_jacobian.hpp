// Work space of the derivatives of a mode's right-hand side (event_jacobian.cpp).
#pragma once

#include <tuple>
#include <vector>

#include "formulations/event_driven/event_dynamics.hpp"

namespace freeplay {

/// Directions of one evaluation with Gradient.
inline constexpr int tangent_directions = static_cast<int>(std::tuple_size_v<decltype(Gradient::slope)>);

/// Derivatives along one direction with accelerations, multipliers and contact forces held.
struct EventDynamics::Slopes {
  Vector force;     ///< f − Gᵀλ − M a + Σ E_r s_r
  Vector side;      ///< γ − G a
  Vector rows;      ///< γ_r − W_r a
  Vector flow;      ///< ż
  Vector friction;  ///< λ_T of sliding contacts
  double drive = 0, load = 0, damping = 0, friction_power = 0, film_power = 0;
};

struct EventDynamics::Tangent {
  EvaluationOf<Gradient> e;
  ContactRowOf<Gradient> row;
  SparseRowOf<Gradient> slide;
  std::vector<Gradient> state, reaction, flow, sigma;  // sigma: γ_r − W_r a
  std::vector<Gradient> r;
  Vector slope, acceleration, active, a, lambda;
  Slopes slopes;
};

}  // namespace freeplay
