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

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

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

// Oblique impact of an elastic sphere on a half-space with Coulomb friction and slip in a part of
// the contact area. The area is cut into annuli of the radii x_i; reduction to one dimension turns
// the tractions into loads of independent springs, one for each annulus:
//
//     normal load      p_i = k1 (δ − η_i)₊ (1 + χ_d δ̇/v0),  η_i = x_i²/R,
//                      Σ k1 (δ − η_i)₊ → K δ^{3/2}
//     tangential load  w_i = κ k1 q_i,  q̇_i = u_T in stick,  |w_i| ≤ μ p_i,  F_T = −Σ w_i
//     rates            u̇ = D F,  δ̇ = −u_N,  v0 = −u_N⁻
//
// Each annulus sticks or slips on its own. Without slip all of them give Mindlin's 8 G* a. The
// displacement across the direction of motion is neglected, as in the source. With
// x_i = (i − ½) a_max/n, k1 = (3/2) K √δ_max/n; K cancels.
// For a sphere without damping only χ = (1 − ν)(1 + 1/K²)/(2 − ν) = 7κ/4 matters (K² = 2/5): with
// ψ = κ u_T/(μ v0), ψ2 = f(ψ1, χ). In closed form: if ψ1 ≥ 4χ − 1 all annuli slip, and
// ψ2 = ψ1 − 4χ.
// Method: leapfrog in time and midpoints in x, both of second order; by default ψ2 is exact
// to 2e-6. A separate computation with rings of traction on the half-space, collocation of
// their displacements and slip by rings, tends to the same ψ2 with the width of the rings:
// at ν = 0.3 and ψ1 = 2, −0.8412 (40 rings) and −0.8385 (80) towards −0.8372 here.
// Source: Maw, Barber and Fawcett, Wear 38 (1976) 101, and J. Lubr. Technol. 103 (1981) 74;
// reduction: Jäger, Arch. Appl. Mech. 65 (1995) 478; Popov and Heß, Method of Dimensionality
// Reduction (2015); impact: Willert and Popov, ZAMM 96 (2016) 1089.
// docs/theory/tangential-compliance.md has the equations.
// Sign convention: that of oblique_impact.hpp; ψ2 < 0 if the contact point springs back.
// Units: m/s, N s, 1/kg.

/// `damping` is χ_d. `n` annuli up to the greatest depth without coupling; `steps` per impact.
template <class Real>
CompliantImpact<Real> annular_impact(const Delassus<Real>& d, Real u_n, Real u_t, Real damping, Real mu,
                                     Real kappa, std::size_t n = 1000, std::size_t steps = 2000) {
  if (u_n >= 0) return {u_n, u_t, 0, 0, ""};
  const Real nt = d.nt / d.nn, tt = d.tt / d.nn;
  const Real deepest = std::pow(Real(5) / 4, Real(2) / 5);  // ½ = (2/5) δ^{5/2}: K = D_NN = v0 = 1
  const Real dx = std::sqrt(deepest) / static_cast<Real>(n), stiffness = Real(1.5) * dx;
  const Real dt = Real(2.94327) * deepest / static_cast<Real>(steps);
  std::vector<Real> load(n, 0);                                // κ q_i/μ
  Real depth = 0, un = -1, ut = u_t / -u_n, acceleration = 0;  // rates at the half steps
  for (std::size_t step = 0;; ++step) {
    if (step > 100 * steps) throw std::runtime_error("annular_impact: no separation");
    const Real before = depth;
    depth -= un * dt;
    if (depth <= 0) break;
    const Real bracket = std::max(Real(0), 1 - damping * (un + acceleration * dt / 2));
    Real tangential = 0;
    for (std::size_t i = 0;; ++i) {
      const Real x = (static_cast<Real>(i) + Real(0.5)) * dx, p = depth - x * x;
      if (i >= load.size() && p <= 0) break;
      if (i >= load.size()) load.push_back(0);
      const Real touched = before < x * x ? p / (depth - before) : 1;  // part of the step
      load[i] = p <= 0 ? 0
                       : std::clamp(load[i] + kappa * ut / std::max(mu, Real(1e-12)) * touched * dt,
                                    -p * bracket, p * bracket);
      tangential -= mu * stiffness * load[i];
    }
    const Real normal = depth * std::sqrt(depth) * bracket;
    acceleration = normal + nt * tangential;
    un += acceleration * dt;
    ut += (nt * normal + tt * tangential) * dt;
  }
  const Real v0 = -u_n, a = un * v0 - u_n, b = ut * v0 - u_t, determinant = d.nn * d.tt - d.nt * d.nt;
  return {un * v0, ut * v0, (d.tt * a - d.nt * b) / determinant, (d.nn * b - d.nt * a) / determinant, ""};
}

/// ψ2 after the impact of a sphere at ψ1 for the parameter χ.
inline double maw_barber_fawcett(double psi, double chi, std::size_t n = 1000, std::size_t steps = 2000) {
  using Real = long double;
  const Real kappa = static_cast<Real>(chi) / Real(1.75);
  const Delassus<Real> sphere{1, 0, 3.5};
  const auto impact = annular_impact<Real>(sphere, -1, static_cast<Real>(psi) / kappa, 0, 1, kappa, n, steps);
  return static_cast<double>(kappa * impact.u_t);
}

}  // namespace freeplay::reference
