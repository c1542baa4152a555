// The stepping loop, one instance for each kind of stepper. A run calls it to the end; runs in lanes
// (formulations/time_stepping/lanes.hpp) call it for single steps. It makes no virtual call, no allocation
// and no string, except to show a step to observers.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/sampling.hpp"
#include "dynamics/system.hpp"
#include "simulation/contact_log.hpp"
#include "simulation/formulation.hpp"
#include "simulation/instrument.hpp"
#include "simulation/observer.hpp"
#include "values/stop.hpp"

namespace freeplay {

/// Connects the stepping loop with the observers: forwards events, steps and samples, and holds the
/// stop token.
class Watch {
 public:
  Watch(const Layout& layout, Sensors& sensors, std::vector<Observer*> observers, StopToken stop);

  bool stop() const { return stop_(); }
  /// Whether any observer or sensor needs the steps.
  bool any() const { return wants_.steps || wants_.samples; }
  bool wants_forces() const { return wants_.forces; }

  void begin(const State& state);
  /// Forwards the final events in the order of time.
  void drain(ContactLog& log) {
    if (log.has_pending()) log.drain([this](const ContactEvent& e) { event(e); });
  }
  void step(const Step& step);
  bool wants_samples() const { return wants_.samples; }
  /// Samples of a step that no observer sees.
  void sample(const Step& step) { sensors_.step(step, sink_); }
  void end(const Ending& ending, double t, const ContactLog& log);

 private:
  void event(const ContactEvent& e);

  const Layout& layout_;
  Sensors& sensors_;
  std::vector<Observer*> observers_, of_steps_;  // of_steps_: those that want steps
  StopToken stop_;
  Wants wants_;
  Sensors::Sink sink_;
  Event event_;  // the event being forwarded
};

// Detects runs that do not progress. Steps of a stiff or singular motion may become so small that
// the end is out of reach, although each step is accepted. With windows of N = Progress::window
// steps and L the length of the run, at most 100 s, a window is too slow if
//
//     Δt < share · N · L,        share = 1e-10,
//
// that is, if more than 1e10 steps are needed for L: hours at a microsecond a step. A run stops
// after three such windows in succession. Accumulating impacts and repeated contacts need fewer
// steps than that. L is limited to 100 s so that a long run of ordinary steps is not stopped.

class Progress {
 public:
  static constexpr long window = 1'000'000;
  static constexpr int most_windows = 3;
  static constexpr double share = 1e-10, longest = 100;  // 1, s

  /// Begins to observe a run from t to t_end (s).
  Progress(double t, double t_end) : begin_(t), left_(t_end - t), length_(std::min(left_, longest)) {}

  /// Call it after each step with the time t (s) reached; returns whether the run must stop.
  bool crawls(double t) {
    if (++steps_ < window) return false;
    const double advance = t - begin_;
    windows_ = advance < share * static_cast<double>(window) * length_ ? windows_ + 1 : 0;
    pace_ = advance / static_cast<double>(window);
    steps_ = 0;
    begin_ = t;
    return windows_ == most_windows;
  }
  double pace() const { return pace_; }  ///< s a step, in the last window
  /// Steps for the whole run at that pace.
  double needed() const { return left_ / std::max(pace_, 1e-300); }

 private:
  double begin_, left_, length_;  // s
  double pace_ = 0;
  long steps_ = 0;
  int windows_ = 0;
};

/// Geometry of all contacts at a state.
inline void contact_places(const System& system, Evaluation& e, double t, std::span<const double> q,
                           std::span<ContactPlace> out) {
  if (system.contacts() == 0) return;
  system.place(t, q.data(), e);
  for (int k = 0; k < system.contacts(); ++k) {
    const auto eccentricity = system.eccentricity(k, q.data(), e);
    out[k] = {eccentricity.x(), eccentricity.y(), system.gap(k, q.data(), e)};
  }
}

/// Adapts a stepper's last step to the interface Step. A Stepper has, for its last step: t_old(),
/// t(), v_old(), v(), z(), interpolate(t, q, v) and multipliers(); in_impact() if it steps over
/// impacts; and for forces forces(t, out), add_impulse(a, b, sum), before() and within() as in
/// Step. Its Owner has ledger() and keep_passed().
template <class Owner, class Stepper>
class StepOf final : public Step {
 public:
  StepOf(Owner& owner, const System& system, Stepper& stepper, const Watch& watch)
      : owner_(owner), system_(system), stepper_(stepper), watch_(watch), e_(system.make_evaluation()) {}
  void renew() {
    const auto n = static_cast<std::size_t>(system_.n());
    t0 = stepper_.t_old();
    t1 = stepper_.t();
    requested_ = 0;
    cut_ = false;
    v0 = {stepper_.v_old(), n};
    v1 = {stepper_.v(), n};
  }
  void state(double t, std::span<double> q, std::span<double> v) const override {
    stepper_.interpolate(t, q.data(), v.data());
  }
  std::span<const double> z() const override { return stepper_.z(); }
  std::span<const double> multipliers() const override { return stepper_.multipliers(); }
  void contacts(double t, std::span<const double> q, std::span<ContactPlace> out) const override {
    contact_places(system_, e_, t, q, out);
  }
  EnergyLedger ledger() const override { return owner_.ledger(); }
  StepImpacts in_impact() const override {
    if constexpr (requires { stepper_.in_impact(); })
      return stepper_.in_impact();
    else
      return Step::in_impact();
  }
  /// Only a step with very many rows is cut. The remainder of any other step is recorded soon, so
  /// its rows are not lost.
  bool stopped() const override { return cut_ = cut_ || (++requested_ > 10000 && watch_.stop()); }
  bool cut() const override { return cut_; }
  void forces(double t, Forces& out) const override { stepper_.forces(t, shaped(out)); }
  void add_impulse(double a, double b, Forces& sum) const override {
    stepper_.add_impulse(a, b, shaped(sum));
  }
  const Forces& before() const override { return wanted(), stepper_.before(); }
  const Forces& within() const override { return wanted(), stepper_.within(); }

