// Moreau–Jean time stepping whose steps are chosen by an estimate of their error (Studer, Leine and Glocker, Int. J.
// Numer. Meth. Engng 76 (2008) 1747, extrapolate smooth stretches and shrink the steps that hold a switching; what follows
// is our own way to do so).
//
// *Smooth steps.* What is closed takes part, without restitution; what is open does not. One step of h and two of h/2 from
// the same state differ by three times the error of the two, which is accepted up to nonsmooth.step_tolerance in the norm
// of the event-driven scheme's integrator; where all three pressed, stuck and slid alike their extrapolation goes on.
// Where they did not, the difference itself is the error, down to a floor of the step.
//
// *Touches.* The gaps of what is open are searched on the path (Hermite's cubics through the three states) with the proof
// of crossing.hpp. The step is made again to end where the first comes to zero, and one short step over the impact
// follows, by the impact law and with all contacts: of length tolerance × ℓ over the approach speed, so that an impact that
// acts anywhere in it moves nothing by more than tolerance × ℓ. Impacts are thus of the step's own problem: several at
// once, with what rests, in any number.
//
// *Accumulations.* A hop not higher than tolerance × clearance, or not longer than two floors, is over: its contact is
// closed. Where many impacts follow each other the floor is raised, up to 3e-3 of the time scale, and lowered again.
#pragma once

#include <array>
#include <optional>

#include "formulations/automatic/handover.hpp"
#include "formulations/integrators/methods.hpp"
#include "formulations/integrators/tolerance.hpp"
#include "formulations/time_stepping/moreau.hpp"

namespace freeplay {

class ControlledMoreau {
 public:
  /// `moreau` without a step of its own; `norm`: accepted errors of [q, v].
  ControlledMoreau(const System& system, MoreauStepper moreau, ErrorNorm norm, const Scales& scales);

  void start(const State& state, ContactLog& log);
  /// Goes on from where another scheme left, and hands back.
  void take_over(const Handover& from, ContactLog& log);
  Handover hand_over();
  /// One accepted step, which ends at t_end at the latest.
  bool step(double t_end);
  const std::string& failure() const { return failure_; }

  template <class M>
  void remember(M& m) {
    m.part("controlled");
    m(moreau_, start_.t, start_.q, start_.v, middle_q_, middle_v_, middle_t_, h_, floor_, least_floor_,
      fastest_, pace_, striking_, smooth_step_, unseen_, steps_, paced_, paced_since_, calm_since_, floored_,
      most_floored_, longest_floor_, ended_, ended_time_, smooth_, within_, film_pace_, calm_speed_, gains_,
      calm_gains_, strikes_);
  }

  double t() const { return moreau_.t(); }
  double t_old() const { return start_.t; }
  const double* v() const { return moreau_.v(); }
  const double* v_old() const { return start_.v.data(); }
  const double* q() const { return moreau_.q(); }
  void interpolate(double t, double* q, double* v) const;
  /// Smooth steps have no impacts.
  Struck struck() const { return smooth_step_ ? Struck{t(), {}} : moreau_.struck(); }
  std::span<const double> z() const { return moreau_.z(); }
  std::span<const double> multipliers() const { return moreau_.multipliers(); }

  /// @name Forces: of a step its impulses over its length; see MoreauStepper
  ///@{
  void watch_forces(bool on);
  void forces(double, Forces& out) const;
  void add_impulse(double a, double b, Forces& sum) const;
  const Forces& before() const { return moreau_.before(); }
  const Forces& within() const { return within_; }
  ///@}
  const EnergyLedger& integrals() const { return moreau_.integrals(); }
  std::array<double, 2> outside_work() const { return moreau_.outside_work(); }
  const Extremes& extremes() const { return moreau_.extremes(); }
  const Work& work() const { return moreau_.work(); }
  void tell(std::vector<std::string>& notes) const;
  double unseen() const { return unseen_; }
  bool singular() const { return moreau_.singular(); }
  double nearest_singular() const { return moreau_.nearest_singular(); }

  MoreauStepper& moreau() { return moreau_; }
  const MoreauStepper& moreau() const { return moreau_; }
  /// Whether the next step is one over an impact.
  bool strikes_next() const { return striking_; }
  /// s: no impact since then.
  double calm_since() const { return calm_since_; }
  double first_step() const { return 1e-3 * scales_.time; }

 private:
  struct Touch {
    int contact = -1;
    double t = 0, rate = 0;  // s, m/s
  };
  bool pair(double h);
  void extrapolate();
  double error() const;
  double unseen_by_halves() const;
  std::optional<Touch> first_touch();
  std::optional<Touch> touch_in(int k, double a, double b, const double* qa, const double* va,
                                const double* qb, const double* vb);
  void enclose(double h, const double* qa, const double* va, const double* qb, const double* vb);
  std::optional<double> first_kink();
  bool hop_over(const Touch& touch) const;
  double curve_limit() const;
  int found_inside() const;
  bool fail_inside(int contact);
  bool strike(double t_end);
  void settle();
  void keep_pace();
  void find_pace();
  double raised() const;
  double near(int k) const;
  bool fail(const std::string& why = {}) {
    failure_ = why.empty() ? moreau_.failure() : why;
    return false;
  }

  const System& system_;
  MoreauStepper moreau_;
  ErrorNorm norm_;
  Scales scales_;
  Evaluation e_;
  MoreauStepper::Place start_, whole_;
  std::vector<double> middle_q_, middle_v_, look_q_, look_v_;
  std::vector<signed char> modes_whole_, modes_first_, modes_second_;
  MotionBounds bounds_;
  double fastest_ = 0, pace_ = 0;      // m/s; s, in which that crosses the least clearance
  double calm_speed_ = 0;              // m/s, the fastest when impacts last gave nothing
  long gains_ = 0;                     // impacts that raised the energy when the pace was last looked at
  long calm_gains_ = 0;                // the same when calm_speed_ was taken
  double film_pace_ = 0;               // s, of a film that turns with its journal
  double turned_ = 0;                  // m/s, in the last pair
  std::vector<double> pressed_first_;  // N s, of the contacts in the first half step
  double lifted_ = 0;                  // m/s, of the two half steps
  double middle_t_ = 0, h_ = 0, floor_ = 0, least_floor_ = 0;
  bool striking_ = false;                // the next step is one over an impact
  bool smooth_step_ = true;              // the last one was not
  bool bounded_ = true;                  // how gaps may bend within the last pair is known
  double unseen_ = 0, step_unseen_ = 0;  // over the clearance: greatest, and of the last pair
  long steps_ = 0, paced_ = 0;           // steps; since the pace was looked at
  long strikes_ = 0;                     // of those, steps over impacts
  double paced_since_ = 0, calm_since_ = 0;
  long floored_ = 0;                             // steps at the floor beyond the tolerance
  double most_floored_ = 0, longest_floor_ = 0;  // over the tolerance; s
  long ended_ = 0;                               // hops
  double ended_time_ = 0;                        // s, the longest
  bool watching_ = false;
  Forces smooth_, whole_smooth_, within_;
  std::string failure_;
};

}  // namespace freeplay
