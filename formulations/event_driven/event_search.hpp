// Where a mode of the event-driven scheme ends, searched on the dense output of the last step:
//
//   - an open contact's gap reaches zero: proved by bounds on its motion, not sampled (integrators/crossing.hpp);
//   - a closed contact's normal force reaches zero, or the friction of what sticks reaches its bound;
//   - sliding comes to an end;
//   - an angle reaches a kink of a torque table.
//
// The earliest of them is the event. Where the step is too long for the bounds to say anything, it is made again, shorter. The
// search owns what it remembers between steps (gaps at a step's end, values watched at its beginning); dynamics and method
// belong to the scheme and are passed to each call.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "formulations/event_driven/event_dynamics.hpp"
#include "formulations/integrators/crossing.hpp"
#include "formulations/integrators/relieved.hpp"

namespace freeplay {

struct ModeEvent {
  enum class Kind { none, gap, force, stick, slip, slide_stick, slide_slip, phase_down, phase_up };
  Kind kind = Kind::none;
  int index = -1;  ///< of the contact, preloaded joint or phase
  double t = 0;    ///< s
  bool is_phase() const { return kind == Kind::phase_down || kind == Kind::phase_up; }
  /// What sticks has reached the bound of its friction.
  bool ends_sticking() const { return kind == Kind::stick || kind == Kind::slide_stick; }
  template <class M>
  void remember(M& m) {
    m(kind, index, t);
  }
};

class EventSearch {
 public:
  /// Explicit; where films make it creep, Rosenbrock's implicit method goes on.
  using Method = Relieved<Dopri5>;
  using Vector = std::vector<double>;

  explicit EventSearch(const EventDynamics& dynamics);

  /// Before a step: what the mode watches, from the last evaluation of the dynamics.
  void begin(const EventDynamics& d, const Vector& x) { watch(d, x, before_); }
  /// The first event of the last step, kind none if there is none; the step may become shorter.
  ModeEvent find(EventDynamics& d, Method& m);
  /// Makes the last step end at its event, and looks whether a gap was lost before it once more.
  void land(EventDynamics& d, Method& m, ModeEvent& event);
  /// Gaps at the end of a step; `begin`: of a mode. A gap that begins below zero opens from there: the correction of what is
  /// closed moved it, or its impact was merged with another's.
  void mark_gaps(EventDynamics& d, const Method& m, bool begin = false);
  /// The state within the last step.
  const Vector& at(const Method& m, double t) const;
  /// How deep, over its clearance, a contact may have been between places where it was looked at; 0: proved apart.
  double unseen() const { return unseen_; }

  template <class M>
  void remember(M& m) {
    m(unseen_, marks_);
  }

 private:
  struct Mark {
    Watched gap;           // at the end of the last step, open contacts
    double allowance = 0;  // m: the gap began that far below zero, and opens from there
    template <class M>
    void remember(M& m) {
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
  std::optional<Dip> find_dip(EventDynamics& d, const Method& m, std::size_t i, double start, double middle,
                              double end, double shift);
  void land_on(EventDynamics& d, Method& m, ModeEvent& event);
  void watch(const EventDynamics& d, const Vector& x, Vector& values);
  void values_at(EventDynamics& d, const Method& m, double t, Vector& values);
  Watched gap_at(EventDynamics& d, const Method& m, int k, double t);

  MotionBounds bounds_;     // of the last step
  double unseen_ = 0;       // greatest, over the clearance
  double step_unseen_ = 0;  // the same of the last search
  std::vector<Mark> marks_;
  std::vector<ModeEvent> watched_;  // what the values stand for
  Vector before_, middle_, after_, between_, slope_;
  mutable Vector scratch_;
};

}  // namespace freeplay
