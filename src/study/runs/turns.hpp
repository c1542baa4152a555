// Turns of a study's runs: what a TurnMeter (measure/turns.hpp) gets of a run, and the turn of the ideal
// mechanism, to which metrics are related.
//
// Use: channels(), attach a Feed to the run, then Feed::finish() and TurnMeter::finish().
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "measure/turns.hpp"
#include "simulation/observer.hpp"
#include "study/runs/case_run.hpp"
#include "study/settings/study.hpp"

namespace freeplay {

struct Scene;

/// Indices of the study's accelerometer and position sensor in the scene's instruments, −1 if the
/// study names none. Sets the sampling rate in `rules`. Throws SceneError if the scene has no such
/// instrument.
std::pair<int, int> channels(const Study& study, const Scene& scene, TurnRules& rules);

/// White noise of a measurement's samples, by the Box–Muller transform. Equal seeds and starts give
/// equal bits.
class SampleNoise {
 public:
  SampleNoise(double size, std::uint64_t seed, int start)
      : size_(size), engine_(seed ^ (0x9e3779b97f4a7c15u * (static_cast<std::uint64_t>(start) + 1))) {
    engine_.discard(8);
  }
  double operator()() {
    if (size_ == 0) return 0;
    const auto uniform = [&] { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53; };
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return size_ * radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  double size_;
  std::mt19937_64 engine_;
};

/// Observer that passes events and the samples of two channels to a meter: of the acceleration
/// every `every`-th sample, with noise. Refers to the meter.
class Feed final : public Observer {
 public:
  Feed(TurnMeter& meter, int acceleration, int position, int every = 1, const SampleNoise& noise = {0, 0, 0})
      : meter_(meter), acceleration_(acceleration), position_(position), every_(every), noise_(noise) {}
  Wants wants() const override { return {.samples = acceleration_ >= 0 || position_ >= 0, .steps = false}; }
  void event(const Event& e) override { meter_.event(e); }
  void sample(std::size_t channel, double t, double value) override {
    if (static_cast<int>(channel) == acceleration_ && seen_++ % every_ == 0)
      meter_.acceleration(t, value + noise_());
    if (static_cast<int>(channel) == position_) meter_.position(t, value);
  }
  void end(const RunEnd& end) override {
    held_back_.assign(end.held_back.begin(), end.held_back.end());
    for (std::size_t k = 0; k < end.undecided_since.size(); ++k)
      if (!std::isnan(end.undecided_since[k])) {
        ContactEvent open;  // contact onset not yet classified as impact or lasting contact
        open.t = end.undecided_since[k];
        open.contact = static_cast<int>(k);
        open.kind = EventKind::contact;
        held_back_.push_back(open);
      }
    std::ranges::sort(held_back_, {}, &ContactEvent::t);
  }
  /// Passes the remaining events after the run, which an unclassified contact had held back.
  void finish() {
    for (const auto& e : held_back_) meter_.event(e);
  }

 private:
  TurnMeter& meter_;
  int acceleration_, position_, every_;
  long seen_ = 0;
  SampleNoise noise_;
  std::vector<ContactEvent> held_back_;
};

// Reference motion of the ideal mechanism: one turn of the crank with all clearances closed, as
// seen by the study's instruments. Metrics of runs are related to its greatest acceleration.

/// Greatest |a| (m/s²) of the ideal mechanism's turn, computed once for each combination of ideal mechanism,
/// formulation and accelerometer. NaN if the run of the ideal mechanism does not finish. Throws the error of
/// the computation: SceneError, ModelError, Interrupted.
double ideal_maximum(const Study& study, const Scene& scene, const std::string& formulation,
                     const Conduct& conduct);

/// Metrics of the ideal mechanism in one turn, which begins after the first turn when the transient
/// of the accelerometer has decayed.
TurnMetrics ideal_metrics(const Study& study, const Scene& scene, const std::string& formulation,
                          const Conduct& conduct);

}  // namespace freeplay
