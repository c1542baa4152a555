// AdaptiveMoreau: Moreau–Jean time stepping with adaptive steps, chosen by an error estimate.
// (Studer, Leine and Glocker, Int. J. Numer. Meth. Engng 76 (2008) 1747, extrapolate smooth
// stretches and shorten the steps that contain a switching; the method here differs.)
//
// *Smooth steps.* Closed contacts take part, without restitution; open contacts do not. A pair of
// steps is taken, its error is estimated, and the result is extrapolated (step_pair.hpp). Steps
// have a lower limit, the floor (step_pace.hpp).
//
// *Impacts.* The first contact onset on the path is located (onset_search.hpp), and the step is
// repeated to end there. A short step over the impact follows, by the impact law and with all
// contacts. Its length is tolerance × ℓ over the approach speed, so that the time of the impact
// within it changes no position by more than tolerance × ℓ. The step's contact problem thus
// resolves any number of simultaneous impacts together with resting contacts.
//
// *Accumulation of impacts.* A bounce that is lower than tolerance × clearance or shorter than two
// floors ends the accumulation: its contact is closed.
//
// It owns the MoreauStepper and the parts that choose its steps.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>

#include "formulations/automatic/handover.hpp"
#include "formulations/event_driven/event_dynamics.hpp"
#include "formulations/integrators/methods.hpp"
#include "formulations/integrators/peak_limit.hpp"
#include "formulations/integrators/tolerance.hpp"
#include "formulations/time_stepping/moreau.hpp"
#include "formulations/time_stepping/onset_search.hpp"
#include "formulations/time_stepping/step_pace.hpp"
#include "formulations/time_stepping/step_pair.hpp"

namespace freeplay {

class AdaptiveMoreau {
 public:
  /// `moreau` has no fixed step; `norm`: accepted errors of [q, v]; `equations`: makes the equations of
  /// a mode, which give the forces of smooth steps to observers.
  AdaptiveMoreau(const System& system, MoreauStepper moreau, const ErrorNorm& norm, const Scales& scales,
                 std::function<std::unique_ptr<EventDynamics>()> equations);

  void start(const State& state, ContactLog& log);
  /// Continues from the state of another scheme, and returns the state to it.
  void take_over(const Handover& from, ContactLog& log);
  Handover hand_over();
  /// Makes one accepted step, which ends at t_end at the latest.
  bool step(double t_end);
  const std::string& failure() const { return failure_; }

  template <class M>
  void serialize(M& m) {
    m.part("controlled");
    auto& f = found_;
    m(moreau_, pair_.start.t, pair_.start.q, pair_.start.v, pair_.middle_q, pair_.middle_v, pair_.middle_t,
      h_, pace_.floor, pace_.least_floor, pace_.fastest, pace_.pace, impacting_, smooth_step_, f.unseen,
      steps_, pace_.steps, pace_.since, calm_since_, f.floored, f.most_floored, f.longest_floor, f.ended,
      f.ended_time, pair_.smooth, pair_.within, pace_.film_pace, pace_.calm_speed, pace_.gains,
      pace_.calm_gains, pace_.impacts_now);
  }

  double t() const { return moreau_.t(); }
  double t_old() const { return pair_.start.t; }
  const double* v() const { return moreau_.v(); }
  const double* v_old() const { return pair_.start.v.data(); }
  const double* q() const { return moreau_.q(); }
  void interpolate(double t, double* q, double* v) const;
  /// Smooth steps have no impacts.
  StepImpacts in_impact() const { return smooth_step_ ? StepImpacts{t(), {}} : moreau_.in_impact(); }
  std::span<const double> z() const { return moreau_.z(); }
  void hold(std::span<const double> z) { moreau_.hold(z); }
  std::span<const double> multipliers() const { return moreau_.multipliers(); }

  /// @name Forces: of smooth steps those of their modes at the states of the path; of steps over
  /// impacts, and where a mode has no solution, impulses of a step divided by its length
  ///@{
  void watch_forces(bool on);
  void forces(double t, Forces& out);
  void add_impulse(double a, double b, Forces& sum);
  const Forces& before() const { return moreau_.before(); }
  const Forces& within() const { return pair_.within; }
  ///@}
  const EnergyLedger& integrals() const { return moreau_.integrals(); }
  std::array<double, 2> outside_work() const { return moreau_.outside_work(); }
  const Extremes& extremes() const { return moreau_.extremes(); }
  const Work& work() const { return moreau_.work(); }
  Work& work() { return moreau_.totals().work; }
  void add_notes(std::vector<std::string>& notes) const;
  double unseen() const { return found_.unseen; }
  bool singular() const { return moreau_.singular(); }
  double nearest_singular() const { return moreau_.nearest_singular(); }

  /// The stepper at the end of the last accepted step.
  const MoreauStepper& moreau() const { return moreau_; }
  /// Whether the next step is a step over an impact.
  bool impact_next() const { return impacting_; }
  /// s: no impact since then.
  double calm_since() const { return calm_since_; }
  double first_step() const { return 1e-3 * scales_.time; }

 private:
  /// One attempt of a smooth step.
  struct Attempt {
    double end;    // s, at the latest
    double least;  // s, rounding of times
    double h;      // s
    int landings = 0, halvings = 0;
  };
  enum class Outcome { accepted, again, failed };
  Outcome attempt(Attempt& a, double t_end);
  void refuse(Attempt& a, double shorter);
  bool land_on_onset(Attempt& a, const OnsetSearch::Onset& onset);
  bool land_on_kink(Attempt& a, double floor);
  bool land_on_change(Attempt& a, double floor);
  bool smooth_step(double t_end, double rounding);
  bool impact_step(double t_end);
  void close_after_impact();
  void settle();
  double curve_limit() const;
  bool report(double t, Forces& out);
  bool bounce_is_over(const OnsetSearch::Onset& onset) const;
  int found_inside() const;
  bool fail_inside(int contact);
  double near(int k) const { return search_.near(k, moreau_.q()); }
  StepContact& contact(int k) { return moreau_.contacts()[k]; }
  bool fail(const std::string& why) {
    failure_ = why;
    return false;
  }

  const System& system_;
  MoreauStepper moreau_;
  double tolerance_;
  Scales scales_;
  StepPair pair_;
  PeakLimit peaks_;
  OnsetSearch search_;
  StepPace pace_;
  double h_ = 0;             // s, of the next step
  bool impacting_ = false;   // the next step is a step over an impact
  bool smooth_step_ = true;  // the last step was smooth
  long steps_ = 0;
  double calm_since_ = 0;  // s
  /// Diagnostics for the reader of the results.
  struct Found {
    // greatest possible undetected depth over the clearance
    double unseen = 0;
    // steps at the floor whose error exceeds the tolerance
    long floored = 0;
    double most_floored = 0, longest_floor = 0;  // error over the tolerance; s
    long ended = 0;                              // number of ended bounces
    double ended_time = 0;                       // s, duration of the longest
  } found_;
  std::function<std::unique_ptr<EventDynamics>()> equations_;
  std::unique_ptr<EventDynamics> shown_;  // made when forces are first observed
  std::vector<double> x_;                 // work space: a state of shown_
  Forces scratch_, integrated_;           // the latter over the step that ends at integrated_at_ (s)
  double integrated_at_ = NAN;
  std::string failure_;
};

}  // namespace freeplay
