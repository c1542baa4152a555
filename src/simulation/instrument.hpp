// What a sensor would have shown. An accelerometer is a Butterworth low-pass of order n on the acceleration
// along its axis: in partial fractions, with its poles p_k = ω_c e^(iπ(2k+n−1)/(2n)) and residues r_k,
//
//     ż_k = p_k z_k + a(t),     y = Σ r_k z_k,     ω_c = 2π · bandwidth.
//
// Over a piece of length h the acceleration enters as its mean (v₁ − v₀)/h, for which each mode's solution is
// closed; an impulse a(t) = dv·δ(t) raises every z_k by dv. So smooth motion and impulses enter in the same
// way, and the signal of either formulation is the same functional of its velocities.
//
// A load cell and a torque sensor take the force (N) or torque (N m) of a joint or drive in the place of a(t), and
// impulses in that of dv.
//
// The filter starts in equilibrium with the smooth motion that the first step shows: impacts that come before it or
// within it are impulses like all others, and no part of what was there before.
//
// An LVDT shows a displacement of a body along its axis, an encoder the angle of a joint in whole counts.
//
// Noise is added to a sample as a sensor adds it, before the converter, whose codes are the whole multiples k·Δ of its
// resolution with |k Δ| ≤ range: k = ⌊x/Δ⌋, at most the last code on either side. Without a resolution it clips at ± range.
//
// The noise is white and normal, each sample's from a counter alone (Steele, Lea and Flood, OOPSLA 2014). The counter
// begins where seed, channel and run are mixed to 64 bits: no two channels, starts or runs share one.
#pragma once

#include <array>
#include <complex>
#include <cstdint>

#include "dynamics/instruments.hpp"

namespace freeplay {

class LowPass {
 public:
  static constexpr int highest_order = 8;
  explicit LowPass(double bandwidth, int order = 2);
  /// Starts in equilibrium with a constant input.
  void reset(double input);
  /// Advances by h with the mean input a.
  void advance(double h, double a);
  /// An impulse of the input.
  void kick(double dv) {
    for (int k = 0; k < modes_; ++k) z_[k] += dv;
  }
  double output() const;
  /// Its modes; poles and gains are made anew.
  template <class M>
  void remember(M& m) {
    m.raw(z_.data(), sizeof z_);
    m.raw(decay_.data(), sizeof decay_);
    m.raw(gain_.data(), sizeof gain_);
    m(h_);
  }

 private:
  using Complex = std::complex<double>;
  int modes_ = 0;  // poles of the upper half plane, and the real one of an odd order
  std::array<Complex, (highest_order + 1) / 2> pole_, residue_, z_, decay_, gain_;
  double h_ = -1;  // that decay_ and gain_ belong to
};

/// One instrument's samples at multiples of its period. Accelerometers are fed piece by piece, the others are
/// given what they measure at each sample.
class Channel {
 public:
  /// `run`: stands for what runs, in the noise.
  explicit Channel(const Instrument& settings, std::uint64_t run = 0);
  const Instrument& settings() const { return settings_; }
  /// Divides a step into pieces that end at its samples and are not longer than longest_piece(): each(t, to).
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
  /// Longest piece that the mean acceleration stands for (s): a tenth of the sampling period.
  double longest_piece() const { return 0.1 / settings_.sampling; }
  /// A piece that ends so near to a sample (s) ends at it: a billionth of the period.
  double near() const { return 1e-9 / settings_.sampling; }
  double next_sample() const { return static_cast<double>(index_) / settings_.sampling; }
  Sensing sensing() const { return sensing_; }
  /// What it measures of positions or velocities, before filter, noise and resolution.
  double measure(const double* x) const;
  /// What it measures of the force of an element that it watches.
  double measure(const ElementForce& force) const;
  /// Advances to t1; returns true when a sample is due there and moves on to the next.
  bool feed(double t0, double t1, double v0, double v1);
  /// A jump of the velocity between two pieces.
  void jump(double dv) {
    if (started_)
      filter_.kick(dv);
    else
      early_ += dv;
  }
  /// Goes on at t: samples before it are past; `anew`: the filter starts in equilibrium again.
  void begin(double t, bool anew);
  template <class M>
  void remember(M& m) {
    m(filter_, index_, started_, early_, stream_);
  }
  /// The present sample of a filtered channel.
  double output() const { return shown(filter_.output()); }
  /// The next sample of another instrument; moves on to the one after.
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
  double early_ = 0;  // jumps before the filter's first piece
  std::uint64_t stream_;
};

}  // namespace freeplay
