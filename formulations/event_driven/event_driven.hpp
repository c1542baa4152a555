// Event-driven integration of the set-valued laws: smooth motion by Dormand and Prince's pair with dense
// output; impacts, losses of contact, and changes between stick and slip located on it and landed on by a
// step of their own, and the motion begun anew in the mode that the accelerations choose. Where films of lubricated
// joints hold it to steps of their own decay time, Rosenbrock's implicit method of fourth order goes on (relieved.hpp).
//
// A contact that bounces ever faster would take infinitely many impacts to come to rest. With u⁺ its rate
// after an impact, e = u⁺/|u⁻| and g̈ < 0 what presses it, the rest of the sequence lasts
//
//     τ = 2u⁺/(|g̈| (1 − e)).
//
// Once its hops are lower than 1e-9 of the clearance (or a thousand roundings of the gap) the contact is
// closed: its impulses over τ are the same up to τ², and the touch is recorded at the end of the sequence,
// with τ as its uncertainty.
//
// Contacts whose gaps close within the integration's own error of each other strike at once: a slider that
// lands flat on two corners would else be given a cascade of single impacts by whichever error came first.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formulations/automatic/handover.hpp"
#include "formulations/event_driven/event_dynamics.hpp"
#include "formulations/integrators/crossing.hpp"
#include "formulations/integrators/relieved.hpp"
#include "formulations/probe.hpp"
#include "simulation/force_integral.hpp"

namespace freeplay {

class EventDriven {
 public:
  /// Explicit; where films make it creep, Rosenbrock's implicit method goes on.
  using Method = Relieved<Dopri5>;
  /// `coarse`: the method once modes are decided together, or after another scheme's steps; `time_scale`: s, in which something happens;
  /// `position_error`: m, accepted in a step.
  EventDriven(EventDynamics dynamics, Method method, Method coarse, double time_scale, double position_error);

  void start(const State& state, ContactLog& log);
  bool step(double t_end);
  const std::string& failure() const { return failure_; }

  /// @name Handing over to time stepping
  ///@{
  /// From now on step() gives up, in the state before, where contacts kick each other too fast to be told, modes of
  /// many change without end, or friction admits none: instead of ending hops early, deciding all contacts at each
  /// evaluation, and impacts without collision.
  void give_way() { gives_way_ = true; }
  /// No pace is known of the scene: that of what moves is taken, `length` (m) over its speed.
  void find_pace(double length) { pace_length_ = length; }
  double time_scale() const { return time_scale_; }
  /// Impacts and changes of contact so far, in this run of the scheme.
  long events() const { return recent_; }
  /// Whether a contact is closed, or friction follows reactions: what may make steps shrink to nothing.
  bool in_contact() const {
    return !dynamics_.system().reactive_frictions().empty() ||
           std::ranges::any_of(dynamics_.contacts(), [](const auto& c) { return c.closed; });
  }
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
    m(method_, unseen_, mark_, pending_, last_, recent_, recent_since_, window_since_, slow_windows_,
      changes_, changes_since_, block_, block_since_, struck_first_, several_, hurried_, together_since_,
      most_kinetic_, unloaded_, ended_, jams_, unsolved_, inelastic_, last_jam_, merged_, crowd_,
      last_impact_, time_scale_, span_, before_mode_);
    remember_probe(m, probe_, watching_, [this] { make_probe(); });
  }

  double t() const { return method_.t; }
  double t_old() const { return method_.t_old; }
  /// At the end of the step, before an impact that may follow there.
  const double* v() const { return method_.x.data() + dynamics_.system().n(); }
  const double* v_old() const { return method_.x_old.data() + dynamics_.system().n(); }
  void interpolate(double t, double* q, double* v) const;

  const double* q() const { return method_.x.data(); }
  std::span<const double> z() const {
    return {method_.x.data() + dynamics_.state_offset(),
            static_cast<std::size_t>(dynamics_.system().states())};
  }
  std::span<const double> multipliers() const { return dynamics_.multipliers(); }

  /// @name Forces; see Step
  ///@{
  void watch_forces(bool on);
  void forces(double t, Forces& out);
  void add_impulse(double a, double b, Forces& sum) { integrate_forces(*this, a, b, force_, sum); }
  const Forces& before() const { return before_step_; }
  const Forces& within() const { return within_; }
  ///@}
  EnergyLedger integrals() const;
  /// J, of drives and of loads.
  std::array<double, 2> outside_work() const {
    const double* w = method_.x.data() + dynamics_.integral_offset();
    return {w[EventDynamics::drive], w[EventDynamics::load]};
  }
  /// What a reader of the results must know of this run's contacts.
  void tell(std::vector<std::string>& notes) const;
  const Work& work() const { return dynamics_.work; }
  const Extremes& extremes() const { return dynamics_.extremes; }
  /// How deep, over its clearance, a contact may have been between places where it was looked at; 0: proved apart.
  double unseen() const { return unseen_; }
  bool singular() const { return dynamics_.singular(); }
  double nearest_singular() const { return dynamics_.nearest_singular(); }

