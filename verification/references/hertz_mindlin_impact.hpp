// Oblique impact on Hertz's normal force with damping and Mindlin's tangential stiffness, with
// Coulomb's bound on the whole contact (no partial slip):
//
//     F_N = K δ^{3/2} (1 + χ δ̇/v0),     k_T = κ (3/2) K √δ   (= 8 G* a, a = √(R δ)),
//     Ḟ_T = −k_T (u_T − v_s)            in loading, δ̇ ≥ 0,
//     F_T = −k_T q,  q̇ = u_T − v_s      in unloading, δ̇ < 0: rescaled
//                                       (incremental form: as in loading),
//     −F_T ∈ μ F_N Sgn(v_s),            u̇ = D F,  δ̇ = −u_N,  v0 = −u_N⁻.
//
// With y = √δ and dt = 2y dσ, all right-hand sides are polynomials in y: dy/dσ = δ̇, and the impact
// starts and ends at y = 0 without a singularity. K cancels: K = 1, D divided by D_NN and v0 = 1.
// In slip F_T = −s μ F_N and s v_s ≥ 0, with v_s = u_T + Ḟ_T/k_T in loading and
// v_s = u_T + d(F_T/k_T)/dt in unloading.
// Method: steps of order 8 in σ; transitions and the turn δ̇ = 0 by bisection to rounding.
// The rescaled form dissipates; the incremental form may gain energy (Elata and Berryman 1996).
// Sign convention: that of oblique_impact.hpp. Units: m/s, N s, 1/kg.
// Source: Mindlin and Deresiewicz, J. Appl. Mech. 20 (1953) 327; unloading: Thornton, Cummins and
// Cleary, Powder Technology 233 (2013) 30. docs/theory/tangential-compliance.md.
#pragma once

#include <array>
#include <cmath>
#include <stdexcept>

#include "verification/references/compliant_impact.hpp"
#include "verification/references/numerics.hpp"

namespace freeplay::reference {

enum class ShearUnloading { rescaled, incremental };

/// `damping` is χ. `step` is that of σ, where the impact lasts about 3.
template <class Real>
CompliantImpact<Real> hertz_mindlin_impact(const Delassus<Real>& d, Real u_n, Real u_t, Real damping, Real mu,
                                           Real kappa, ShearUnloading form = ShearUnloading::rescaled,
                                           Real step = Real(0.01)) {
  using State = std::array<Real, 4>;  // y, u_N, u_T, F_T in loading or its deflection F_T/k_T
  if (u_n >= 0) return {u_n, u_t, 0, 0, ""};
  const Real nt = d.nt / d.nn, tt = d.tt / d.nn;
  const CooperVerner<Real> method;
  State x{0, -1, u_t / -u_n, 0};
  bool loading = true, slip = mu == 0 || kappa * std::abs(x[2]) > mu * (1 + damping);
  int s = x[2] > 0 ? 1 : -1;
  std::string phases = slip ? (s > 0 ? "+" : "-") : "t";
  const auto normal = [&](const State& at) { return at[0] * at[0] * at[0] * (1 - damping * at[1]); };
  const auto stiffness = [&](const State& at) { return Real(1.5) * kappa * at[0]; };
  const auto scaled = [&] { return !loading && form == ShearUnloading::rescaled; };
  const auto shear = [&](const State& at) {
    return slip ? -Real(s) * mu * normal(at) : scaled() ? stiffness(at) * at[3] : at[3];
  };
  const auto rate = [&](Real, const State& at) {
    const Real fn = normal(at), ft = shear(at), dt = 2 * at[0];
    return State{-at[1], dt * (fn + nt * ft), dt * (nt * fn + tt * ft),
                 slip ? 0 : -dt * at[2] * (scaled() ? 1 : stiffness(at))};
  };
  // s v_s, with d(F_N)/dt or d(F_N/k_T)/dt in closed form.
  const auto sliding = [&](const State& at) {
    const Real y = at[0], bracket = 1 - damping * at[1], fn = normal(at);
    const Real acceleration = fn * (1 - Real(s) * mu * nt);  // u̇_N
    const Real power = scaled() ? 2 : 3;  // F_N/k_T ~ y² in unloading, F_N ~ y³ in loading
    const Real bound = -power / 2 * at[1] * bracket - y * y * damping * acceleration;  // −d(F_N)/dt
    return Real(s) * at[2] - mu * bound / (Real(1.5) * kappa);
  };
  const auto margin = [&](const State& at, int side) { return mu * normal(at) + Real(side) * shear(at); };
  for (int i = 0;; ++i) {
    if (i > 100000) throw std::runtime_error("hertz_mindlin_impact: no separation");
    const State from = x;
    int side = 0;
    enum { none, end, turn, start, stop } event = none;
    const auto found = [&](const State& at) {
      if (!loading && at[0] <= 0) return end;
      if (loading && at[1] >= 0) return turn;
      if (slip && mu > 0 && sliding(at) < 0) return stop;
      if (!slip) {
        for (const int trial : {1, -1}) {
          if (margin(at, trial) < 0) {
            side = trial;
            return start;
          }
        }
      }
      return none;
    };
    Real low = 0, high = step;
    x = method.step(rate, 0, from, high);
    event = found(x);
    if (event == none) continue;
    for (int k = 0; k < 80; ++k) {
      const Real middle = (low + high) / 2;
      x = method.step(rate, 0, from, middle);
      const auto here = found(x);
      if (here == none)
        low = middle;
      else
        high = middle, event = here;
    }
    x = method.step(rate, 0, from, event == start || event == end ? low : high);
    if (event == end) break;
    const Real force = event == start ? -Real(side) * mu * normal(x) : shear(x);
    if (event == turn) x[1] = 0, loading = false;
    if (event == start) slip = true, s = side;
    if (event == stop) slip = false;
    x[3] = scaled() ? force / stiffness(x) : force;
    if (!slip && event == stop) {  // leave the bound by rounding only
      x[3] *= 1 - 64 * std::numeric_limits<Real>::epsilon();
    }
    phases += event == turn ? '|' : slip ? (s > 0 ? '+' : '-') : 't';
  }
  const Real v0 = -u_n, n = x[1] * v0 - u_n, t = x[2] * v0 - u_t, determinant = d.nn * d.tt - d.nt * d.nt;
  return {x[1] * v0, x[2] * v0, (d.tt * n - d.nt * t) / determinant, (d.nn * t - d.nt * n) / determinant,
          phases};
}

}  // namespace freeplay::reference
