// Event-driven integration of the set-valued laws: smooth motion by Dormand and Prince's pair with dense output; impacts,
// losses of contact, and changes between stick and slip located on it and landed on by a step of their own, and the motion
// begun anew in the mode that the accelerations choose. Where films of lubricated joints hold it to steps of their own decay
// time, Rosenbrock's implicit method of fourth order goes on (integrators/relieved.hpp).
//
// The scheme owns the dynamics of the present mode and the method, and asks
//
//   EventSearch    where a mode ends (event_search.hpp),
//   EventImpacts   for impacts, and for bounces that accumulate (event_impacts.hpp),
//   EventPace      whether events follow each other too fast to be resolved (event_pace.hpp).
//
// Contacts whose gaps close within the integration's own error of each other are in impact at once: a slider that lands flat on
// two corners would else be given a cascade of single impacts by whichever error came first.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formulations/automatic/handover.hpp"
#include "formulations/event_driven/event_impacts.hpp"
#include "simulation/force_integral.hpp"

namespace freeplay {

class EventDriven {
 public:
  using Method = EventSearch::Method;
  /// `coarse`: the method after another scheme's steps; `time_scale`: s, in which something happens; `position_error`: m,
  /// accepted in a step.
  EventDriven(EventDynamics dynamics, Method method, Method coarse, double time_scale, double position_error);

  void start(const State& state, ContactLog& log);
  bool step(double t_end);
  const std::string& failure() const { return failure_; }

  /// @name Handing over to time stepping
  ///@{
  /// From now on step() gives up, in the state before, where friction admits no force on what slides, instead of ending the
  /// sliding by an impact without collision.
  void give_way() { gives_way_ = true; }
  /// No pace is known of the scene: that of what moves is taken, `length` (m) over its speed.
  void find_pace(double length) { pace_length_ = length; }
  double time_scale() const { return pace_.time_scale(); }
  /// Impacts and changes of contact so far, in this run of the scheme.
  long events() const { return pace_.events(); }
  /// Whether a contact is closed, or friction follows reactions: what may make steps shrink to nothing.
  bool in_contact() const;
  Handover hand_over() const;
  void take_over(const Handover& from);
  ///@}

  template <class M>
  void remember(M& m) {
    m.part("event-driven");
    m(dynamics_);
    m(is_coarse_);
    if constexpr (M::reading)
      if (is_coarse_) method_ = coarse_;
    m(method_, search_, touches_, pending_, last_, pace_, impacts_, findings_, last_lockup_, mode_before_);
    forces_.remember(m, dynamics_);
  }

  double t() const { return method_.t; }
  double t_old() const { return method_.t_old; }
  const double* q() const { return method_.x.data(); }
  /// At the end of the step, before an impact that may follow there.
  const double* v() const { return method_.x.data() + dynamics_.system.n(); }
  const double* v_old() const { return method_.x_old.data() + dynamics_.system.n(); }
  void interpolate(double t, double* q, double* v) const;
  std::span<const double> z() const {
    return {method_.x.data() + dynamics_.state_offset(), static_cast<std::size_t>(dynamics_.system.states())};
  }
  std::span<const double> multipliers() const { return dynamics_.lambda; }

  /// @name Forces; see Step
  ///@{
  void watch_forces(bool on) { forces_.watch(on, dynamics_); }
  void forces(double t, Forces& out) { forces_.at(dynamics_, search_.at(method_, t), t, out); }
  void add_impulse(double a, double b, Forces& sum) { integrate_forces(*this, a, b, forces_.scratch(), sum); }
  const Forces& before() const { return forces_.before(); }
  const Forces& within() const { return forces_.within(); }
  ///@}
  EnergyLedger integrals() const;
  /// J, of drives and of loads.
  std::array<double, 2> outside_work() const;
  /// What a reader of the results must know of this run's contacts.
  void tell(std::vector<std::string>& notes) const;
  const Work& work() const { return dynamics_.work; }
  const Extremes& extremes() const { return dynamics_.extremes; }
  /// How deep, over its clearance, a contact may have been between places where it was looked at; 0: proved apart.
  double unseen() const { return search_.unseen(); }
  bool singular() const { return dynamics_.saddle.singular(); }
  double nearest_singular() const { return dynamics_.saddle.nearest_singular(); }

 private:
  /// What the log holds of a contact: N s, s.
  struct Touch {
    double impulse_n = 0, impulse_t = 0, t = 0;  // at its first touch
    template <class M>
    void remember(M& m) {
      m(impulse_n, impulse_t, t);
    }
  };
  /// What a mode that is not found must give back.
  struct ModeBefore {
    std::vector<double> x;
    double contact_loss = 0, stabilisation = 0;
    std::vector<bool> closed;
    template <class M>
    void remember(M& m) {
      m(x, contact_loss, stabilisation);
    }
  };

  bool step_until_lockup(double t_end);
  bool change_mode();
  void slide_at_limits();
  bool choose(std::vector<int>& touching);
  std::optional<bool> open_unpressed(std::vector<int>& touching);
  bool end_lockup(std::vector<int>& touching);
  void record(const std::vector<int>& was_closed);
  void keep_mode();
  void give_back_mode();
  bool fail(const std::string& what);
  bool beyond(const std::string& what);

  EventDynamics dynamics_;
  Method method_, coarse_;
  bool is_coarse_ = false;  // method_ is that
  EventSearch search_;
  EventImpacts impacts_;
  EventPace pace_;
  double pace_length_ = 0;  // m, 0: the scene's own pace
  EventFindings findings_;
  WatchedForces forces_;
  ContactLog* log_ = nullptr;
  std::vector<Touch> touches_;
  bool pending_ = false;  // the mode changes before the next step
  ModeEvent last_;
  double last_lockup_ = -INFINITY;  // s: a step was refused there for what slides
  std::vector<double> finite_;      // the state before the last step, and its time
  double finite_t_ = 0;
  std::string failure_;
  bool gives_way_ = false;
  ModeBefore mode_before_;
};

}  // namespace freeplay
