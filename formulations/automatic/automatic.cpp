#include "formulations/automatic/automatic.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace freeplay {

AutomaticStepper::AutomaticStepper(EventDriven events, AdaptiveMoreau stepping, double after)
    : events_(std::move(events)), stepping_(std::move(stepping)), after_(after) {
  events_.give_way();
  wait_ = 0.1 * events_.time_scale();
}

void AutomaticStepper::start(const State& state, ContactLog& log) {
  log_ = &log;
  events_.start(state, log);
  stepping_.start(state, log);
  begin_window();
  begin_stretch(state.t, events_.work());
}

void AutomaticStepper::watch_forces(bool on) {
  watching_ = on;
  events_.watch_forces(on);
  stepping_.watch_forces(on);
  if (on && struck_.elements.empty()) {
    struck_.add(0, stepping_.within());
  }
}

bool AutomaticStepper::step(double t_end) {
  if (watching_) struck_.clear();
  if (!steps_) {
    const char* why = gives_up();
    if (!why) why = trial_fails();
    if (!why && events_.step(t_end)) {
      shown_ = false;
      return true;
    }
    pass_on(why ? why : events_.failure());
  }
  if (!stepping_.step(t_end)) {
    failure_ = stepping_.failure();
    if (!told_.reasons.empty())
      failure_ += fmt::format(" (time stepping since {:.9g} s: {})", since_, told_.reasons);
    return false;
  }
  shown_ = true;
  stepping_.work().stepped += stepping_.t() - stepping_.t_old();
  if (calm())
    return_to_events(false);
  else if (costs_more())
    return_to_events(true);
  return true;
}

void AutomaticStepper::begin_stretch(double t, const Work& work) {
  weighing_.from = t;
  weighing_.since = work.factorisations;
}

/// Whether time stepping was slower over its last `patience` factorisations than the event-driven scheme has been.
bool AutomaticStepper::costs_more() {
  auto& w = weighing_;
  const long cost = stepping_.work().factorisations - w.since;
  if (cost < w.patience || stepping_.strikes_next()) return false;
  w.stepping_pace = (stepping_.t() - w.from) / static_cast<double>(cost);
  if (w.stepping_pace * static_cast<double>(w.events_cost) < w.events_time) return true;
  begin_stretch(stepping_.t(), stepping_.work());
  return false;
}

/// At the end of a trial that was slower than time stepping.
const char* AutomaticStepper::trial_fails() {
  auto& w = weighing_;
  const long cost = events_.work().factorisations - w.since;
  if (!w.trial || cost < w.patience / 10) return nullptr;
  if (!trial_pays()) return "the event-driven scheme passes less time with the same work";
  end_trial();
  return nullptr;
}

void AutomaticStepper::end_trial() {
  auto& w = weighing_;
  const bool pays = trial_pays();
  w.patience = pays ? std::max(Weighing::least_patience, w.patience / 2) : 2 * w.patience;
  w.won += pays;
  w.trial = false;
}

/// Whether the trial so far has passed more time with the same work than time stepping did.
bool AutomaticStepper::trial_pays() const {
  const auto& w = weighing_;
  return events_.t() - w.from >
         w.stepping_pace * static_cast<double>(events_.work().factorisations - w.since);
}

/// Whether the event-driven scheme, which goes on, should not: near a singular position, where friction is close to lockup, or where
/// events crowd, its steps shrink to nothing. A thousand steps then pass less than a hundredth of what a thousand passed at
/// best so far in this run. Steps that a smooth motion makes short are no reason: time stepping needs them as well.
const char* AutomaticStepper::gives_up() {
  if (++paced_ < 1000) return nullptr;
  const double passed = events_.t() - paced_since_;
  const long events = events_.events() - paced_events_;
  const double best = std::max(best_, passed);
  const double usual = best_ > 0 ? std::min(best_, events_.time_scale()) : 1e-2 * events_.time_scale();
  begin_window();
  best_ = best;
  const bool contacts = events >= 100 || events_.in_contact() || events_.singular();
  return contacts && passed < 1e-2 * usual ? "the event-driven scheme's steps have shrunk to nothing"
                                           : nullptr;
}

void AutomaticStepper::begin_window() {
  paced_ = 0;
  paced_since_ = events_.t();
  paced_events_ = events_.events();
}

/// Time stepping goes on from where the event-driven scheme could not.
void AutomaticStepper::pass_on(const std::string& why) {
  auto& w = weighing_;
  w.events_time += events_.t() - w.from;
  w.events_cost += events_.work().factorisations - w.since;
  if (w.trial) end_trial();
  const auto from = events_.hand_over();
  stepping_.take_over(from, *log_);
  if (watching_) struck_.add(1, events_.before());
  steps_ = true;
  since_ = from.state.t;
  begin_stretch(since_, from.work);
  ++told_.count;
  stepping_.work().handovers = told_.count;
  // A mode that did not last: wait longer before the next.
  wait_ = since_ - returned_ < wait_ && told_.count > 1 ? std::min(2 * wait_, 1e3 * events_.time_scale())
                                                        : 0.1 * events_.time_scale();
  const auto colon = why.find("s: ");
  const auto reason = colon == std::string::npos ? why : why.substr(colon + 3);
  constexpr std::size_t most = 400;  // characters of them all
  if (told_.reasons.find(reason) == std::string::npos && told_.reasons.size() + reason.size() < most)
    told_.reasons += (told_.reasons.empty() ? "" : "; ") + reason;
}

bool AutomaticStepper::calm() const {
  return stepping_.t() - std::max(since_, stepping_.calm_since()) > wait_;
}

void AutomaticStepper::return_to_events(bool trial) {
  events_.take_over(stepping_.hand_over());
  auto& w = weighing_;
  begin_stretch(stepping_.t(), events_.work());
  w.trial = trial;
  w.trials += trial;
  steps_ = false;
  returned_ = stepping_.t();
  begin_window();
  told_.longest = std::max(told_.longest, returned_ - since_);
}

void AutomaticStepper::tell(std::vector<std::string>& notes) const {
  events_.tell(notes);
  if (told_.count == 0) return;
  stepping_.tell(notes);
  const double open = steps_ ? stepping_.t() - since_ : 0;
  notes.push_back(fmt::format(
      "time stepping with controlled steps took over {} times, for {:.3g} s in all ({:.3g} s at most): {}",
      told_.count, work().stepped, std::max(told_.longest, open), told_.reasons));
  if (const auto& w = weighing_; w.trials > 0)
    notes.push_back(fmt::format(
        "time stepping came to cost more than the event-driven scheme {} times, and gave way to it in the midst of impacts: "
        "for less work {} times",
        w.trials, w.won));
  if (told_.longest > 0)
    notes.push_back(fmt::format(
        "from its first return to events on these are integrated at a tolerance of {:.2g}", after_));
}

}  // namespace freeplay
