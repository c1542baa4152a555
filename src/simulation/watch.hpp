// Connects the stepping loop with the observers: forwards events, steps and samples, and holds the
// stop token.
#pragma once

#include <span>
#include <vector>

#include "simulation/contact_log.hpp"
#include "simulation/observer.hpp"
#include "simulation/sensors.hpp"
#include "values/stop.hpp"

namespace freeplay {

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

}  // namespace freeplay
