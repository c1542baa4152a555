#include "formulations/automatic/automatic.hpp"
#include "values/diagnostic.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace freeplay {

AutomaticStepper::AutomaticStepper(EventDriven events, AdaptiveMoreau stepping, double after)
    : events_(std::move(events)),
      stepping_(std::move(stepping)),
      times_(events_.time_scale()),
      after_(after) {
  events_.allow_handover();
}

void AutomaticStepper::start(const State& state, ContactLog& log) {
  log_ = &log;
  events_.start(state, log);
  stepping_.start(state, log);
  shrinkage_.begin(events_.t(), events_.events());
  costs_.begin({state.t, events_.work().factorisations});
}

void AutomaticStepper::vary(const std::vector<VariedKey>& keys, std::vector<Column> integrands, double length,
                            double duration) {
  events_.vary(keys, integrands, length, duration);
  stepped_mode_ = events_.dynamics().twin();
  stepped_ = std::make_unique<StepVariation>(*stepped_mode_, keys, std::move(integrands), length, duration,
                                             events_.position_error());
}

void AutomaticStepper::watch_forces(bool on) {
  watching_ = on;
  events_.watch_forces(on);
  stepping_.watch_forces(on);
  if (on && in_impact_.elements.empty()) in_impact_.add(0, stepping_.within());
}

/// The reason to leave the event-driven scheme although it can continue; null if there is none.
const char* AutomaticStepper::gives_up() {
  if (shrinkage_.due() && shrinkage_.shrunk(events_.t(), events_.events(),
                                            events_.in_contact() || events_.singular(), events_.time_scale()))
    return "the steps of the event-driven scheme have become too short";
  if (costs_.trial_failed(progress())) return "the event-driven scheme covers less time at the same cost";
  return nullptr;
}

bool AutomaticStepper::step(double t_end) {
  if (watching_) in_impact_.clear();
  if (!steps_) {
    const char* why = gives_up();
    if (!why && events_.step(t_end)) {
      shown_ = false;
      return true;
    }
    pass_on(why ? why : events_.failure());
  }
  if (!stepping_.step(t_end)) {
    failure_ = stepping_.failure();
    if (!times_.reasons().empty())
      failure_ += fmt::format(" (time stepping since {:.9g} s: {})", times_.since(), times_.reasons());
    return false;
  }
  shown_ = true;
  if (stepped_) stepped_->end_step(stepping_.moreau(), stepping_.t_old());
  stepping_.work().stepped += stepping_.t() - stepping_.t_old();
  if (times_.calm(stepping_.t(), stepping_.calm_since())) {
    return_to_events();
  } else if (!stepping_.impact_next() && costs_.stepping_costs_more(progress())) {
    return_to_events();
    costs_.begin_trial();
  }
  return true;
}

/// Time stepping takes over at the state where the event-driven scheme gave up.
void AutomaticStepper::pass_on(const std::string& why) {
  costs_.end_events(progress());
  const auto from = events_.hand_over();
  stepping_.take_over(from, *log_);
  if (stepped_) stepped_->take_over(from, events_.dynamics(), events_.variation());
  if (watching_) in_impact_.add(1, events_.before());
  steps_ = true;
  costs_.begin({from.state.t, from.work.factorisations});
  times_.take_over(from.state.t, why, events_.time_scale());
  stepping_.work().handovers = times_.count();
}

void AutomaticStepper::return_to_events() {
  if (stepped_) {
    stepped_->finish();
    events_.variation().continue_from(*stepped_);
  }
  events_.take_over(stepping_.hand_over());
  steps_ = false;
  costs_.begin({stepping_.t(), events_.work().factorisations});
  times_.give_back(stepping_.t());
  shrinkage_.begin(events_.t(), events_.events());
}

void AutomaticStepper::add_notes(std::vector<std::string>& notes) const {
  events_.add_notes(notes);
  if (times_.count() == 0) return;
  stepping_.add_notes(notes);
  notes.push_back(diagnostic<Diagnostic::handover>(
      times_.count(), work().stepped, times_.longest(steps_ ? stepping_.t() - times_.since() : 0),
      times_.reasons()));
  if (costs_.trials() > 0)
    notes.push_back(diagnostic<Diagnostic::handover_trials>(costs_.trials(), costs_.won()));
  if (times_.longest() > 0) notes.push_back(diagnostic<Diagnostic::handover_tolerance>(after_));
}

}  // namespace freeplay
