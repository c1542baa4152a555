// Consistent initial states. Stated positions and velocities are kept (stated.hpp); absent positions
// are those of least mass-weighted distance from a first pose q₀,
//
//     min ½ (q − q₀)ᵀ M (q − q₀)
//     subject to   Φ(q, 0) = 0   and   |e_k| ≤ c_k for every joint with clearance.
//
// Newton's method solves this nonlinear program near closure (closing.hpp), otherwise Ipopt
// (Wächter and Biegler, Math. Program. 106 (2006) 25); Newton steps reduce the residual to
// rounding. Absent velocities are the least in the metric of M subject to G v + Φ_t = 0, a linear
// saddle-point system (stated.hpp).
#pragma once

#include <string>
#include <vector>

#include "dynamics/assembly/closure.hpp"
#include "dynamics/assembly/compliance.hpp"
#include "mechanism/options.hpp"
#include "values/state.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Mechanism;
class System;

/// Computes a consistent start. `assumed` receives one line for each assumption below and for
/// changes of stated values, else it is empty. Throws ModelError, which names the joint that stays
/// open in the best pose found (closure.hpp) and its gap, or stated values that contradict a joint,
/// and Interrupted if `stop` requests it.
///
/// If the start is "assembled" and no body states a velocity although a drive moves, the velocities
/// are those of the ideal mechanism at its nearest position. The least velocities would
/// instead leave parts with clearance at rest and cause large impacts at their first contacts.
///
/// If the first pose leads to no closed pose, or to another one than mechanism.assembly
/// requests, other starts are tried (other_starts.hpp).
///
/// "equilibrium" descends from the assembled pose (equilibrium.hpp) with rigid contacts and reports
/// its result in `assumed`, then with contacts whose elastic force is `elastic`. Driven parts then
/// move, all others rest.
State assemble(const Mechanism& mechanism, RunOptions::Start start, std::string* assumed = nullptr,
               const StopToken& stop = {}, const Compliances& elastic = {});

/// Sets the bodies' initial positions and velocities to those of a state.
void start_from(Mechanism& mechanism, const State& state);

/// The row with the greatest violation, or the contact with the greatest overlap. Overlaps of up to
/// allowed_penetration times ContactFacts::measure() do not count.
OpenJoint worst_open_joint(const System& system, const std::vector<double>& q,
                           double allowed_penetration = 0);

/// Indices of constraint rows that depend on other rows at q.
std::vector<int> redundant_rows(const System& system, const std::vector<double>& q);

}  // namespace freeplay
