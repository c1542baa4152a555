// The instruments of a scene during a run: computes their samples. They belong to the simulation,
// because their filters have a state. They are inactive if no observer requests samples.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "simulation/instrument.hpp"
#include "simulation/observer.hpp"

namespace freeplay {

class Sensors {
 public:
  using Sink = std::function<void(std::size_t channel, double t, double value)>;

  /// `run` identifies the run in the noise of the samples.
  Sensors(const std::vector<Instrument>& instruments, const Layout& layout, std::size_t coordinates,
          std::uint64_t run);
  /// Whether any instrument measures a force.
  bool wants_forces() const { return any_force_; }
  /// Call it before the first step of a run with samples. If the run starts where the last one
  /// ended, the signals continue. After a gap the filters start anew and the samples of the gap are
  /// omitted. `state`: the start of the run; `end`: its end (s).
  void begin(const State& state, double end);
  void step(const Step& step, const Sink& sink);

  template <class M>
  void serialize(M& m) {
    for (auto& channel : channels_) m(channel);
    m(last_velocity_, until_);
  }

 private:
  void read(const Step& step, Channel& channel, std::size_t index, const Sink& sink);
  void feed(const Step& step, Channel& channel, std::size_t index, const Sink& sink);
  void feed_force(const Step& step, Channel& channel, std::size_t index, const Sink& sink);
  double measured(const Channel& channel, const Forces& forces) const;

  std::vector<Channel> channels_;
  // Elements of each force channel, indices into Layout::forces.
  std::vector<std::vector<int>> elements_;
  // Of each channel, at the end of the last step or at the start.
  std::vector<double> last_velocity_;
  double until_ = -INFINITY;  // s, end of the last step
  double end_ = 0;            // s, end of the run
  std::vector<double> q_, v_;
  Forces forces_;
  bool any_force_ = false;
};

}  // namespace freeplay
