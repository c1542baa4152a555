// EventDriven: event-driven integration of the set-valued laws. Smooth motion is integrated by the
// method of Dormand and Prince with dense output. Impacts, separations and changes between stick
// and slip are located on the dense output, and the last step is repeated to end there. The
// accelerations then determine the new mode, and integration starts anew. If lubricant films limit
// the explicit steps to their own decay time, Rosenbrock's implicit method of fourth order takes
// over (integrators/rosenbrock.hpp).
//
// The scheme owns the dynamics of the present mode and the integration method. Its parts are
//
//   EventSearch    finds the end of a mode (event_search.hpp),
//   EventImpacts   solves impacts, and ends bounces that accumulate (event_impacts.hpp),
//   EventPace      checks whether events occur too fast to be resolved (event_findings.hpp).
//
// Contacts whose gaps close within the integration error of each other have simultaneous impacts.
// Otherwise a slider that lands flat on two corners would have a sequence of single impacts, whose
// order depends on the error.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formulations/automatic/handover.hpp"
#include "formulations/event_driven/event_impacts.hpp"
#include "formulations/event_driven/variation.hpp"
#include "simulation/force_integral.hpp"

namespace freeplay {

class EventDriven {
 public:
  using Method = EventSearch::Method;
  /// `coarse`: the method after steps of another scheme; `time_scale`: characteristic time of the
  /// scene (s); `position_error`: error accepted in a step (m).
  EventDriven(EventDynamics dynamics, Method method, Method coarse, double time_scale, double position_error);

  void start(const State& state, ContactLog& log);
  bool step(double t_end);
  const std::string& failure() const { return failure_; }

  /// @name Handover to time stepping
  ///@{
  /// From now on, if friction admits no force on a sliding contact, step() fails and keeps the
  /// state before, instead of ending the sliding by an impact without collision.
  void allow_handover() { hands_over_ = true; }
  /// Used if the scene has no known time scale: it is derived from the moving bodies, as `length`
  /// (m) over their speed.
  void find_pace(double length) { pace_length_ = length; }
  double time_scale() const { return pace_.time_scale(); }
  /// Impacts and changes of contact so far, in this run of the scheme.
  long events() const { return pace_.events(); }
  /// Whether a contact is closed or friction depends on reactions: conditions under which steps may
  /// shrink towards zero.
  bool in_contact() const;
  Handover hand_over() const;
  void take_over(const Handover& from);
  ///@}

  /// @name Derivatives of the motion; call vary() after start()
  ///@{
  void vary(const std::vector<VariedKey>& keys, std::vector<Column> integrands, double length,
            double duration) {
    if (!dynamics_.films.any()) method_.keep_explicit();
    variation_ = std::make_unique<Variation>(dynamics_, keys, std::move(integrands), length, duration);
  }
  double position_error() const { return impacts_.position_error(); }
  Variation& variation() { return *variation_; }
  const Variation& variation() const { return *variation_; }
  const EventDynamics& dynamics() const { return dynamics_; }
  /// The integrated vector.
  const std::vector<double>& x() const { return method_.x; }
  /// The integrated vector at a time within the last step.
  const std::vector<double>& x_at(double t) const { return search_.at(method_, t); }
  ///@}

  template <class M>
  void serialize(M& m) {
    m.part("event-driven");
    m(dynamics_);
    m(is_coarse_);
    if constexpr (M::reading)
      if (is_coarse_) method_ = coarse_;
    m(method_, search_, onsets_, pending_, last_, pace_, impacts_, findings_, span_, kept_, kept_at_,
      last_lockup_, mode_before_);
    forces_.serialize(m, dynamics_, dynamics_.system);
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
  /// The forces may jump, so that the mode is determined anew before the next step.
  void hold(std::span<const double> z) {
    std::ranges::copy(z, method_.x.begin() + dynamics_.state_offset());
    if (!pending_) last_ = {};
    pending_ = true;
  }
  std::span<const double> multipliers() const { return dynamics_.lambda; }

  /// @name Forces; see Step
  ///@{
  void watch_forces(bool on) { forces_.watch(on, dynamics_, dynamics_.system); }
  void forces(double t, Forces& out) { forces_.at(dynamics_, search_.at(method_, t), t, out); }
  void add_impulse(double a, double b, Forces& sum) { integrate_forces(*this, a, b, forces_.scratch(), sum); }
  const Forces& before() const { return forces_.before(); }
  const Forces& within() const { return forces_.within(); }
  ///@}
  EnergyLedger integrals() const;
  /// J, work of drives and of loads.
  std::array<double, 2> outside_work() const;
  /// Adds notes about this run's contacts for the reader of the results.
  void add_notes(std::vector<std::string>& notes) const;
  const Work& work() const { return dynamics_.work; }
  const Extremes& extremes() const { return dynamics_.extremes; }
  /// Greatest possible depth of an undetected contact between the evaluated times, over its
  /// clearance; 0: excluded.
  double unseen() const { return search_.unseen(); }
  bool singular() const { return dynamics_.saddle.singular(); }
  double nearest_singular() const { return dynamics_.saddle.nearest_singular(); }

 private:
  /// Impulses (N s) and time (s) of a contact at its onset, as logged.
  struct ContactOnset {
    double impulse_n = 0, impulse_t = 0, t = 0;  // at contact onset
    template <class M>
    void serialize(M& m) {
      m(impulse_n, impulse_t, t);
    }
  };
  /// State that is restored if no mode is found.
  struct ModeBefore {
    std::vector<double> x;
    double contact_loss = 0, stabilisation = 0;
    std::vector<bool> closed;
    template <class M>
    void serialize(M& m) {
      m(x, contact_loss, stabilisation);
    }
  };

  bool step_until_lockup(double t_end);
  bool change_mode();
  bool choose(std::vector<int>& touching);
  std::optional<std::string> choose_ahead(const std::vector<int>& touching);
  void slip_if_repeated();
  bool end_lockup(std::vector<int>& touching);
  void record(const std::vector<int>& was_closed);
  void keep_mode();
  void give_back_mode();
  bool fail(const std::string& what);
  bool beyond(const std::string& what);

  EventDynamics dynamics_;
  Method method_, coarse_;
  bool is_coarse_ = false;  // method_ is coarse_
  EventSearch search_;
  EventImpacts impacts_;
  EventPace pace_;
  double pace_length_ = 0;  // m, 0: the scene has a time scale
  EventFindings findings_;
  WatchedForces forces_;
  ContactLog* log_ = nullptr;
  std::vector<ContactOnset> onsets_;
  bool pending_ = false;  // the mode changes before the next step
  ModeEvent last_;
  double span_ = 0;  // s: length of recent steps, the time in which the forces of a mode change
  int kept_ = 0;     // successive limits of joint friction whose mode was kept, and the last one's time
  double kept_at_ = -INFINITY;
  double last_lockup_ = -INFINITY;  // s: a step was rejected there because of sliding contacts
  std::vector<double> finite_;      // the state before the last step, and its time
  double finite_t_ = 0;
  std::string failure_;
  bool hands_over_ = false;
  ModeBefore mode_before_;
  std::unique_ptr<Variation> variation_;  // null unless derivatives are requested
};

}  // namespace freeplay