 private:
  struct Event {
    enum class Kind { none, gap, force, stick, slip, slide_stick, slide_slip, phase_down, phase_up };
    Kind kind = Kind::none;
    int index = -1;
    double t = 0;
    template <class M>
    void remember(M& m) {
      m(kind, index, t);
    }
  };
  struct Mark {
    Watched gap;                                 // at the end of the last step, open contacts
    double allowance = 0;                        // m: the gap began that far below zero, and opens from there
    double impulse_n = 0, impulse_t = 0, t = 0;  // at first touch of a closed one
    template <class M>
    void remember(M& m) {
      m(gap.value, gap.rate, allowance, impulse_n, impulse_t, t);
    }
  };

  void make_probe();
  Event shorten_until_bounded();
  bool find_gap_events(Event& first);
  void find_mode_events(Event& first);
  struct Dip {
    double t, value;
  };
  std::optional<Dip> find_dip(std::size_t i, double start, double middle, double end, double shift);
  void find_phase_events(Event& first);
  void watch(const std::vector<double>& x, std::vector<double>& values);
  void values_at(double t, std::vector<double>& values);
  void land(Event& event);
  bool change_mode();
  bool is_finite() const;
  bool settle_together();
  bool decide_together();
  void keep_mode();
  void give_back_mode();
  bool paced();
  bool count_impact(const std::vector<int>& touching);
  bool impacts(std::vector<int>& touching);
  struct Unloaded;
  Unloaded unloaded_in(const std::vector<int>& struck) const;
  bool ending_contacts(const std::vector<int>& struck, const std::vector<int>& staying,
                       std::vector<int>& over);
  bool choose(std::vector<int>& touching);
  bool jam(std::vector<int>& touching);
  void record(const std::vector<int>& was_closed);
  const std::vector<double>& at(double t) const;
  Watched gap_at(int k, double t);
  GapMotion motion_of(int k);
  void mark_gaps(bool begin = false);
  double rounding(int k) const;
  double slack(int k) const;
  double least_hop(int k) const;
  double crank() const { return dynamics_.system().crank_angle(method_.x.data()); }
  bool fail(const std::string& what);
  bool fail_mode(const std::string& what);

  EventDynamics dynamics_;
  Method method_, coarse_;
  bool is_coarse_ = false;  // method_ is that
  MotionBounds bounds_;     // of the last step
  double unseen_ = 0;       // greatest, over the clearance
  double step_unseen_ = 0;  // the same of the last search
  /// Contacts closed before their hops were low, where impacts follow each other too fast.
  struct Ended {
    long count = 0;
    double time = 0, energy = 0;  // s, J: the greatest of one closing
    void take(std::size_t n, const std::vector<double>& ending, double lost) {
      if (n == 0) return;
      count += static_cast<long>(n);
      for (const double tau : ending) time = std::max(time, tau);
      energy = std::max(energy, lost);
    }
    template <class M>
    void remember(M& m) {
      m(count, time, energy);
    }
  };
  double time_scale_, span_, position_error_;
  ContactLog* log_ = nullptr;
  std::vector<Mark> mark_;
  std::vector<int> decided_;
  std::vector<int> kicked_;     // contacts that an impact elsewhere threw off, by less than a hop
  std::vector<double> ending_;  // s, τ of contacts closed by accumulation now, else 0
  std::vector<double> rate_before_, slide_before_;
  mutable std::vector<double> scratch_;
  std::vector<double> slope_, before_, middle_, after_, between_;
  std::vector<double> finite_;  // the state before the last step, and its time
  double finite_t_ = 0;
  std::vector<Event> watched_;  // what the values stand for
  bool pending_ = false;        // the mode changes before the next step
  Event last_;
  long recent_ = 0;  // events
  double pace_length_ = 0;
  double recent_since_ = -INFINITY, window_since_ = -INFINITY;
  int slow_windows_ = 0;  // one after the other, of events that took next to no time
  int changes_ = 0;       // of modes since the last impact, in next to no time
  double changes_since_ = -INFINITY;
  int block_ = 0;  // impacts in the present span
  double block_since_ = -INFINITY;
  int struck_first_ = -1;      // in the present span
  double together_since_ = 0;  // s
  bool several_ = false;       // contacts were struck in it
  double merged_ = 0;          // m, the greatest gap of a contact struck together with another
  bool hurried_ = false;       // impacts follow each other faster than can be told one by one
  double most_kinetic_ = 0;    // J, before any impact so far
  /// Contacts closed to rounding, without load and without approach, that took part in the first impact that has any.
  struct Unloaded {
    int count = 0, contact = -1;  // contact: one of them
    double t = 0, gap = 0;        // s, m: the greatest of them
    void take(const Unloaded& other) {
      if (count == 0) *this = other;
    }
    template <class M>
    void remember(M& m) {
      m(count, contact, t, gap);
    }
  } unloaded_;
  Ended ended_, jams_, unsolved_, inelastic_;
  int crowd_ = 0;  // impacts at one instant
  double last_impact_ = -INFINITY;
  double last_jam_ = -INFINITY;  // s: a step was refused there for what slides
  std::string failure_;
  bool gives_way_ = false, way_given_ = false;
  /// What a mode that is not found must give back.
  struct BeforeMode {
    std::vector<double> x;
    double contact_loss = 0, stabilisation = 0;
    std::vector<bool> closed;
    template <class M>
    void remember(M& m) {
      m(x, contact_loss, stabilisation);
    }
  } before_mode_;
  bool watching_ = false;
  std::unique_ptr<EventDynamics> probe_;  // made when forces are first watched
  Forces before_step_, within_, strike_, force_;
};

}  // namespace freeplay
