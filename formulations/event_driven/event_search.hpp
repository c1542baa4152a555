// EventSearch: finds where a mode of the event-driven scheme ends, on the dense output of the last
// step:
//
//   - the gap of an open contact reaches zero, by rigorous bounds on its motion instead of sampling
//     (integrators/crossing.hpp);
//   - the normal force of a closed contact reaches zero, or the friction of a sticking contact
//     reaches its limit;
//   - sliding stops;
//   - an angle reaches a kink of a torque table;
//   - the demand of a controller reaches its limit.
//
// The earliest of these is the event. If a step is too long for the bounds to be conclusive, it is
// repeated with a shorter length. The search owns its state between steps (gaps at a step's end,
// values at its beginning). The dynamics and the method belong to the scheme and are passed to each
// call.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "formulations/event_driven/event_dynamics.hpp"
#include "formulations/integrators/crossing.hpp"
#include "formulations/integrators/kinks.hpp"
#include "formulations/integrators/peak_limit.hpp"
#include "formulations/integrators/rosenbrock.hpp"

namespace freeplay {

struct ModeEvent {
  /// gap: an open contact closes; force: the force of a closed contact reaches zero; stick:
  /// friction of a sticking contact reaches its limit; slip: sliding of a contact stops;
  /// slide_stick and slide_slip: the same for joints with friction; phase_down and phase_up: an
  /// angle or distance reaches the lower or upper end of its piece; limit_down and limit_up: the
  /// demand of a controller reaches its negative or positive limit.
  enum class Kind {
    none,
    gap,
    force,
    stick,
    slip,
    slide_stick,
    slide_slip,
    phase_down,
    phase_up,
    limit_down,
    limit_up
  };
  Kind kind = Kind::none;
  int index = -1;  ///< of the contact, preloaded joint, phase or controller
  double t = 0;    ///< s
  bool is_phase() const { return kind == Kind::phase_down || kind == Kind::phase_up; }
  bool is_limit() const { return kind == Kind::limit_down || kind == Kind::limit_up; }
  /// A contact force has reached zero, or the friction of a sticking contact or joint its limit.
  bool is_of_force() const { return kind == Kind::force || kind == Kind::stick || kind == Kind::slide_stick; }
  template <class M>
  void serialize(M& m) {
    m(kind, index, t);
  }
};

class EventSearch {
 public:
  /// Explicit; replaced by Rosenbrock's implicit method where films make its steps too short.
  using Method = Relieved<Dopri5>;
  using Vector = std::vector<double>;

  explicit EventSearch(const EventDynamics& dynamics);

  /// Called before a step: takes the monitored values of the mode from the last evaluation of the
  /// dynamics.
  void begin(const EventDynamics& d, const Vector& x) { watch(d, x, before_); }
  /// Returns the first event of the last step, of kind none if there is none; the step may become
  /// shorter.
  ModeEvent find(EventDynamics& d, Method& m);
  /// Makes the last step end at its event, and checks once more whether a gap closed before it.
  void land(EventDynamics& d, Method& m, ModeEvent& event);
  /// Evaluates the gaps at the end of a step; `begin`: at the beginning of a mode. A gap that
  /// begins below zero is measured from there: the projection of closed contacts moved it, or its
  /// impact was merged with that of another contact.
  void mark_gaps(EventDynamics& d, const Method& m, bool begin = false);
  /// Whether the force of each contact and then of each joint is clear of its limits at x, where a
  /// force reached its limit.
  std::vector<bool> clear_of_limits(EventDynamics& d, const Vector& x, const ModeEvent& of);
  /// Returns the state at a time within the last step.
  const Vector& at(const Method& m, double t) const;
  /// Greatest possible depth of an undetected contact between the evaluated times, over its
  /// clearance; 0: excluded.
  double unseen() const { return unseen_; }

  template <class M>
  void serialize(M& m) {
    m(unseen_, marks_);
  }

 private:
  struct Mark {
    Watched gap;           // at the end of the last step, of open contacts
    double allowance = 0;  // m: the gap began this far below zero, and is measured from there
    template <class M>
    void serialize(M& m) {
      m(gap.value, gap.rate, allowance);
    }
  };
  struct Dip {
    double t, value;
  };

  ModeEvent shorten_until_bounded(EventDynamics& d, Method& m);
  bool find_gap_events(EventDynamics& d, Method& m, ModeEvent& first);
  void find_mode_events(EventDynamics& d, const Method& m, ModeEvent& first);
  void find_phase_events(EventDynamics& d, const Method& m, ModeEvent& first);
  void find_limit_events(EventDynamics& d, const Method& m, ModeEvent& first);
  static double tolerance_of(const EventDynamics& d, const ModeEvent& event);
  std::optional<Dip> find_dip(EventDynamics& d, const Method& m, std::size_t i, double start, double middle,
                              double end, double shift);
  void land_on(EventDynamics& d, Method& m, ModeEvent& event);
  void watch(const EventDynamics& d, const Vector& x, Vector& values);
  void values_at(EventDynamics& d, const Method& m, double t, Vector& values);
  Watched gap_at(EventDynamics& d, const Method& m, int k, double t);

  PeakLimit peaks_;
  MotionBounds bounds_;     // of the last step
  double unseen_ = 0;       // greatest, over the clearance
  double step_unseen_ = 0;  // the same for the last search
  std::vector<Mark> marks_;
  std::vector<ModeEvent> watched_;  // meaning of the monitored values
  Vector before_, middle_, after_, between_, slope_;
  mutable Vector scratch_;
  Limits limits_;
};

}  // namespace freeplay
