// Sampled PID control of an inertia, solved by hand (Åström and Wittenmark, Computer-Controlled Systems,
// 3rd ed., 1997, secs. 3.2 and 8.5). Between two instants the torque on the inertia is constant, or follows
// a step with a first-order lag, so that its motion is a closed form. All in long double; no solver of the
// program is included. Units: rad, s, N m, kg m² (or m, s, N, kg).
//
// SampledPid: the output at t_k = k h for the measured place y_k,
//
//     e = s* − r round(y/r),   u = k_p e + k_d (e − e_before)/h + k_i z
//     z ← z + h e − h (u − sat u)/(k_i T)
//
// jury_limit: with a zero-order hold, 1/(J s²) has the pulse transfer function a (z + 1)/(z − 1)², a =
// h²/(2J). Under PD control, with D = k_d/h, the characteristic polynomial is
//
//     z³ + (a (k_p + D) − 2) z² + (1 + a k_p) z − a D.
//
// By Jury's criterion its roots are within the unit circle if k_p > 0, aD < 1 and k_p < 2D (1 − aD)/(1 + aD).
//
// BacklashCycle: harmonic balance 1 + N(A) C(z) G(z) = 0, z = exp(iωh), of an inertia with damping that moves
// a load without inertia, held by friction, across a backlash ±b. C is the PID law and G the pulse transfer
// function of 1/(s (J s + c)). With f = 1 − 2b/A the gain of the backlash is
//
//     N = ½ + (asin f + f √(1 − f²))/π − i (4b/(πA))(1 − b/A)
//
// (friction-controlled backlash: Gelb and Vander Velde, Multiple-Input Describing Functions, 1968, app. B).
// With harmonics up to K, x_k = −C(kω) G(kω) Y_k of the motor, where Y_k is that of the load for the whole x,
// and N = Y_1/A. Neglected harmonics ρ A, ρ = Σ |C G Y_k|/A, change the load by at most ρ A at any time (play
// has the Lipschitz constant 1), hence N by at most (4/π) ρ. This circle of N bounds the errors of ω and A
// (A. I. Mees, A. R. Bergen, IEEE Trans. Autom. Control 20 (1975) 473), to first order in ρ.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

namespace freeplay::reference {

struct SampledPid {
  using Real = long double;
  Real target = 0, kp = 0, kd = 0, ki = 0;
  Real limit = 0;     ///< 0: none
  Real tracking = 0;  ///< T, used with k_i and a limit
  Real h = 0;
  Real resolution = 0;   ///< 0: exact
  Real least_share = 1;  ///< least distance of y from a change of its rounded value, over the resolution

  Real output(Real y) {
    Real seen = y;
    if (resolution > 0) {
      const Real steps = y / resolution, below = std::floor(steps);
      least_share = std::fmin(least_share, std::fabs(steps - below - 0.5L));
      seen = resolution * (steps - below < 0.5L ? below : below + 1);
    }
    const Real e = target - seen;
    if (first) before = e;
    first = false;
    const Real u = kp * e + kd * (e - before) / h + ki * z;
    const Real kept = limit > 0 ? std::fmax(-limit, std::fmin(limit, u)) : u;
    z += h * e;
    if (limit > 0 && ki > 0) z -= h * (u - kept) / (ki * tracking);
    before = e;
    return kept;
  }

  bool first = true;
  Real z = 0, before = 0;
};

/// k_p at which an undamped inertia under PD control loses stability.
inline double jury_limit(double J, double kd, double h) {
  const double D = kd / h, aD = 0.5 * h * h / J * D;
  return 2 * D * (1 - aD) / (1 + aD);
}

/// An inertia with damping c to the ground, or with a lag of the torque; by default at rest at 0.
struct SampledRotor {
  using Real = long double;
  SampledPid pid;
  Real J = 1, c = 0, lag = 0;       ///< not both
  int delay = 0;                    ///< whole samples of the dead time
  Real rest = 0;                    ///< s, its remainder, below h
  Real x = 0, v = 0, torque = 0;    ///< torque: acting on the inertia
  Real play = 0, load = 0;          ///< with a play b > 0: the place of a load that friction holds, measured
  std::vector<double> places = {};  ///< x at t_k
  std::vector<Real> outputs = {};
  Real held = 0;

  /// Passes `samples` instants and the time of a sample after each.
  void run(int samples) {
    for (int k = 0; k < samples; ++k) {
      places.push_back(static_cast<double>(x));
      outputs.push_back(pid.output(play > 0 ? load : x));
      move(rest);
      if (const auto n = outputs.size(); n > static_cast<std::size_t>(delay))
        held = outputs[n - 1 - static_cast<std::size_t>(delay)];
      // Within a part of a sample x changes its direction by less than 1e-4 of its way in a sample.
      const int parts = play > 0 ? 200 : 1;
      for (int i = 0; i < parts; ++i) {
        move((pid.h - rest) / static_cast<Real>(parts));
        if (play > 0) load = std::clamp(load, x - play, x + play);
      }
    }
  }

