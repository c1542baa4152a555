// Variation: derivatives of an event-driven motion with respect to parameters p and to the initial
// state. With x the integrated vector, S = dx/dp has one column per parameter.
//
//     in a mode:     Ṡ = f_x S + f_p
//     at an event    h(x, t; p) = 0:     dt = −(h_x S⁻ + h_p)/ḣ⁻
//                    x⁺ = J(x⁻, t; p):   S⁺ = J_x (S⁻ + f⁻ dt) + J_t dt + J_p − f⁺ dt
//
// f⁻ and f⁺ are the right-hand sides before and after the event (saltation: Leine and Nijmeijer,
// Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, section 7). J is the projection
// onto the mode before, followed by the impact of the same contacts.
//
// f_x S is exact to rounding (event_jacobian.cpp). Ṡ is integrated by the stages of Dormand and Prince
// that the motion itself takes, so that S is the derivative of the computed motion at fixed step
// lengths. Derivatives with respect to p at a fixed state, and those of h and J, are differences of
// fourth order of closed forms at a fixed mode (differences.hpp). For this, each parameter has four
// systems with displaced values, and closer ones where a kink is within the first. No trajectory is
// differenced.
//
// A column ends where there is no derivative, with a reason (refuse()). A stepper owns a Variation only
// if derivatives are requested; it reads the stepper's data and changes no digit of the motion.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "formulations/event_driven/differences.hpp"
#include "formulations/event_driven/event_dynamics.hpp"
#include "formulations/event_driven/event_impacts.hpp"
#include "formulations/sensitivity.hpp"

namespace freeplay {

/// Value of a column of trajectory.csv or forces.csv at a state in the present mode.
double observed(const Column& column, EventDynamics& f, const std::vector<double>& x, double t);

class Variation {
 public:
  using Vector = std::vector<double>;
  /// A function of the state, evaluated with the dynamics of the nominal or of a displaced system.
  using Function = std::function<Vector(EventDynamics&, const Vector& x, double t)>;

  /// Contact onset: value and derivatives of time, approach rate and normal impulse.
  struct Onset {
    int contact = 0;
    bool lasting = false;
    double t = 0, rate = 0, impulse = 0;
    Vector dt, drate, dimpulse;  ///< one for each key; NaN where there is none
    std::vector<std::string> reasons;
  };
  /// An event as the stepper processed it.
  struct Passed {
    ModeEvent event;
    double t = 0;
    const Vector& before;               ///< x⁻, before the projection
    const Vector& after;                ///< x⁺
    const std::vector<int>& in_impact;  ///< contacts of the impact; empty without one
    const std::vector<int>& ended;      ///< those whose accumulation of bounces ends here
    const EventImpacts& impacts;
  };

  /// `integrands`: columns whose means are needed; `length` (m) and `duration` (s): scales over which
  /// functions of the state and of time are curved.
  Variation(const EventDynamics& dynamics, std::vector<VariedKey> keys, std::vector<Column> integrands,
            double length, double duration);

  /// Advances S over a step of constant mode.
  void advance(const EventDynamics& dynamics, double t_old, const Vector& x_old, double t);
  /// Keeps the mode before an event.
  void begin_event(const EventDynamics& dynamics);
  void pass(const EventDynamics& dynamics, const Passed& passed);
  /// From now on all columns have no derivative, for this reason.
  void refuse(const std::string& reason);

  const std::vector<Onset>& onsets() const { return onsets_; }
  const std::vector<VariedKey>& keys() const { return keys_; }
  /// Reason why column c has no derivative; empty if it has one.
  const std::string& reason(std::size_t c) const { return reasons_[c]; }
  /// Value and derivatives of a function at the end of the run, at x and t in the present mode.
  Vector end_derivatives(const EventDynamics& dynamics, const Vector& x, double t, const Function& value,
                         double& now, std::vector<std::string>& reasons);
  /// dx/dp of all columns at the end of the run, at x and t in the present mode. A column without a
  /// derivative is zero.
  std::vector<Vector> end_columns(const EventDynamics& dynamics, const Vector& x, double t);
  /// Sum of the energies lost in contacts, which x does not contain.
  const Vector& contact_loss() const { return loss_; }
  /// Mean of the i-th integrand from `begin` to `end` (s), and its derivatives at the end of the run. The
  /// mean of a force includes the impulses of impacts.
  double mean(std::size_t i, double begin, double end) const { return integrals_[i] / (end - begin); }
  Vector mean_derivatives(std::size_t i, const EventDynamics& dynamics, const Vector& x, double begin,
                          double end);
  long evaluations() const { return evaluations_; }

 private:
  /// The dynamics at displaced values of a key; closer ones follow where they were needed.
  struct Displaced {
    double spacing = 0;
    std::array<std::unique_ptr<EventDynamics>, 4> dynamics;
  };
  /// Right-hand side and integrands on one side of an event.
  struct Side {
    Vector f, integrands;
  };
  Side side(EventDynamics& f, const Vector& x, double t) const;
  Function jump_of(const std::vector<int>& in_impact, const std::vector<int>& ended) const;
  Function integrands() const;
  void integrate(double weight, const Vector& x, double t);
  void take_mode(const EventDynamics& dynamics);
  bool displace_closer(std::size_t c);
  bool open(std::size_t c) const { return reasons_[c].empty(); }
  void refuse(std::size_t c, const std::string& reason);
  double spacing(const EventDynamics& f, const Vector& dx, double dt, double speed) const;
  double within_rates(double h, EventDynamics& f, const Vector& x, double t, const Vector& dx, double dt);
  Difference along(EventDynamics& f, const Function& value, const Vector& centre, const Vector& x, double t,
                   const Vector& dx, double dt, double speed);
  Difference across(std::size_t c, const Function& value, const Vector& centre, const Vector& x, double t);
  Vector total(std::size_t c, const Function& value, const Vector& x, double t, const Vector& dx, double dt,
               double speed, bool may_have_kinks = true);
  void parameter_part(std::size_t c, const Vector& x, double t, const Vector& f, Vector& out);
  Vector event_times(const Passed& p, const ModeEvent& event, const Vector& slope, double speed);
  void jump(const Passed& p, const std::vector<int>& in_impact, const Vector& x, const Side& before,
            const Side& after, const Vector& dt, double speed);
  void pass_impacts(const EventDynamics& d, const Passed& p, const std::vector<int>& onsets,
                    const Side& before, const Side& after);
  void keep_start(const EventDynamics& d, const Passed& p);
  bool coupled(const Passed& p, const std::vector<int>& onsets, const std::vector<int>& closed);

  std::vector<VariedKey> keys_;
  std::unique_ptr<EventDynamics> probe_, after_;  // of the nominal system; after_: in the mode after an event
  std::vector<std::vector<Displaced>> displaced_;  // empty for initial values
  std::vector<Vector> S_;                          // columns, of the integrated vector
  std::vector<std::string> reasons_;
  Vector loss_;  // d(energy lost in contacts)/dp
  std::vector<Onset> onsets_;
  std::vector<int> approaching_;  // contacts of the impact whose derivatives are formed
  std::vector<Column> integrands_;
  Vector integrals_;                    // ∫ of the integrands
  std::vector<Vector> integral_rates_;  // their derivatives, one list for each column
  double length_, duration_;
  bool mode_known_ = false;
  std::size_t size_;
  long evaluations_ = 0;
  // of advance()
  Vector stage_, part_;
  std::array<Vector, 6> f_;
  std::array<std::vector<Vector>, 6> slopes_;
  std::vector<Vector> seeds_;
};

}  // namespace freeplay
