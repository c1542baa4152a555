// StepProblem: the impulses of a step. It sets up the contact problem (contact/contact_problem.hpp)
// of the contacts that take part and of the joints with friction, solves it, and adds the impulses
// to velocities and reactions,
//
//     0 ≤ u_N⁺ + e u_N⁻ ⊥ P_N ≥ 0,   −P_T ∈ μ P_N Sgn(u_T⁺)
//
// μ may depend on the sliding speed (sliding_friction.hpp).
// Contacts are added as long as the motion with the impulses so far would close further gaps. With
// few contacts the problem is dense. With many contacts it is solved in islands, and reactions are
// computed once from all impulses.
//
// solve() starts from a free motion in StepData::v and lambda. Afterwards, `problem` holds the
// impulses until the next step; the reason of a failure is in StepData::failure.
#pragma once

#include <memory>
#include <vector>

#include "formulations/contact/contact_islands.hpp"
#include "formulations/contact/contact_problem.hpp"
#include "formulations/time_stepping/contact_set.hpp"
#include "formulations/time_stepping/film_step.hpp"
#include "formulations/time_stepping/reaction_bounds.hpp"
#include "formulations/time_stepping/sliding_friction.hpp"

namespace freeplay {

class StepProblem {
 public:
  /// `rows`: number of rows of all numbered contacts and friction elements.
  StepProblem(const StepData& step, const NonsmoothOptions& options, int rows, bool many, bool films);

  /// Called at the middle of a step. The saddle point must stay at its address until the next
  /// begin().
  void begin(StepData& step);
  /// Adds the impulses to v and lambda.
  bool solve(StepData& step, ContactSet& contacts, ImpulseResponses& responses, FilmStep& films);
  /// Whether multipliers of eliminated rows are computed once, from the velocities after all
  /// impulses. Not if they are needed while impulses are computed, nor if islands compute them.
  bool late_multipliers() const { return late_multipliers_; }
  bool bounded_by_reactions() const { return bounds_.reads_reactions(); }
  bool driven(int friction) const { return bounds_.driven(friction); }

  /// @name Of the present problem
  ///@{
  double rate(int row) const { return islands_ ? islands_->rate(row) : problem.rate(row); }
  double D(int r, int s) const { return islands_ ? islands_->D(r, s) : problem.D(r, s); }
  /// Place of a row in ImpulseResponses.
  int place(int row) const { return islands_ ? place_[row] : row; }
  ContactUnknown* unknown_of(const StepContact& c) {
    return c.unknown >= 0 ? &problem.unknowns[c.unknown] : nullptr;
  }
  const ContactUnknown* unknown_of(const StepContact& c) const {
    return c.unknown >= 0 ? &problem.unknowns[c.unknown] : nullptr;
  }
  ContactUnknown& friction(int k) { return problem.unknowns[problem.unknowns.size() - slides.size() + k]; }
  const ContactUnknown& friction(int k) const {
    return problem.unknowns[problem.unknowns.size() - slides.size() + k];
  }
  ///@}
  /// Solves with the laws of contact and friction; without restitution if Newton's law requires
  /// rates that no impulse gives.
  ContactSolution solve_laws(StepData& step);

  ContactProblem problem;
  std::vector<SparseRow> slides;    ///< of joints with friction, at the middle of the step
  std::vector<double> slide_gamma;  ///< their γ
  std::vector<double> slide_last;   ///< N s, their impulses in the last step
  double slide_scale() const { return bounds_.slide_scale; }
  void set_slide_scale(double scale) { bounds_.slide_scale = scale; }

 private:
  int add_row(const SparseRow& row, const StepData& step, double end_rate_bias, int place,
              ImpulseResponses& responses);
  void collect(StepData& step, ContactSet& contacts, ImpulseResponses& responses, bool first);
  bool solve_contacts(StepData& step, ContactSet& contacts, ImpulseResponses& responses, FilmStep& films);
  ContactSolution solve_present(StepData& step, ImpulseResponses& responses);
  ContactSolution solve_islands(StepData& step, ImpulseResponses& responses);
  void react_to_all(StepData& step, const ImpulseResponses& responses) const;
  bool strip_restitution();
  void note_painleve(StepData& step, const ContactSet& contacts, const ContactSolution& result) const;

  std::unique_ptr<ContactIslands> islands_;  // with many contacts
  std::vector<int> place_, id_;              // with islands: of each row and of each unknown
  ReactionBounds bounds_;
  SlidingFriction sliding_;
  std::vector<double> v_free_, lambda_free_;
  bool late_multipliers_;
};

}  // namespace freeplay
