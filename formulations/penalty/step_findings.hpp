// Findings about the steps of a penalty run: PenaltyPace, whether they make progress, and FixedStepErrors,
// their errors without error control.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "dynamics/system.hpp"
#include "formulations/integrators/methods.hpp"

namespace freeplay {

/// Criteria for steps that make no progress. They depend on numbers only: times, and counts of steps and
/// events.
class PenaltyPace {
 public:
  /// `time`: characteristic time of the scene (s), Scales::time. Coincident events of its contacts take a
  /// step without length each.
  PenaltyPace(double time, int contacts) : time_(time), most_stalled_(10 + 2 * contacts) {}

  /// Called after each step from t_old to t; false if many events or steps without length follow each
  /// other.
  bool progresses(double t_old, double t, bool event, double run_end) {
    stalled_ = t > t_old ? 0 : stalled_ + 1;
    if (event && ++events_ == 5000) {  // many events in a negligible time are no motion
      if (t - events_since_ < 1e-9 * ahead(t, run_end)) stalled_ = most_stalled_;
      events_ = 0;
      events_since_ = t;
    }
    return !stalled();
  }
  /// Called after another hundred thousand steps: whether the run would never end. While a contact
  /// `lasts` without any event, only stability requires such short steps, and a hundred million of
  /// them are too many. `events`: those of the run.
  bool creeps(double t, bool lasts, long events, double run_end) {
    const double gained = t - checked_;
    const double share = lasts && events_checked_ == events ? 1e-3 : 1e-7;
    checked_ = t;
    events_checked_ = events;
    return creeps_ = gained < share * ahead(t, run_end);
  }
  bool creeps() const { return creeps_; }
  bool stalled() const { return stalled_ >= most_stalled_; }

  template <class M>
  void serialize(M& m) {
    m(stalled_, creeps_, checked_, events_checked_, events_, events_since_);
  }

 private:
  /// s: the time against which progress is measured, the rest of the run or a thousand times the
  /// characteristic time. A longer run takes more steps, and is no stiffer.
  double ahead(double t, double run_end) const { return std::min(run_end - t, 1000 * time_); }

  double time_;
  int most_stalled_;
  int stalled_ = 0;  // successive steps without length
  int events_ = 0;   // number of events since events_since_ (s)
  double events_since_ = -INFINITY;
  bool creeps_ = false;
  double checked_ = -INFINITY;  // s, of the last creeps(), and the events of the run then
  long events_checked_ = -1;
};

/// Greatest errors of fixed steps in a run, for its notes: at short contacts, at pulses of torque tables, and
/// of steps that are long against the curves that they read.
struct FixedStepErrors {
  /// Error of fixed steps in the impulses of short contacts: a half sine in n steps of fourth order
  /// has a relative error of (π/n)⁴/120, 4e-5 for n = 12.
  struct ShortContact {
    double lost = 0;      ///< m/s, the greatest error as a speed
    double duration = 0;  ///< s, duration of that contact
    double greatest = 0;  ///< m/s, greatest speed change by a contact
  };
  struct Pulse {
    /// greatest change of the speed of a phase's argument in a step, and its greatest speed
    double change = 0, speed = 0;
    template <class M>
    void serialize(M& m) {
      m(change, speed);
    }
  };
  ShortContact short_contact;
  std::vector<Pulse> pulses;
  /// Greatest length of a fixed step over the limit by the curves that it reads.
  double coarse = 0;

  template <class M>
  void serialize(M& m) {
    m(short_contact.lost, short_contact.duration, short_contact.greatest, pulses, coarse);
  }

  /// Greatest change of a speed by the change of its acceleration in one step, over the greatest
  /// speed (tables).
  double pulse() const {
    double most = 0;
    for (const auto& p : pulses) most = std::max(most, p.change > 0 ? p.change / p.speed : 0);
    return most;
  }
  /// Records a contact of a duration (s) that changed a speed (m/s), with steps of h (s).
  void keep_contact(double h, double duration, double change) {
    if (!std::isfinite(change)) return;
    const double angle = std::numbers::pi * h / duration;
    const double lost = std::min(1.0, angle * angle * angle * angle / 120) * change;
    short_contact.greatest = std::max(short_contact.greatest, change);
    if (lost > short_contact.lost) short_contact.lost = lost, short_contact.duration = duration;
  }
  /// Records how much the change of an angle's acceleration within the last step changes its speed,
  /// if a torque table acts on it: the error of a method without error control at a steep pulse.
  template <class Method>
  void keep_pulse(const System& system, const Method& method) {
    const auto n = static_cast<std::size_t>(system.n());
    pulses.resize(static_cast<std::size_t>(system.phases()));
    for (int k = 0; k < system.phases(); ++k) {
      if (system.phase(k).speed || system.phase(k).contact) continue;
      const auto rate = [&](const Vector& x, const double* v) {
        return system.phase(k).at(x.data(), v).rate;
      };
      const double a0 = rate(method.x_old, method.dxdt_old.data() + n),
                   a1 = rate(method.x, method.dxdt.data() + n);
      const double w0 = rate(method.x_old, method.x_old.data() + n), w1 = rate(method.x, method.x.data() + n);
      auto& pulse = pulses[static_cast<std::size_t>(k)];
      pulse.change = std::max(pulse.change, std::abs(a1 - a0) * (method.t - method.t_old));
      pulse.speed = std::max({pulse.speed, std::abs(w0), std::abs(w1)});
    }
  }
};

}  // namespace freeplay