 private:
  void wanted() const {
    if (!watch_.wants_forces())
      throw std::logic_error("forces of a step are known only where an observer's wants() ask for them");
  }
  Forces& shaped(Forces& f) const {
    wanted();
    f.elements.resize(elements_);
    f.acceleration.resize(static_cast<std::size_t>(system_.n()));
    return f;
  }

  Owner& owner_;
  const System& system_;
  Stepper& stepper_;
  const Watch& watch_;
  mutable Evaluation e_;
  mutable long requested_ = 0;  // calls during this step
  mutable bool cut_ = false;
  std::size_t elements_ = system_.report().elements.size();
};

/// The message for a run whose steps have become too small; names the contact with the smallest gap
/// relative to its own scale.
inline std::string crawl_reason(const System& system, const Progress& progress, double t, const double* q) {
  auto e = system.make_evaluation();
  system.place(t, q, e);
  std::string nearest;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& facts = system.contact_facts(k);
    const double apart = std::abs(system.gap(k, q, e)) / facts.measure();
    if (!(apart < least)) continue;
    least = apart;
    nearest = facts.has_clearance ? fmt::format("{} (clearance {:.3g} m)", facts.name, facts.clearance)
                                  : facts.name;
  }
  return fmt::format(
      "t = {:.9g} s: the steps have shrunk to {:.2g} s, and the run needs {:.1g} more of them{}; {}use a "
      "coarser step or tolerance, or a shorter run",
      t, progress.pace(), progress.needed(), nearest.empty() ? "" : ", at " + nearest,
      nearest.empty() ? "" : "increase this clearance, omit this contact, or ");
}

/// March: steps until t_end and shows each step to the observers. A Stepper also has step(t_end),
/// which advances by one step, not beyond t_end, and returns false on failure; failure() then gives
/// the reason; and hold(z), which replaces the first-order states between two steps (dynamics/sampling.hpp).
template <class Owner, class Stepper>
class March {
 public:
  March(Owner& owner, const System& system, Stepper& stepper, double t_end, ContactLog& log, Watch& watch)
      : owner_(owner),
        system_(system),
        stepper_(stepper),
        log_(log),
        watch_(watch),
        step_(owner, system, stepper, watch),
        progress_(stepper.t(), t_end),
        t_end_(t_end),
        t_stop_(system.sampled().empty() ? t_end : stepper.t()),
        z_(stepper.z().begin(), stepper.z().end()) {
    stepper.watch_forces(watch.wants_forces());
  }
  /// Makes one step. Returns false at the end of the run.
  bool step() {
    if (!(stepper_.t() < t_stop_) && !take_samples()) return false;
    if (watch_.stop()) return end({Ending::Status::interrupted, "interrupted"});
    if (!stepper_.step(t_stop_)) return end({Ending::Status::failed, stepper_.failure()});
    owner_.keep_passed();
    if (progress_.crawls(stepper_.t()))
      return end({Ending::Status::failed, crawl_reason(system_, progress_, stepper_.t(), stepper_.q())});
    log_.advance(stepper_.t());
    watch_.drain(log_);
    if (!watch_.any()) return true;
    step_.renew();
    watch_.step(step_);
    if (step_.cut()) return end({Ending::Status::interrupted, "interrupted"});  // also in the last step
    return true;
  }
  const Ending& ending() const { return ending_; }

 private:
  bool end(Ending ending) {
    ending_ = std::move(ending);
    return false;
  }
  /// Where steps have to end, or at the beginning: takes the samples that are due. Returns false at the end
  /// of the run, whose samples belong to the next run.
  bool take_samples() {
    const double t = stepper_.t();
    if (!(t < t_end_)) return false;
    std::ranges::copy(stepper_.z(), z_.begin());
    if (system_.sample(t, stepper_.q(), stepper_.v(), z_.data())) stepper_.hold(z_);
    t_stop_ = system_.next_sample(t, z_.data());
    if (is_due(t_end_, t_stop_)) t_stop_ = t_end_;
    return true;
  }

  Owner& owner_;
  const System& system_;
  Stepper& stepper_;
  ContactLog& log_;
  Watch& watch_;
  StepOf<Owner, Stepper> step_;
  Progress progress_;
  double t_end_, t_stop_;  // of the run, of the next steps
  std::vector<double> z_;  // work space
  Ending ending_;
};

}  // namespace freeplay
