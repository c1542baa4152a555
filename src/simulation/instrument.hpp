// Sensor models. An accelerometer is a Butterworth low-pass of order n on the acceleration along
// its axis, in partial fractions with its poles p_k = ω_c e^(iπ(2k+n−1)/(2n)) and residues r_k:
//
//     ż_k = p_k z_k + a(t),     y = Σ r_k z_k,     ω_c = 2π · bandwidth.
//
// Over an interval of length h the acceleration enters as its mean (v₁ − v₀)/h, for which each mode
// has a closed solution. An impulse a(t) = dv·δ(t) increases every z_k by dv. Smooth motion and
// impulses thus enter in the same way, and the signal is the same functional of the velocities for
// both formulations.
//
// A load cell or torque sensor filters the force (N) or torque (N m) of a joint or drive in place
// of a(t), and its impulses in place of dv.
//
// The filter starts in equilibrium with the smooth motion of the first step. Impacts before or
// within that step are impulses like all others.
//
// An LVDT measures the displacement of a body along its axis, an encoder the angle of a joint in
// whole counts.
//
// Noise is added to a sample before the converter. The codes of the converter are the multiples k·Δ
// of its resolution with |k Δ| ≤ range: k = ⌊x/Δ⌋, clipped to the last code on either side. Without
// a resolution the sample is clipped at ± range.
//
// The noise is white and normal. Each sample's noise depends on a counter alone (Steele, Lea and
// Flood, OOPSLA 2014). The counter starts at a 64-bit hash of seed, channel and run, so that
// channels, starts and runs have different noise.
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "dynamics/instruments.hpp"
#include "simulation/observer.hpp"

namespace freeplay {

class LowPass {
 public:
  static constexpr int highest_order = 8;
  explicit LowPass(double bandwidth, int order = 2);
  /// Sets the state to equilibrium with a constant input.
  void reset(double input);
  /// Advances by h (s) with the mean input a.
  void advance(double h, double a);
  /// Applies an impulse dv of the input.
  void add_jump(double dv) {
    for (int k = 0; k < modes_; ++k) z_[k] += dv;
  }
  double output() const;
  /// @name Poles of the upper half plane and the real pole, with residues; a pair has twice its own
  ///@{
  std::span<const std::complex<double>> poles() const {
    return {pole_.data(), static_cast<std::size_t>(modes_)};
  }
  std::span<const std::complex<double>> residues() const {
    return {residue_.data(), static_cast<std::size_t>(modes_)};
  }
  ///@}
  /// Saves or restores the modes; poles and residues are computed by the constructor.
  template <class M>
  void serialize(M& m) {
    m.raw(z_.data(), sizeof z_);
    m.raw(decay_.data(), sizeof decay_);
    m.raw(gain_.data(), sizeof gain_);
    m(h_);
  }

 private:
  using Complex = std::complex<double>;
  /// Sets decay_ and gain_ for steps of h (s).
  void prepare(double h);

  int modes_ = 0;  // poles of the upper half plane, and the real pole of an odd order
  std::array<Complex, (highest_order + 1) / 2> pole_, residue_, z_, decay_, gain_;
  double h_ = -1;  // step for which decay_ and gain_ are valid
  // Those of the last lengths, which return in each step of a run with fixed steps.
  struct Prepared {
    double h = -1;
    std::array<Complex, (highest_order + 1) / 2> decay, gain;
  };
  std::array<Prepared, 4> prepared_;
  std::size_t oldest_ = 0;
};

/// Samples of one instrument at multiples of its sampling period. Filtered channels are advanced
/// interval by interval; the others take the measured value at each sample.
class Channel {
 public:
  /// `run` identifies the run in the noise.
  explicit Channel(const Instrument& settings, std::uint64_t run = 0);
  const Instrument& settings() const { return settings_; }
  /// Divides a step into intervals that end at samples and are no longer than longest_piece():
  /// each(t, to).
  template <class Each>
  void pieces(double t, double t_end, Each&& each) const {
    const double longest = longest_piece() * (1 + 1e-6);
    while (t < t_end) {
      double to = t_end - t > longest ? t + longest : t_end;
      if (const double due = next_sample(); due > t + near() && due < to - near()) to = due;
      each(t, to);
      t = to;
    }
  }
  /// Longest interval (s) over which the mean acceleration is used: a tenth of the sampling period.
  double longest_piece() const { return 0.1 / settings_.sampling; }
  /// An interval that ends within this time (s) of a sample ends at the sample: a billionth of the
  /// period.
  double near() const { return 1e-9 / settings_.sampling; }
  double next_sample() const { return static_cast<double>(index_) / settings_.sampling; }
  Sensing sensing() const { return sensing_; }
  /// The measured function of positions or velocities, or component of the force of an element, before
  /// filter, noise and resolution.
  double measure(const auto& x) const {
    double value = 0;
    with_kind(settings_.kind, [&](auto kind) {
      if constexpr (requires { kind.measure(settings_, x); }) value = kind.measure(settings_, x);
    });
    return value;
  }
  /// Advances to t1. Returns true if a sample is due there, and then goes to the next sample.
  bool feed(double t0, double t1, double v0, double v1);
  /// Applies a jump of the velocity between two intervals.
  void jump(double dv) {
    if (started_)
      filter_.add_jump(dv);
    else
      early_ += dv;
  }
  /// Continues at t and skips earlier samples. `anew`: the filter starts in equilibrium again.
  void begin(double t, bool anew);
  template <class M>
  void serialize(M& m) {
    m(filter_, index_, started_, early_, stream_);
  }
  /// The present sample of a filtered channel.
  double output() const { return shown(filter_.output()); }
  /// The sample of an unfiltered channel; goes to the next sample.
  double take(double reading) {
    const double value = shown(reading);
    ++index_;
    return value;
  }

 private:
  double shown(double value) const;

  Instrument settings_;
  Sensing sensing_;
  LowPass filter_;
  long index_ = 1;
  bool started_ = false;
  double early_ = 0;  // jumps before the first interval
  std::uint64_t stream_;
};

/// The instruments of a scene during a run: computes their samples. They belong to the simulation,
/// because their filters have a state. They are inactive if no observer requests samples.
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
