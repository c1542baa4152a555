// Inertias under feedback control, solved by hand.
//
//     e = s* − s,   u = k_p e + k_d ė + k_i z,   ż = e − (u − sat u)/(k_i T),   τ Ṁ = sat u − M
//
// LinearResponse: without a limit, the sum of exponentials c_i exp(p_i t) of a characteristic
// polynomial of degree 2 or 3 (roots by Cardano's formula).
//
// SwitchedAxis: a motor and a load with a dead zone ±b of stiffness k between them, or with rigid
// stops without restitution, under control with a limit. Between two switches (demand at its limit,
// flank of the backlash reached or left) the system is linear with constant coefficients; its
// solution is the exponential series
//
//     y(t₀ + t) = y + Σ dₖ tᵏ/k!,   d₁ = A y + b,   dₖ₊₁ = A dₖ,
//
// summed to rounding in long double. A switch is bisected on the length of the series. No solver of
// the program is included. Units: rad, s, N m, kg m² (or m, s, N, kg).
//
// DescribingFunction: harmonic balance of the dead zone. Its gain at the relative amplitude A is
// N(A) = 1 − (2/π)(asin(b/A) + (b/A) √(1 − (b/A)²)); Gelb and Vander Velde, Multiple-Input
// Describing Functions (1968), table A.1. With a controller that feeds back the load, the
// characteristic polynomial with the coupling κ = N k,
//
//     J₁J₂ s⁴ + (J₁c₂ + J₂c₁) s³ + (κ(J₁ + J₂) + c₁c₂) s² + κ(c₁ + c₂ + k_d) s + κ k_p,
//
// has roots ±iω if ω² = κ r, r = (c₁ + c₂ + k_d)/(J₁c₂ + J₂c₁), κ = (c₁c₂ r − k_p)/(J₁J₂r² − (J₁ +
// J₂) r).
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace freeplay::reference {

/// x(t) of a linear equation of second or third order, by the distinct roots of its characteristic
/// polynomial.
class LinearResponse {
 public:
  using C = std::complex<double>;
  /// x″ + a x′ + b x = 0
  static LinearResponse second(double a, double b, double x0, double v0) {
    const C root = std::sqrt(C(a * a / 4 - b));
    LinearResponse r;
    r.p_ = {-a / 2 + root, -a / 2 - root};
    r.c_ = {(v0 - r.p_[1] * x0) / (r.p_[0] - r.p_[1]), (r.p_[0] * x0 - v0) / (r.p_[0] - r.p_[1])};
    return r;
  }
  /// x‴ + a x″ + b x′ + c x = 0
  static LinearResponse third(double a, double b, double c, double x0, double v0, double w0) {
    // x = y − a/3: y³ + 3 p y + 2 q = 0
    const C p = b / 3 - a * a / 9, q = a * a * a / 27 - a * b / 6 + c / 2,
            root = std::sqrt(q * q + p * p * p);
    const C u = std::pow(std::abs(-q + root) > std::abs(-q - root) ? -q + root : -q - root, 1.0 / 3);
    const C turn(-0.5, std::sqrt(0.75));
    LinearResponse r;
    for (const C w : {C(1), turn, turn * turn}) r.p_.push_back(u * w - p / (u * w) - a / 3);
    for (int i = 0; i < 3; ++i) {  // the inverse of Vandermonde's matrix
      const C x = r.p_[i], y = r.p_[(i + 1) % 3], z = r.p_[(i + 2) % 3];
      r.c_.push_back((w0 - (y + z) * v0 + y * z * x0) / ((x - y) * (x - z)));
    }
    return r;
  }
  double value(double t) const { return sum(t, 0); }
  double rate(double t) const { return sum(t, 1); }
  double bend(double t) const { return sum(t, 2); }

 private:
  double sum(double t, int order) const {
    C x = 0;
    for (std::size_t i = 0; i < p_.size(); ++i) x += c_[i] * std::pow(p_[i], order) * std::exp(p_[i] * t);
    return x.real();
  }
  std::vector<C> p_, c_;
};

/// An inertia from rest at the distance e₀ from its target under a PD controller with a limit, until
/// the demand, first beyond the limit, has fallen below it, and as long as it stays within.
struct LimitedStep {
  double J, kp, kd, limit, e0;
  /// Time at which the demand reaches the limit: k_p(e₀ − ½αt²) − k_d α t = limit, α = limit/J.
  double end_of_limit() const {
    const double a = limit / J, A = 0.5 * kp * a, B = kd * a, C = limit - kp * e0;
    return (-B + std::sqrt(B * B - 4 * A * C)) / (2 * A);
  }
  double error(double t) const {
    const double t1 = end_of_limit(), a = limit / J;
    if (t <= t1) return e0 - 0.5 * a * t * t;
    return LinearResponse::second(kd / J, kp / J, e0 - 0.5 * a * t1 * t1, -a * t1).value(t - t1);
  }
};

/// Motor (inertia J₁, damping c₁ to the ground) and load (J₂, c₂) with backlash ±b, the motor under
/// control of the load's place (or its own) with target 0.
struct SwitchedAxis {
  using Real = long double;
  Real J1 = 1, J2 = 1, c1 = 0, c2 = 0;
  Real kp = 0, kd = 0, ki = 0;
  Real limit = 0;       ///< 0: none
  Real tracking = 0;    ///< T, used with k_i and a limit
  Real lag = 0;         ///< τ; 0: none
  Real k = 0, b = 0;    ///< dead zone; k = 0: no coupling
  bool rigid = false;   ///< stops at ±b without restitution in place of the stiffness
  bool at_load = true;  ///< whether the load's place is fed back, or the motor's

  static constexpr int size = 6;  ///< s₁, v₁, s₂, v₂, z, M
  using State = std::array<Real, size>;
  /// Longest length of a series (s).
  Real longest = 1e-3L;
  int switches = 0, impacts = 0;

  Real demand(const State& y) const { return -kp * y[at_load ? 2 : 0] - kd * y[at_load ? 3 : 1] + ki * y[4]; }
  /// Advances y by T.
  State run(State y, Real T) {
    start(y);
    return advance(y, T);
  }
  /// Likewise after an earlier call, on the flank where that one ended. Without gains and with an infinite
  /// lag, y[5] is a constant torque on the motor.
  State advance(State y, Real T) {
    Real t = 0;
    while (t < T) {
      const Real h = std::fmin(longest, T - t);
      State end = series(y, h);
      if (!wrong(end)) {
        y = end;
        t += h;
        continue;
      }
      Real low = 0, high = h;  // wrong at `high`
      for (int i = 0; i < 200 && low + (high - low) / 2 > low && low + (high - low) / 2 < high; ++i) {
        const Real middle = low + (high - low) / 2;
        (wrong(series(y, middle)) ? high : low) = middle;
      }
      y = series(y, high);
      t += high;
      change(y);
    }
    return y;
  }

 private:
  int saturated_ = 0, flank_ = 0;  // side of the limit, and of the backlash, that acts

  Real gap(const State& y, int side) const { return b - side * (y[0] - y[2]); }
  static int side_of(Real x, Real border) { return x > border ? 1 : x < -border ? -1 : 0; }
  void start(const State& y) {
    saturated_ = limit > 0 ? side_of(demand(y), limit) : 0;
    flank_ = side_of(y[0] - y[2], b);
  }
  /// The force between motor and load, on the load, in rigid contact.
  Real contact(const State& y) const {
    const State d = rates(y);
    return J2 * d[3] + c2 * y[3];
  }
  bool wrong(const State& y) const {
    if (limit > 0 && side_of(demand(y), limit) != saturated_) return true;
    if (rigid) return flank_ == 0 ? gap(y, 1) < 0 || gap(y, -1) < 0 : flank_ * contact(y) < 0;
    return k > 0 && side_of(y[0] - y[2], b) != flank_;
  }
  /// Changes all modes that no longer hold at y.
  void change(State& y) {
    ++switches;
    if (limit > 0) saturated_ = side_of(demand(y), limit);
    if (!rigid) {
      flank_ = side_of(y[0] - y[2], b);
    } else if (flank_ == 0) {
      for (const int side : {1, -1})
        if (gap(y, side) < 0) {
          flank_ = side;
          ++impacts;
          y[1] = y[3] = (J1 * y[1] + J2 * y[3]) / (J1 + J2);
          if (limit > 0) saturated_ = side_of(demand(y), limit);  // of the speeds after the impact
          break;
        }
    } else if (flank_ * contact(y) < 0) {
      flank_ = 0;
    }
  }
  /// A y + b of the present modes; `constant`: whether with b.
  State rates(const State& y, bool constant = true) const {
    const Real one = constant ? 1 : 0;
    const Real u = demand(y), held = saturated_ != 0 ? saturated_ * limit * one : u;
    const Real M = lag > 0 ? y[5] : held;
    State d{};
    d[0] = y[1];
    d[2] = y[3];
    if (rigid && flank_ != 0) {
      d[1] = d[3] = (M - c1 * y[1] - c2 * y[3]) / (J1 + J2);
    } else {
      const Real F = flank_ != 0 ? k * (y[0] - y[2] - flank_ * b * one) : 0;
      d[1] = (M - c1 * y[1] - F) / J1;
      d[3] = (F - c2 * y[3]) / J2;
    }
    if (ki > 0) d[4] = -y[at_load ? 2 : 0] - (limit > 0 ? (u - held) / (ki * tracking) : 0);
    if (lag > 0) d[5] = (held - y[5]) / lag;
    return d;
  }
  State series(const State& y, Real h) const {
    State sum = y, term = rates(y);
    for (auto& x : term) x *= h;
    for (int n = 2; n < 60; ++n) {
      Real most = 0;
      for (int i = 0; i < size; ++i) {
        sum[i] += term[i];
        most = std::fmax(most, std::fabs(term[i]));
      }
      if (most < 1e-25L) break;
      term = rates(term, false);
      for (auto& x : term) x *= h / n;
    }
    return sum;
  }
};

/// Limit cycle of a SwitchedAxis with a dead zone, PD control of the load, without limit and lag.
struct DescribingFunction {
  double coupling = 0;   ///< κ; 0: no limit cycle
  double omega = 0;      ///< rad/s
  double amplitude = 0;  ///< of s₁ − s₂
  double load_amplitude = 0;

  explicit DescribingFunction(const SwitchedAxis& a) {
    const auto J1 = static_cast<double>(a.J1), J2 = static_cast<double>(a.J2), c1 = static_cast<double>(a.c1),
               c2 = static_cast<double>(a.c2), kp = static_cast<double>(a.kp), kd = static_cast<double>(a.kd),
               k = static_cast<double>(a.k), b = static_cast<double>(a.b);
    const double r = (c1 + c2 + kd) / (J1 * c2 + J2 * c1);
    coupling = (c1 * c2 * r - kp) / (J1 * J2 * r * r - (J1 + J2) * r);
    if (!(coupling > 0 && coupling < k)) {
      coupling = 0;
      return;
    }
    omega = std::sqrt(coupling * r);
    double low = 1, high = 1e6;  // of A/b
    for (int i = 0; i < 200; ++i) {
      const double x = std::sqrt(low * high);
      (1 - 2 / std::numbers::pi * (std::asin(1 / x) + std::sqrt(1 - 1 / (x * x)) / x) < coupling / k ? low
                                                                                                     : high) =
          x;
    }
    amplitude = b * low;
    // J₂ s̈₂ + c₂ ṡ₂ = κ (s₁ − s₂)
    load_amplitude = coupling * amplitude / std::hypot(J2 * omega * omega, c2 * omega);
  }
};

// Closed forms of the effect of drives on a rotor of inertia J or a slider of mass m. Nothing is
// integrated numerically here.

/// DC motor on a free rotor from rest, L di/dt = U − R i − k ω, J dω/dt = k i: with p the roots of
/// L J p² + R J p + k² = 0
///     ω = (U/k) (1 + (p₂ e^{p₁t} − p₁ e^{p₂t})/(p₁ − p₂)),
///     without L: ω = (U/k)(1 − e^{−t/τ}), τ = R J/k².
struct DcSpinUp {
  double U, R, k, L, J;
  double speed(double t) const {
    if (L == 0) return U / k * -std::expm1(-t * k * k / (R * J));
    using C = std::complex<double>;
    const C root = std::sqrt(C(R * R * J * J - 4 * L * J * k * k));
    const C p1 = (-R * J + root) / (2 * L * J), p2 = (-R * J - root) / (2 * L * J);
    return U / k * (1.0 + (p2 * std::exp(p1 * t) - p1 * std::exp(p2 * t)) / (p1 - p2)).real();
  }
};

/// Kloss's formula against a constant load M < M_k, on its stable branch: s/s_k + s_k/s = 2 M_k/M,
///     s = s_k (M_k/M − √((M_k/M)² − 1)).
inline double kloss_slip(double breakdown_torque, double breakdown_slip, double load) {
  const double ratio = breakdown_torque / load;
  return breakdown_slip * (ratio - std::sqrt(ratio * ratio - 1));
}

/// PI governor on a free rotor from rest: e = Ω − ω, J ë + k_p ė + k_i e = 0, e(0) = Ω, ė(0) = −k_p
/// Ω/J, under-damped:
///     e = Ω e^{−δt} (cos wt − (δ/w) sin wt),     δ = k_p/(2J),  w² = k_i/J − δ².
inline double governed_speed(double target, double kp, double ki, double J, double t) {
  const double d = kp / (2 * J), w = std::sqrt(ki / J - d * d);
  return target * (1 - std::exp(-d * t) * (std::cos(w * t) - d / w * std::sin(w * t)));
}

/// A rise by 1 within 0 ≤ s ≤ 1: its integral, itself and its derivatives. 3-4-5: p = 10 s³ − 15
/// s⁴ + 6 s⁵; cycloidal: p = s − sin(2πs)/(2π).
struct Rise {
  double integral, value, slope, bend;
};
inline Rise polynomial_rise(double s) {
  return {s * s * s * s * (2.5 - 3 * s + s * s), s * s * s * (10 - 15 * s + 6 * s * s),
          30 * s * s * (1 - s) * (1 - s), 60 * s * (1 - s) * (1 - 2 * s)};
}
inline Rise cycloidal_rise(double s) {
  const double w = 2 * std::numbers::pi;
  return {s * s / 2 + (std::cos(w * s) - 1) / (w * w), s - std::sin(w * s) / w, 1 - std::cos(w * s),
          w * std::sin(w * s)};
}

}  // namespace freeplay::reference
