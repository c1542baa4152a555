#include "simulation/march.hpp"

#include "dynamics/families.hpp"

namespace freeplay {

Watch::Watch(const Layout& layout, Sensors& sensors, std::vector<Observer*> observers, StopToken stop)
    : layout_(layout), sensors_(sensors), observers_(std::move(observers)), stop_(stop) {
  wants_.steps = false;
  for (auto* o : observers_) {
    const auto wants = o->wants();
    wants_.forces |= wants.forces;
    wants_.samples |= wants.samples;
    wants_.steps |= wants.steps;
    if (wants.steps) of_steps_.push_back(o);
  }
  if (wants_.samples) wants_.forces |= sensors_.wants_forces();
  sink_ = [this](std::size_t channel, double t, double value) {
    for (auto* o : observers_) o->sample(channel, t, value);
  };
}

void Watch::begin(const State& state) {
  if (wants_.samples) sensors_.begin(state, layout_.end);
  for (auto* o : observers_) o->begin(layout_, state);
}

void Watch::event(const ContactEvent& e) {
  if (observers_.empty()) return;
  static_cast<ContactEvent&>(event_) = e;
  const auto k = static_cast<std::size_t>(e.contact), contacts = layout_.contacts.size();
  if (k < contacts)
    event_.joint = layout_.contacts[k];
  else
    event_.joint = pair_name(layout_.families[k - contacts], layout_.bodies, e.bodies[0], e.bodies[1]);
  for (auto* o : observers_) o->event(event_);
}

void Watch::step(const Step& step) {
  if (wants_.samples) sensors_.step(step, sink_);
  for (auto* o : of_steps_) o->step(step);
}

void Watch::end(const Ending& ending, double t, const ContactLog& log) {
  if (observers_.empty()) return;
  std::vector<double> since;
  for (std::size_t k = 0; k < layout_.contacts.size(); ++k)
    since.push_back(log.undecided_since(static_cast<int>(k)));
  for (auto* o : observers_) o->end({ending, t, log.held_back(), since});
}

}  // namespace freeplay
