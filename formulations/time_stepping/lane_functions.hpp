// Compiled functions of steps of the midpoint rule in lanes (numerics/trace.hpp): trajectories of
// mechanisms of one structure, side by side. They make ordinary steps only. In an *ordinary step* at most one
// contact acts. It was closed before the step and stays closed, with a solution in closed form, and no other
// gap is negative at the end. A bit of the result marks each lane whose step is not ordinary; MoreauStepper
// then makes that step. Results are bitwise identical to those of MoreauStepper.
//
// All functions read and write one table of arrays, LaneArray, and change an entry only as said here:
//
//     middle:    from q_old, v_old: what the table below names so, v and λ without contacts, lowest pivot
//                ratios, and `reach`, the gap that each contact would have at the end without impulses
//     contact:   of each contact, where it acts: its impulses, in v, λ, momentum, record and totals
//     end:       q, corrected onto Φ = 0, all λ, mean velocity, gaps, works, totals
//     open:      of each contact, where it opens: moves bodies apart, in q, gaps, record and totals
//
// A joint with friction of a given force takes part in each step, and `contact` includes its impulse. The
// contact and the joint then have the mode of their last impulses: both slide, or the contact has no
// friction. Where no contact acts without impulses:
//
//     slide:     where it is asked for, impulse of the joint friction, in v, λ, momentum and totals, and
//                `slide_reach`, the gap that each contact would have at the end. If one of these is not
//                positive, only this and the residuals change, and `contact` computes the impulse.
//
// `middle` and `end` do not depend on what is between them: StepKernel (step_kernel.hpp) uses those of one
// lane for all steps of one MoreauStepper, also of mechanisms whose steps are never ordinary.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "numerics/saddle_point.hpp"
#include "numerics/trace.hpp"
#include "values/state.hpp"

namespace freeplay {

class System;

/// Arrays of the functions; each has one number for each lane in turn. Entries of contact k of K begin at k
/// times the size of one contact.
enum class LaneArray {
  // of the step
  t_middle,
  t_end,
  h,
  tolerance,    ///< of contact problems
  restitution,  ///< K
  acts,         ///< K: whether a contact acts, 1 or 0
  opens,        ///< K: whether its gap is to be corrected
  slide_asked,
  // before the step: the first ones of the state
  q_old,
  v_old,
  // the state, which steps change
  q,
  v,
  drive,          ///< J
  stabilisation,  ///< J
  gap,            ///< K, m, at the end of the last step
  record,         ///< K × LaneRecord
  totals,         ///< LaneTotal
  slide_impulse,  ///< N s, of the joint friction
  ratios,         ///< least pivot ratios since the lane was loaded
  // the step in progress
  q_middle,
  cosine,
  sine,
  phi_t,
  G,
  gamma,
  factors,
  momentum,  ///< M v₀ + h f and all impulses
  lambda,
  middle_gap,  ///< K
  normal,      ///< K × SparseRow::max_size, entries of the row
  tangent,     ///< likewise
  gamma_n,     ///< K
  gamma_t,     ///< K
  rates,       ///< K × LaneRate
  reach,       ///< K
  slide_row,   ///< SparseRow::max_size
  slide_gamma,
  slide_reach,  ///< K
  q_free,       ///< before the corrections of the end
  v_mean,
  count
};
/// Rates of a contact's rows.
enum LaneRate { rate_n, rate_t, rate_n_old, lane_rate_size };
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

/// The table of arrays, as arguments of the functions.
using LaneTable = std::array<double*, static_cast<std::size_t>(LaneArray::count)>;

/// The functions, and the sizes of their arrays.
struct LaneFunctions {
  int lanes = 0;
  CompiledFunction middle = nullptr, end = nullptr;
  std::vector<CompiledFunction> contacts, opens;  ///< of each contact
  CompiledFunction slide = nullptr;               ///< of the joint friction; null: none
  int factors = 0;
  std::vector<int> ratios;             ///< of each block of the linear system
  std::shared_ptr<const void> object;  ///< keeps compiled functions loaded

  /// Entries of an array, for each lane.
  int size(LaneArray array, const System& system) const;
};

/// Whether no part of a system has its own way of taking part in the beginning or the end of a step.
bool has_whole_steps(const System& system);
/// Whether its steps may also be ordinary: nothing depends on the mean velocity.
bool has_ordinary_steps(const System& system);

/// The traced functions of one System. Systems with the same text share the compiled functions, each
/// lane with its own constants.
struct TracedLanes {
  TracedObject object{0};
  TracedObject place;  ///< the function that places the sample
  bool traced = false;
  int contacts = 0;
  int factors = 0;
  std::vector<int> ratios;
  LaneFunctions compiled(const CompiledFunction* table) const;
};

/// Appends the functions of one lane to those of a System: `middle` and `end`, and the others if its steps
/// may be ordinary. Returns their number, 0 if there are none. The object must have the functions of the
/// linear system.
int trace_steps(TracedObject& object, const System& system, const State& near, RowFacts facts);
/// These functions once they are attached to the System; `lanes` is 0 without the others.
LaneFunctions single_lane(const System& system);

/// Traces a System near a state; `traced` is false if it has no such functions. `like`: as for
/// trace_system().
TracedLanes trace_lanes(const System& system, const State& near, RowFacts facts, int lanes,
                        const TracedLanes* like = nullptr);

/// Number of lanes that fill a vector register of this machine.
int lanes_of_machine();

}  // namespace freeplay
