// MoreauStepper: Moreau–Jean time stepping with θ = ½ (Moreau 1988; Jean, Comput. Methods Appl.
// Mech. Eng. 177 (1999) 235), of second order on smooth stretches. With q_m = q + (h/2) v and
// everything evaluated at (q_m, t + h/2):
//
//     M (v⁺ − v) + GᵀΛ = h f + W P
//     G v⁺ + Φ_t = (h/2) γ                                     step_text.hpp
//     0 ≤ u_N⁺ + e u_N⁻ ⊥ P_N ≥ 0,   −P_T ∈ μ P_N Sgn(u_T⁺)    step_problem.hpp, contact_set.hpp
//     q⁺ = q_m + (h/2) v⁺
//
// Elastic forces of beams are linearly implicit: with the strain rates B v of System::elastic() and its
// stiffness k and damping τ, Bᵀ k (h²/4 + hτ/2) B (v⁺ − v) is added on the left, which is the midpoint rule for
// linear beams. Steps may be longer than the periods of axial waves; energy is then as in the midpoint rule:
// conserved for small deflections, with errors of second order beyond.
//
// The accelerations a_γ in u± are necessary: without them v does not belong to the middle of the
// step, and restitution has an error of hω. With γ_c in their place, contacts with rotating normals
// would have impacts of (1 − e)(h/2)γ_c.
//
// Friction that its joint's reaction bounds uses the impulses of the present step
// (reaction_bounds.hpp). Films of lubricated joints are smooth forces, implicit in the velocities
// (film_step.hpp). First-order states of elements use the same midpoint rule, z⁺ = z + h ż(t + h/2,
// q_m, (z + z⁺)/2). At the end of a step, positions are corrected (position_correction.hpp) and, in
// smooth steps of adaptive time stepping, also velocities (end_rates.hpp).
//
// MoreauStepper owns the data of the step and its parts, and calls the parts in this order; each
// part keeps its own state. step() makes steps of fixed length; AdaptiveMoreau (adaptive.hpp)
// chooses the steps itself and uses advance().
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "formulations/time_stepping/contact_set.hpp"
#include "formulations/time_stepping/end_rates.hpp"
#include "formulations/time_stepping/film_step.hpp"
#include "formulations/time_stepping/position_correction.hpp"
#include "formulations/time_stepping/step_data.hpp"
#include "formulations/time_stepping/step_diagnostics.hpp"
#include "formulations/time_stepping/step_problem.hpp"
#include "formulations/time_stepping/step_results.hpp"
#include "formulations/time_stepping/step_text.hpp"
#include "mechanism/options.hpp"
#include "simulation/formulation.hpp"

namespace freeplay {

/// MeanVelocity: fixed-point iteration for v_mean = (v + v⁺)/2 where v⁺ depends on it. After each
/// solution v⁺, assess() is called; another solution follows while it returns `again`. Coordinates
/// are x, y and the angle of each body; changes of angular rates are multiplied by the body's
/// radius of gyration.
class MeanVelocity {
 public:
  enum class Verdict {
    met,
    again,      ///< v_mean is the next to try
    unsettled,  ///< films: the iteration oscillates; fixed steps continue with the last value
    unswept,    ///< sweeps: the iteration oscillates; the last value is used
    diverged
  };
  /// Dependencies of v⁺ besides dampers, and whether steps are fixed; they decide how long the
  /// iteration continues.
  struct Kind {
    bool sweeps = false, films = false, fixed = false;
  };
  struct Motion {
    double h;                         ///< s
    const double *q_mid, *v_old, *v;  ///< v: the solution at v_mean
    double reach;                     ///< m, the longest arm of the mechanism
    double film_change;               ///< greatest change of a rate by films
  };

  Verdict assess(int iteration, const MidpointTerms& terms, const Motion& motion, Kind kind,
                 std::vector<double>& v_mean);

  std::vector<double> last;  ///< the previous solution
};

class MoreauStepper {
 public:
  /// `step`: fixed step length (s); if 0, only advance() is used. `restitution`: e of each contact.
  /// `facts`: facts of the constraint rows.
  MoreauStepper(const System& system, const NonsmoothOptions& options, double step,
                std::vector<double> restitution, RowFacts facts);

  void start(const State& state, ContactLog& log);
  /// Makes one step of the fixed length, which ends at t_end at the latest.
  bool step(double t_end);
  const std::string& failure() const { return data_.failure; }

