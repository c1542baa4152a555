// PredictedGrowth: the growth of a volume of all own coordinates along an event-driven motion, without
// tangent vectors. Without applied forces that depend on velocities or first-order states, the motion
// preserves the volume of u (Liouville), since M δv and δq are conjugate. Therefore
//
//     d ln|V|/dt = tr(Zᵀ ∂F/∂v Z) + tr(∂ż/∂z)                     within a mode,
//     ln|V⁺/V⁻| = ln|det(∂v⁺/∂v⁻)| + Σ ln|ġ⁺/ġ⁻|                  at an impact,
//
// the sum over the contacts in impact, and ln|ü⁺/ü⁻| where the sliding u of a joint with friction is
// reversed. For a frictionless impact of one contact the second line is 2 ln e. The logarithms do not exist
// while contacts last, where the motion has fewer coordinates. tangent_run.hpp compares them with tangent
// vectors.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "formulations/event_driven/variation.hpp"
#include "formulations/variation/own_coordinates.hpp"

namespace freeplay {

class EventDriven;

/// Whether the mode has fewer coordinates than the constraints leave.
bool reduces_coordinates(const EventDynamics& d);

class PredictedGrowth {
 public:
  /// Logarithms of the growth so far.
  struct Logs {
    double flow = 0, impacts = 0;
    std::string unknown;  ///< why they do not exist; empty if they do
  };
  /// From a mode on. `restitution`: of each contact; `traced`: null, or with as many parameters as own
  /// coordinates.
  PredictedGrowth(const OwnCoordinates& own, std::vector<double> restitution, const EventDriven& scheme,
                  std::shared_ptr<SystemTangent> traced);
  const Logs& logs() const { return logs_; }
  /// Before and after a step.
  void begin_step(const EventDynamics& mode) { take_varied_mode(*probe_, mode); }
  void end_step(const EventDriven& scheme);
  /// At an event, with the mode after it; see Variation::on_event.
  void cross_event(const EventDynamics& d, const Variation::ProcessedEvent& passed);

 private:
  using Vector = std::vector<double>;
  double divergence(const Vector& x, double t);
  void cross_impact(const EventDynamics& d, const Variation::ProcessedEvent& p,
                    const std::vector<int>& onsets);
  void leave_unknown(const std::string& reason) {
    if (logs_.unknown.empty()) logs_.unknown = reason;
  }

  const OwnCoordinates& own_;
  std::vector<double> restitution_;
  std::unique_ptr<EventDynamics> probe_;  // in the mode of the last step
  const System& system_;
  bool dissipates_;
  Logs logs_;
};

}  // namespace freeplay
