// VariedPeaks: peaks of the signals of instruments, the greatest |y| of a run, with derivatives. A signal is
// a linear function of the positions, or an acceleration a through the low-pass of the instrument
// (simulation/instrument.hpp). With its poles p_k and residues r_k,
//
//     ż = p z + a,    y = Σ r z,        Ṡ_z = p S_z + da/dp,
//     at an event, where the velocity jumps by Δ:  z⁺ = z⁻ + Δ,  S_z⁺ = S_z⁻ + dΔ + (ż⁻ − ż⁺) dt.
//
// At an interior peak dy/dt = 0, so that the derivative of the peak is S_y at its fixed time (envelope
// theorem). At an event it is S_y + ẏ⁻ dt, at the end of the run S_y + ẏ dT/dp. The signal is continuous in
// time, without noise and resolution. Two peaks of equal height have one-sided derivatives only.
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <string>
#include <vector>

#include "formulations/variation/sensitivity.hpp"

namespace freeplay {

class VariedPeaks {
 public:
  using Vector = std::vector<double>;
  using Complex = std::complex<double>;

  void watch(std::vector<PeakChannel> channels, std::size_t keys);
  bool any() const { return !channels_.empty(); }
  std::size_t size() const { return channels_.size(); }
  /// Longest part (s) of a step, for the quadrature of the low-passes.
  double longest() const { return longest_; }

  /// Advances the low-passes by the stages of a step.
  void advance(double h, const std::array<Vector, 6>& f, const std::array<std::vector<Vector>, 6>& slopes);
  /// A jump from x to `after`, without derivatives.
  void jump(const Vector& x, const Vector& after);
  /// Its derivatives in column c: `dx`, `dafter` along the event, which moves by dt; f before and after.
  struct Move {
    const Vector &x, &after, &dx, &dafter, &f, &f_after;
    double dt;
  };
  void jump(std::size_t c, const Move& move);
  /// S of column c changes from `before` to `after` at a fixed time.
  void change(std::size_t c, const Vector& before, const Vector& after);
  /// Adds `time` times dz/dt to column c, for S at another time.
  void shift(std::size_t c, double time, const Vector& f);

  double value(std::size_t i, const Vector& x) const;
  double rate(std::size_t i, const Vector& x, const Vector& f) const;
  double slope(std::size_t i, std::size_t c, const Vector& S) const;
  /// Whether a peak of at least |y| counts.
  bool counts(std::size_t i, double y) const { return std::abs(y) >= greatest_[i] * (1 - alike); }
  /// Whether its low-pass has not begun: it then begins in equilibrium.
  bool begins(std::size_t i) const { return channels_[i].filtered && !modes[i].started; }

  struct Peak {
    double t = 0, y = 0;
    Vector slope;  ///< of y
    std::vector<std::string> reasons;
  };
  void add(std::size_t i, Peak peak);
  /// The peak of a channel, with derivatives of |y|; without one where there is a reason.
  Peak greatest(std::size_t i) const;

  struct Modes {
    std::vector<Complex> z;
    std::vector<std::vector<Complex>> S;  ///< of each column
    bool started = false;
  };
  /// State of the low-passes, to repeat a step.
  std::vector<Modes> modes;
  /// Rates of the signals at the last point that was looked at; NaN: none.
  Vector last_rates;

 private:
  /// Relative difference of peaks of equal height.
  static constexpr double alike = 1e-9;
  double along(std::size_t i, const double* values) const;

  std::vector<PeakChannel> channels_;
  std::vector<std::vector<Peak>> peaks_;
  Vector greatest_;
  double longest_ = INFINITY;
};

}  // namespace freeplay
