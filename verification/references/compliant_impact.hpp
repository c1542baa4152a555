// One planar contact with a normal and a tangential spring and Coulomb friction: the bilinear model
// of oblique impact. Phase time τ with the normal stiffness 1, forces f, rates u = (u_N, u_T):
//
//     u′ = D f,   f_N′ = −k_N u_N,   k_N = 1 on the loading line, 1/e² below the greatest force,
//     stick       f_T′ = −κ u_T                                while |f_T| ≤ μ f_N,
//     slip s      f_T = −s μ f_N,  v_s = u_T + s μ (k_N/κ) u_N  while s v_s ≥ 0.
//
// The impact ends when f_N returns to 0. The normal stiffness cancels: D, e, μ and κ matter.
// Slip is a polynomial in p = ∫ f_N dτ: u and v_s are linear and f_N² is quadratic, so all its
// events are roots in closed form. Stick is a pair of harmonic modes; first_root() finds the first
// zero of a sum of two sinusoids by lower bounds that never pass it. The works of f_N obey
// W_exp = −e² W_comp.
// A sphere has D_NN = 1/m, D_NT = 0, D_TT = 7/(2m); κ = 4 G*/E*, for equal materials
// 2(1 − ν)/(2 − ν).
// Limits: one contact; with μ |D_NT| > D_NN and e < 1e-3, e ≠ 0, it may throw for too many phases.
// Sign convention: that of oblique_impact.hpp. Units: m/s, N s, 1/kg.
// Source: Stronge, Impact Mechanics (2000), ch. 5; unloading 1/e²: Walton and Braun, J. Rheology 30
// (1986) 949; κ: Mindlin, J. Appl. Mech. 16 (1949) 259. docs/theory/tangential-compliance.md.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "verification/references/oblique_impact.hpp"

namespace freeplay::reference {

template <class Real = double>
struct CompliantImpact {
  Real u_n = 0, u_t = 0;              ///< m/s, after the impact
  Real impulse_n = 0, impulse_t = 0;  ///< N s
  /// 't' stick, '+' and '-' slip of that sign, '|' greatest compression
  std::string phases;
};

/// h(t) = c + Σ a_i cos ω_i t + b_i sin ω_i t.
template <class Real>
struct TwoSinusoids {
  Real c = 0;
  std::array<Real, 2> a{}, b{}, w{};

