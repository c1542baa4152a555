// One planar contact: Newton's restitution with Coulomb friction on the impulses. With u⁺ = u⁻ + D
// P,
//
//     u_N⁺ = −e u_N⁻,   P_N ≥ 0,   −P_T ∈ μ P_N Sgn(u_T⁺),
//     D = [D_NN D_NT; D_NT D_TT] positive definite
//
//     stick     u_T⁺ = 0:        D P = (−(1 + e) u_N⁻, −u_T⁻),     valid if |P_T| ≤ μ P_N
//     slip s    s = sgn u_T⁺:    P_N = −(1 + e) u_N⁻/(D_NN − s μ D_NT),
//                                P_T = −s μ P_N,                   valid if s u_T⁺ > 0
//
// Slip is "reversed" when s differs from sgn u_T⁻: the coupling D_NT then outweighs the friction.
// u_T⁺ grows with P_T, so where D_NN > μ |D_NT| exactly one case is valid; elsewhere (Painlevé) the
// law may have none or several, and this throws. Newton's law with coupling may add energy (Kane),
// which is permitted here.
// Sign convention: u_N the rate of the gap, negative before an impact; P_N pushes apart; P_T acts
// along the direction in which u_T counts. Units: m/s, N s, 1/kg.
// Source: Moreau, Unilateral contact and dry friction in finite freedom dynamics (1988); Glocker,
// Set-Valued Force Laws (2001).
#pragma once

#include <cmath>
#include <stdexcept>

namespace freeplay::reference {

template <class Real = double>
struct Delassus {
  Real nn = 0, nt = 0, tt = 0;  ///< 1/kg
};

enum class ImpactCase { none, stick, slip, reversed_slip };

template <class Real = double>
struct ObliqueImpact {
  ImpactCase kind = ImpactCase::none;  ///< none: the contact was not closing
  Real impulse_n = 0, impulse_t = 0;   ///< N s
  Real u_n = 0, u_t = 0;               ///< m/s, after the impact
};

template <class Real>
ObliqueImpact<Real> oblique_impact(const Delassus<Real>& d, Real u_n, Real u_t, Real restitution,
                                   Real friction) {
  using std::abs;
  if (u_n >= 0) return {ImpactCase::none, 0, 0, u_n, u_t};
  if (!(d.nn > friction * abs(d.nt) && d.nn * d.tt > d.nt * d.nt)) {
    throw std::invalid_argument("oblique_impact: need D positive definite and D_NN > μ |D_NT|");
  }
  const Real closing = -(1 + restitution) * u_n;
  const auto with = [&](ImpactCase kind, Real p_n, Real p_t, Real slide) {
    return ObliqueImpact<Real>{kind, p_n, p_t, -restitution * u_n, slide};
  };
  if (friction == 0) return with(ImpactCase::slip, closing / d.nn, 0, u_t + d.nt * closing / d.nn);
  const Real determinant = d.nn * d.tt - d.nt * d.nt;
  const Real stick_n = (d.tt * closing + d.nt * u_t) / determinant;
  const Real stick_t = (-d.nn * u_t - d.nt * closing) / determinant;
  if (abs(stick_t) <= friction * stick_n) return with(ImpactCase::stick, stick_n, stick_t, 0);
  for (const int s : {1, -1}) {
    const Real p_n = closing / (d.nn - s * friction * d.nt), p_t = -s * friction * p_n;
    const Real slide = u_t + d.nt * p_n + d.tt * p_t;
    if (s * slide > 0) {
      return with(s * u_t < 0 ? ImpactCase::reversed_slip : ImpactCase::slip, p_n, p_t, slide);
    }
  }
  // at the limit between stick and slip, by rounding
  return with(ImpactCase::stick, stick_n, stick_t, 0);
}

}  // namespace freeplay::reference
