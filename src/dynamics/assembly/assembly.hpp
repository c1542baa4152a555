// A consistent start. Positions: the least mass-weighted movement from the rough ones,
//
//     min ½ (q − q₀)ᵀ M (q − q₀)   subject to   Φ(q, 0) = 0   and   |e_k| ≤ c_k for every loose joint,
//
// a nonlinear program for Ipopt (Wächter and Biegler, Math. Program. 106 (2006) 25), finished by Newton steps
// to rounding. Velocities: the least mass-weighted change subject to G v + Φ_t = 0, one linear saddle-point
// system.
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

/// Throws ModelError that names the joint which stays open in the best pose found (closure.hpp) and by how much. A start that may be made consistent
/// ("assembled") and gives no body a velocity, though a drive turns, takes the velocities of the ideal mechanism at its
/// nearest position: the least change from standing still would leave loose parts at rest and a kick at the first
/// touch. `assumed` is then told so in one line, else left empty. Where the positions given lead to no closed pose, or to another
/// than mechanism.assembly asks for, other starts are tried (other_starts.hpp) and `assumed` is told which one led there. Throws
/// Interrupted when `stop` asks.
/// "equilibrium" descends from the assembled place (equilibrium.hpp) with rigid contacts, and says in `assumed` what it
/// came to; what a drive turns then moves, all else rests.
State assemble(const Mechanism& mechanism, RunOptions::Start start, std::string* assumed = nullptr,
               const StopToken& stop = {});
/// The same with contacts that yield as `elastic` says.
State assemble(const Mechanism& mechanism, RunOptions::Start start, std::string* assumed,
               const StopToken& stop, const Compliances& elastic);

/// Gives the bodies the places and rates of a state to start from.
void start_from(Mechanism& mechanism, const State& state);

/// The worst single row. Contacts that overlap by up to allowed_penetration of ContactFacts::measure() do not count.
OpenJoint worst_open_joint(const System& system, const std::vector<double>& q,
                           double allowed_penetration = 0);

/// Indices of constraint rows that depend on others at q; empty when none do.
std::vector<int> redundant_rows(const System& system, const std::vector<double>& q);

}  // namespace freeplay