  Real at(Real t, int derivative = 0) const {
    Real sum = derivative == 0 ? c : 0;
    for (std::size_t i = 0; i < 2; ++i) {
      const Real cosine = std::cos(w[i] * t), sine = std::sin(w[i] * t);
      const std::array<Real, 4> turn{a[i] * cosine + b[i] * sine, b[i] * cosine - a[i] * sine,
                                     -a[i] * cosine - b[i] * sine, a[i] * sine - b[i] * cosine};
      sum += std::pow(w[i], derivative) * turn[static_cast<std::size_t>(derivative % 4)];
    }
    return sum;
  }
  Real bound(int derivative) const {
    Real sum = derivative == 0 ? std::abs(c) : 0;
    for (std::size_t i = 0; i < 2; ++i) sum += std::pow(w[i], derivative) * std::hypot(a[i], b[i]);
    return sum;
  }
  /// First t in (0, limit) at which h falls through 0; h(0) ≥ 0. Taylor's formula of order m with
  /// the bound M of the next derivative gives h > 0 on the whole step; m > 1 only where h and h′
  /// vanish. `tangent`: h(0) = h′(0) = 0 by the transition that has just taken place.
  std::optional<Real> first_root(Real limit, bool tangent) const {
    const Real tiny = 64 * std::numeric_limits<Real>::epsilon();
    Real t = 0;
    for (int i = 0; i < 100000 && t < limit; ++i) {
      const Real h = at(t), h1 = at(t, 1), m2 = bound(2);
      Real step = 0;
      if (h > tiny * bound(0) && !(tangent && i == 0)) {
        const Real root = std::sqrt(h1 * h1 + 2 * m2 * h);
        step = h1 < 0 ? 2 * h / (root - h1) : (root + h1) / m2;
      } else {
        int m = tangent && i == 0 ? 2 : 1;
        while (m < 4 && std::abs(at(t, m)) <= tiny * bound(m)) ++m;
        if (at(t, m) <= 0) return t;
        step = Real(m + 1) * at(t, m) / bound(m + 1);
      }
      if (!(step > 0)) return std::nullopt;  // h = 0 throughout
      if (h1 < 0 && step < tiny * t) return t;
      t += step;
    }
    return std::nullopt;
  }
};

template <class Real>
CompliantImpact<Real> compliant_impact(const Delassus<Real>& d, Real u_n, Real u_t, Real e, Real mu,
                                       Real kappa) {
  if (!(d.nn > 0 && d.nn * d.tt > d.nt * d.nt && e >= 0 && e <= 1 && mu >= 0 && kappa > 0)) {
    throw std::invalid_argument(
        "compliant_impact: need D positive definite, 0 <= e <= 1, mu >= 0, kappa > 0");
  }
  CompliantImpact<Real> result{u_n, u_t, 0, 0, ""};
  if (u_n >= 0) return result;
  const Real nt = d.nt / d.nn, tt = d.tt / d.nn, never = std::numeric_limits<Real>::infinity();
  Real fn = 0, ft = 0, un = u_n, ut = u_t, k = 1, greatest = 0;
  bool loading = true, slip = mu == 0 || std::abs(kappa * ut) > -mu * un;
  int s = ut > 0 ? 1 : -1;
  enum class Event { none, turn, reload, end, change } event = Event::none;
  for (int phase = 0; event != Event::end; ++phase) {
    if (phase > 1000) throw std::runtime_error("compliant_impact: more than 1000 phases");
    result.phases += slip ? (s > 0 ? '+' : '-') : 't';
    Real first = never;
    const Event last = std::exchange(event, Event::none);
    const auto candidate = [&](Real at, Event what) {
      if (at >= 0 && at < first) first = at, event = what;
    };
    if (slip) {
      const Real lambda = 1 - Real(s) * mu * nt, b = nt - Real(s) * mu * tt;
      const Real turning = Real(s) * b + mu * k * lambda / kappa,
                 sliding = Real(s) * ut + mu * k * un / kappa;
      if (mu > 0 && turning < 0) candidate(std::max(Real(0), sliding) / -turning, Event::change);
      if (loading && lambda > 0) candidate(-un / lambda, Event::turn);
      if (!loading) {  // λ p² + 2 u_N p = q at f = 0, −r at the loading line
        const Real q = fn * fn / k, r = (greatest * greatest - fn * fn) / k;
        const Real end = un * un + lambda * q, back = un * un - lambda * r;
        if (end >= 0 && un > 0) candidate(q / (un + std::sqrt(end)), Event::end);
        if (un <= 0 && lambda > 0) candidate((std::sqrt(end) - un) / lambda, Event::end);
        if (back >= 0 && un < 0) candidate(r / (std::sqrt(back) - un), Event::reload);
        if (un >= 0 && lambda < 0) candidate((std::sqrt(back) + un) / -lambda, Event::reload);
      }
      if (event == Event::none) throw std::runtime_error("compliant_impact: slip without end");
      fn = std::sqrt(std::max(Real(0), fn * fn - k * first * (2 * un + lambda * first)));
      un += lambda * first;
      ut += b * first;
      ft = -Real(s) * mu * fn;
    } else {
      const Real kn = std::sqrt(k), kt = std::sqrt(kappa);
      const Real a11 = k, a12 = kn * kt * nt, a22 = kappa * tt, angle = std::atan2(2 * a12, a11 - a22) / 2;
      const Real c = std::cos(angle), z = std::sin(angle);
      const Real large = (a11 + a22 + std::hypot(2 * a12, a11 - a22)) / 2;
      const std::array<Real, 2> w{std::sqrt(large), std::sqrt((a11 * a22 - a12 * a12) / large)};
      const std::array<Real, 2> y{c * fn / kn + z * ft / kt, c * ft / kt - z * fn / kn};
      const std::array<Real, 2> v{c * kn * un + z * kt * ut, c * kt * ut - z * kn * un};
      const auto force = [&](Real n, Real t, Real constant) {  // constant + n f_N + t f_T
        const Real g0 = n * kn * c + t * kt * z, g1 = t * kt * c - n * kn * z;
        return TwoSinusoids<Real>{
            constant, {g0 * y[0], g1 * y[1]}, {-g0 * v[0] / w[0], -g1 * v[1] / w[1]}, w};
      };
      const TwoSinusoids<Real> normal = force(1, 0, 0), tangential = force(0, 1, 0);
      const TwoSinusoids<Real> approach{
          0, {-c * v[0] / kn, z * v[1] / kn}, {-c * w[0] * y[0] / kn, z * w[1] * y[1] / kn}, w};
      const auto root = [&](const TwoSinusoids<Real>& h, Event what, bool tangent) {
        const std::optional<Real> at = h.first_root(first, tangent);
        if (at) candidate(*at, what);
        return at && *at == first;
      };
      const int held = s;
      for (const int side : {1, -1}) {
        if (root(force(mu, Real(side), 0), Event::change, last == Event::change && side == held)) s = side;
      }
      root(loading ? approach : force(-1, 0, greatest), loading ? Event::turn : Event::reload,
           last == Event::turn);
      if (event == Event::none) throw std::runtime_error("compliant_impact: stick without end");
      un = normal.at(first, 1) / -k;
      ut = tangential.at(first, 1) / -kappa;
      fn = std::max(Real(0), normal.at(first));
      ft = event == Event::change ? -Real(s) * mu * fn : tangential.at(first);
    }
    if (event == Event::change) slip = !slip;
    if (event == Event::turn) {
      result.phases += '|';
      greatest = fn, un = 0, loading = false, k = 1 / (e * e);
      if (e == 0) event = Event::end;
    }
    if (event == Event::reload) fn = greatest, loading = true, k = 1;
  }
  const Real n = un - u_n, t = ut - u_t, determinant = d.nn * d.tt - d.nt * d.nt;
  return {un, ut, (d.tt * n - d.nt * t) / determinant, (d.nn * t - d.nt * n) / determinant, result.phases};
}

}  // namespace freeplay::reference
