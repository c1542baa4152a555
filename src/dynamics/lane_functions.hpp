// Compiled functions of steps of the midpoint rule in lanes (numerics/trace.hpp): trajectories of
// mechanisms of one structure, side by side. They do ordinary steps only: at most one contact acts,
// and it was closed before the step and stays closed, with a solution in closed form; no gap is
// negative at the end, except that of this contact. A bit of the result marks each lane whose step is another
// one; the single path (formulations/time_stepping/) then makes that step. All digits are those of the single
// path.
//
// The functions are those of StepFunctions (system_functions.hpp) with these differences. Below, K is
// the number of contacts, and records and totals are as in the enumerations.
//
//     middle:    in also lowest pivot ratios so far
//                out no pivot ratios and no second G; also, after the contacts, the gap that each contact
//                would have at the end without impulses, and the lowest ratios
//     contact:   response, solution and push of a contact in one,
//                in h, F, G, the contact's normal and tangent row, rates, γ_n and γ_t of all contacts,
//                gaps, normal rows of all contacts, v, λ, h f, v₀, whether it acts (1 or 0), its
//                coefficient of restitution and the tolerance, its record, totals
//                out v, λ, h f, record, totals; all unchanged where it does not act
//     end:       in also totals
//                out no λ/h, mean velocity, residuals and sum; also totals, after the gaps
//     open:      moves bodies apart where the gap of a contact is negative at the end,
//                in t, q_m, cosine, sine, F, G, normal row, q, gaps, whether it is to be opened (1 or 0),
//                totals, record, facts as above
//                out q, gaps, totals, record; all unchanged elsewhere
//
// A joint with friction of a given force takes part in each step: middle has its row and γ as further
// outputs, and contact its row, γ and last impulse as further inputs, and its impulse as output. The contact
// and the joint then have the mode of their last impulses: both slide, or the contact has no friction. Where
// no contact acts without impulses:
//
//     slide:     impulse of the joint friction,
//                in h, F, G, its row, γ and last impulse, (6:) γ_n, gaps, normal rows of all contacts,
//                (10:) v, λ, h f, v₀, whether it is asked for (1 or 0), tolerance, totals
//                out v, λ, h f, totals, impulse; also the gap that each contact would have at the end
//
// If one of these gaps is not positive, v, λ, h f, the work and the impulse are unchanged, and the impulse is
// computed with the contact. All is unchanged where it is not asked for.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "numerics/lane_tape.hpp"
#include "numerics/saddle_point.hpp"
#include "numerics/trace.hpp"
#include "values/state.hpp"

namespace freeplay {

class System;

/// Quantities of a contact that the steps in lanes change.
enum LaneRecord {
  lane_impulse_n,
  lane_impulse_t,
  lane_last_n,
  lane_last_t,
  lane_u_n_minus,
  lane_u_n_plus,
  lane_u_t_plus,
  lane_bias_n,
  lane_bias_t,
  lane_penetration,
  lane_record_size
};
/// Totals of a run that the steps in lanes change.
enum LaneTotal {
  lane_contact_loss,
  lane_friction_loss,
  lane_lcp_residual,
  lane_lcp_residual_rate,
  lane_constraint_length,
  lane_constraint_angle,
  lane_passed,
  lane_total_size
};

/// A compiled function, or a tape (numerics/lane_tape.hpp), which one thread may use. Both give the same.
class LaneFunction {
 public:
  LaneFunction() = default;
  explicit LaneFunction(CompiledFunction compiled) : compiled_(compiled) {}
  explicit LaneFunction(std::shared_ptr<LaneTape> tape) : tape_(std::move(tape)) {}
  /// Returns a bit for each lane in which a guard failed.
  unsigned operator()(const double* constants, const double* const* in, double* const* out) const {
    return static_cast<unsigned>(compiled_ ? compiled_(constants, in, out) : (*tape_)(constants, in, out));
  }

 private:
  CompiledFunction compiled_ = nullptr;
  std::shared_ptr<LaneTape> tape_;
};

/// The functions, and the sizes of their arrays.
struct LaneFunctions {
  int lanes = 0;
  LaneFunction middle, end;
  std::vector<LaneFunction> contacts, opens;  ///< of each contact
  std::vector<LaneFunction> slides;           ///< of the joint friction, or none
  int factors = 0;
  std::vector<int> ratios;             ///< of each block of the linear system
  std::shared_ptr<const void> object;  ///< keeps compiled functions loaded
};

/// The traced functions of one System. Systems with the same text share the compiled functions, each
/// lane with its own constants.
struct TracedLanes {
  TracedObject object{0};
  TracedObject place;  ///< the function that places the sample
  bool traced = false;
  int factors = 0;
  std::vector<int> ratios;
  LaneFunctions compiled(const CompiledFunction* table) const;
  /// The functions without a compiler, if LaneTape::usable(). Their lanes may be others than those of
  /// `object`.
  LaneFunctions evaluated(int lanes) const;

 private:
  LaneFunctions functions(std::vector<LaneFunction> list) const;
};

/// Traces a System near a state; `traced` is false if it has no such functions. `like`: as for
/// trace_system().
TracedLanes trace_lanes(const System& system, const State& near, RowFacts facts, int lanes,
                        const TracedLanes* like = nullptr);

/// Number of lanes that fill a vector register of this machine.
int lanes_of_machine();

}  // namespace freeplay