  void move(Real t) {
    const Real u = held;
    if (c > 0) {
      const Real p = c / J, decay = -std::expm1(-p * t), end = u / c;
      x += end * t + (v - end) * decay / p;
      v += (end - v) * decay;
    } else {
      const Real T = lag, off = torque - u, decay = T > 0 ? -std::expm1(-t / T) : 0;
      const Real lagging = T > 0 ? off * (T * t - T * T * decay) : 0, kick = T > 0 ? off * T * decay : 0;
      x += v * t + (u * t * t / 2 + lagging) / J;
      v += (u * t + kick) / J;
      torque = T > 0 ? torque - off * decay : u;
    }
  }
};

/// Angular frequency and amplitude of a cycle about 0 from places at equal intervals h.
struct SampledCycle {
  double omega = 0, amplitude = 0;
  SampledCycle(const std::vector<double>& places, std::size_t from, double h) {
    double least = places.at(from), most = least, first = -1, last = -1;
    int zeros = 0;
    for (std::size_t k = from + 1; k < places.size(); ++k) {
      least = std::min(least, places[k]);
      most = std::max(most, places[k]);
      if (!(places[k - 1] < 0 && places[k] >= 0)) continue;
      last = h * (static_cast<double>(k) - places[k] / (places[k] - places[k - 1]));
      if (zeros++ == 0) first = last;
    }
    amplitude = 0.5 * (most - least);
    omega = zeros > 1 ? 2 * std::numbers::pi * (zeros - 1) / (last - first) : 0;
  }
};

struct BacklashCycle {
  using C = std::complex<double>;
  double J, c, b, kp, ki, kd, h;
  int harmonics = 1;  ///< K, odd, at most 15
  double omega = 0;
  double amplitude = 0;  ///< A of the first harmonic
  double peak = 0;       ///< greatest distance of the motor from 0
  double neglected = 0;  ///< ρ, of harmonics up to 15
  C shift = 0;           ///< of N by the harmonics

  /// Searches ω between two values (rad/s) at which the balance of phases differs in sign.
  void solve(double low, double high) {
    Harmonics x{};
    shift = 0;
    for (int i = 0; i < (harmonics > 1 ? 40 : 1); ++i) {
      balance(low, high);
      const auto Y = load(x);
      shift = Y[1] / amplitude - gain(amplitude);
      neglected = 0;
      for (int k = 3; k <= 15; k += 2) {
        const auto at = static_cast<std::size_t>(k);
        const C fed_back = Y[at] / needed(k * omega);
        if (k <= harmonics) x[at] = fed_back;
        if (k > harmonics) neglected += std::abs(fed_back) / amplitude;
      }
    }
  }

  /// Bounds of the relative errors of omega and peak.
  struct Errors {
    double omega = 0, peak = 0;
  };
  Errors errors(double low, double high) const {
    Errors most;
    for (int i = 0; i < 72; ++i) {
      auto other = *this;
      other.shift += std::polar(4 / std::numbers::pi * neglected, i * std::numbers::pi / 36);
      other.balance(low, high);
      most.omega = std::max(most.omega, std::abs(other.omega / omega - 1));
      most.peak = std::max(most.peak, std::abs(other.amplitude / amplitude - 1));
    }
    most.peak += neglected;
    return most;
  }

 private:
  using Harmonics = std::array<C, 16>;  ///< x = Im Σ x_k exp(ikωt)

  void balance(double low, double high) {
    const bool rises = phase(low) < 0;
    for (int i = 0; i < 100; ++i) {
      omega = 0.5 * (low + high);
      ((phase(omega) < 0) == rises ? low : high) = omega;
    }
  }
  /// Y for the motor's motion, in the second of two turns; sets peak.
  Harmonics load(const Harmonics& x) {
    constexpr int n = 4096;
    Harmonics Y{};
    double place = 0;
    peak = 0;
    for (int i = 0; i < 2 * n; ++i) {
      const C turn = std::polar(1.0, 2 * std::numbers::pi * i / n);
      std::array<C, 16> power{1};
      for (std::size_t k = 1; k < power.size(); ++k) power[k] = turn * power[k - 1];
      double motor = amplitude * turn.imag();
      for (std::size_t k = 3; k < x.size(); k += 2) motor += (x[k] * power[k]).imag();
      place = std::clamp(place, motor - b, motor + b);
      if (i < n) continue;
      peak = std::max(peak, std::abs(motor));
      for (std::size_t k = 1; k < Y.size(); k += 2) Y[k] += C(0, 2.0 / n) * place * std::conj(power[k]);
    }
    return Y;
  }
  C gain(double A) const {
    const double f = 1 - 2 * b / A;
    return {0.5 + (std::asin(f) + f * std::sqrt(1 - f * f)) / std::numbers::pi,
            -4 * b / (std::numbers::pi * A) * (1 - b / A)};
  }
  /// −1/(C G)
  C needed(double w) const {
    const C z = std::polar(1.0, w * h);
    const double p = c / J, decay = -std::expm1(-p * h);
    // x⁺ = x + v (1 − e^(−ph))/p + (u/c)(h − (1 − e^(−ph))/p),   v⁺ = e^(−ph) v + (u/c)(1 − e^(−ph))
    const C speed = decay / c / (z - (1 - decay));
    const C place = (speed * decay / p + (h - decay / p) / c) / (z - 1.0);
    return -1.0 / ((kp + ki * h / (z - 1.0) + kd / h * (1.0 - 1.0 / z)) * place);
  }
  /// The difference of phases at the amplitude that fits the size.
  double phase(double w) {
    const C t = needed(w);
    double low = b, high = 1e6 * b;
    for (int i = 0; i < 200; ++i) {
      amplitude = std::sqrt(low * high);
      (std::abs(gain(amplitude) + shift) < std::abs(t) ? low : high) = amplitude;
    }
    return std::arg(t / (gain(amplitude) + shift));
  }
};

}  // namespace freeplay::reference
