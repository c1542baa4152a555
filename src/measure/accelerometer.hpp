// An accelerometer as a second-order Butterworth low-pass on the acceleration along its axis,
//
//     ÿ + √2 ω_c ẏ + ω_c² y = ω_c² a(t),        ω_c = 2π · bandwidth.
//
// Over a piece of length h the acceleration enters as its mean (v₁ − v₀)/h, for which the filter's solution
// is closed: with σ = ω_c/√2 and z = y − a,  z(h) = e^(−σh) [z₀ cos σh + (ż₀ + σ z₀)/σ sin σh]. Smooth motion
// and impulses enter in the same way, so the signal of either formulation is the same functional of its
// velocities.
#pragma once

#include "model/scene.hpp"

namespace freeplay {

class LowPass {
 public:
  explicit LowPass(double bandwidth);
  /// Starts in equilibrium with a constant input.
  void reset(double input);
  /// Advances by h with the mean input a.
  void advance(double h, double a);
  /// An impulse of the input: a(t) = dv·δ(t) raises ẏ by ω_c² dv.
  void kick(double dv) { rate_ += 2 * sigma_ * sigma_ * dv; }
  double output() const { return y_; }

 private:
  double sigma_;
  double y_ = 0, rate_ = 0;
  double h_ = -1, decay_cos_ = 1, decay_sin_ = 0;  // e^(−σh) cos σh and sin σh of the last h
};

/// The channel of one instrument: fed with velocity increments, it gives samples at multiples of its period.
class AccelerometerChannel {
 public:
  explicit AccelerometerChannel(const Accelerometer& settings);
  const Accelerometer& settings() const { return settings_; }
  /// Longest piece that the mean acceleration stands for (s): a tenth of the sampling period.
  double longest_piece() const { return 0.1 / settings_.sampling; }
  double next_sample() const { return static_cast<double>(index_) / settings_.sampling; }
  /// Velocity along the axis from the full velocity vector.
  double velocity(const double* v) const;
  /// Advances to t1; returns true when a sample is due there and moves on to the next.
  bool feed(double t0, double t1, double v0, double v1);
  /// A jump of the velocity between two pieces.
  void jump(double dv) {
    if (started_) filter_.kick(dv);
  }
  double output() const { return filter_.output(); }

 private:
  Accelerometer settings_;
  LowPass filter_;
  long index_ = 1;
  bool started_ = false;
};

}  // namespace freeplay
