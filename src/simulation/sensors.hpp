// The scene's instruments on a run: what each would have shown, sample by sample. They are part of a simulation,
// since their filters remember, and rest while nobody wants samples.
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

  /// `run`: stands for what runs, in the noise of its samples.
  Sensors(const std::vector<Instrument>& instruments, const Layout& layout, std::size_t coordinates,
          std::uint64_t run);
  /// Whether any measures a force.
  bool wants_forces() const { return any_force_; }
  /// Before the first step of a run that wants samples. One that goes on where the last one ended continues
  /// it; behind a rest filters start anew, and samples that nobody took are not made up for. `state`: where it begins; `end`: of the run (s).
  void begin(const State& state, double end);
  void step(const Step& step, const Sink& sink);

  template <class M>
  void remember(M& m) {
    for (auto& channel : channels_) m(channel);
    m(last_velocity_, until_);
  }

 private:
  void read(const Step& step, Channel& channel, std::size_t index, const Sink& sink);
  void feed(const Step& step, Channel& channel, std::size_t index, const Sink& sink);
  void feed_force(const Step& step, Channel& channel, std::size_t index, const Sink& sink);
  double measured(const Channel& channel, const Forces& forces) const;

  std::vector<Channel> channels_;
  std::vector<std::vector<int>> elements_;  // of each force channel, into Layout::forces
  std::vector<double> last_velocity_;       // of each channel, at the end of the last step or where it began
  double until_ = -INFINITY;                // s, end of the last step
  double end_ = 0;                          // s, of the run
  std::vector<double> q_, v_;
  Forces forces_;
  bool any_force_ = false;
};

}  // namespace freeplay