  /// @name For adaptive time stepping
  ///@{
  /// Makes one step to t_new.
  bool advance(double t_new, StepReach reach);
  /// All data that a step changes, except the count of work; a rejected step is undone by restoring
  /// them.
  struct Place {
    std::vector<double> q, v, z, slide_last;
    std::vector<StepContact> contacts;
    ContactLog log;
    EnergyLedger integrals;
    Extremes extremes;
    StepDiagnostics found;
    double t = 0, slide_scale = 0;
    long events = 0;
  };
  void keep(Place& place) const;
  void go_back(const Place& place);
  /// Richardson extrapolation of state and energies at the end of two half steps, with the end
  /// `whole` of one full step from the same place.
  void extrapolate(const Place& whole);
  ContactSet& contacts() { return contacts_; }
  const ContactSet& contacts() const { return contacts_; }
  const StepProblem& problem() const { return problem_; }
  const StepData& data() const { return data_; }
  /// Logs the separation of contacts that are no longer closed, as the next step would do.
  void leave_all_open() { record_.leave_all_open(data_, contacts_); }
  RunTotals& totals() { return data_.totals; }
  /// Impulses of the last step without its impacts; with within(), all impulses.
  const Forces& smooth() const { return forces_.smooth(); }
  ///@}

  template <class M>
  void serialize(M& m) {
    m.part("moreau-jean");
    contacts_.serialize(m, data_, responses_);
    auto& d = data_;
    auto& found = d.totals.found;
    m(d.saddle, problem_.slide_last, d.q, d.v, d.q_old, d.v_old, mean_.last, d.z, d.t, d.t_old, t_start_,
      index_, d.totals.integrals, d.totals.extremes, d.totals.work, record_.flights(), resolution_.passage,
      resolution_.curve_deviation, found.motions, found.lockup, found.lockups, found.undecided, found.unswept,
      found.inelastic, found.locked, found.locked_since, found.uncorrected, found.residual,
      problem_.problem.modes_left, correction_.modes_left(), contacts_.slack, films_.thickness_change,
      found.unsettled);
  }

  double t() const { return data_.t; }
  double t_old() const { return data_.t_old; }
  const double* v() const { return data_.v.data(); }
  const double* v_old() const { return data_.v_old.data(); }
  const double* q() const { return data_.q.data(); }
  double fixed_length() const { return step_; }
  std::span<const double> z() const { return data_.z; }
  void hold(std::span<const double> z) { std::ranges::copy(z, data_.z.begin()); }
  void interpolate(double t, double* q, double* v) const;
  /// The impacts of the last step, at the mean of their times weighted by normal impulse.
  StepImpacts in_impact() const { return record_.impacts(data_.t); }
  /// Impulses of the constraint rows over the length of the last step, including its impacts.
  std::span<const double> multipliers() const { return data_.lambda; }

  /// @name Forces; see Step. Forces of a step are its impulses divided by its length.
  ///@{
  void watch_forces(bool on) { forces_.watch(data_.system, on); }
  void forces(double, Forces& out) const { forces_.at(data_.t_old, data_.t, out); }
  void add_impulse(double a, double b, Forces& sum) const {
    if (b > a) sum.add((b - a) / data_.length(), forces_.smooth());
  }
  const Forces& before() const { return forces_.nothing(); }
  const Forces& within() const { return forces_.within(); }
  ///@}
  const EnergyLedger& integrals() const { return data_.totals.integrals; }
  /// J, work of drives and of loads.
  std::array<double, 2> outside_work() const { return {integrals().drive, integrals().load}; }
  const Extremes& extremes() const { return data_.totals.extremes; }
  const Work& work() const { return data_.totals.work; }
  /// Adds notes about this run's steps for the reader of the results.
  void add_notes(std::vector<std::string>& notes) const {
    add_step_notes(data_.totals.found, data_.system, fixed(), films_.thickness_change,
                   resolution_.curve_deviation, notes);
  }
  const StepResolution::Passage& passage() const { return resolution_.passage; }
  bool singular() const { return data_.saddle.singular(); }
  double nearest_singular() const { return data_.saddle.nearest_singular(); }

 private:
  friend class LaneGroup;  // makes ordinary steps of several steppers together
  bool fixed() const { return step_ > 0; }
  MidpointTerms terms() const;
  void stiffen();
  void add_elastic(const double* v_force);
  bool evaluate_middle();
  bool solve_step();
  void advance_positions();
  bool settle_mean_velocity();
  bool advance_states(const double* v_mean);
  bool solve_velocities(const double* v_force);
  bool end_step();
  template <class Self, class P, class Copy>
  static void each_kept(Self& stepper, P& place, Copy copy);

  double step_;     // s, fixed; 0: adaptive, chosen by AdaptiveMoreau
  bool redundant_;  // constraint rows depend on each other from the start
  StepData data_;
  ContactSet contacts_;
  FilmStep films_;
  bool extra_forces_;  // films or elastic rows
  ImpulseResponses responses_;
  StepProblem problem_;
  MeanVelocity mean_;
  PositionCorrection correction_;
  EndRates end_rates_;
  ContactRecord record_;
  StepForces forces_;
  StepResolution resolution_;
  std::vector<double> flow_;  // rates of first-order states
  double t_start_ = 0;
  long index_ = 0;
  bool automatic_solver_;
  double tolerance_;  // of contact problems
};

}  // namespace freeplay
