// A single contact or joint with friction, in closed form. The cases are separation, stick, then
// slip in either direction.
#include <algorithm>
#include <cmath>

#include "formulations/contact/solvers.hpp"

namespace freeplay {
namespace {

/// Relative determinant, (D_NN D_TT − D_NT²)/(D_NN D_TT), below which both rows of a contact depend
/// on one freedom.
constexpr double same_freedom = 1e-12;

}  // namespace

/// Returns false if no case is consistent (Painlevé).
bool solve_one(ContactUnknown& c, double bn, double bt, double Dnn, double Dnt, double Dtt) {
  bt -= c.target_t;
  if (c.normal < 0) {
    c.impulse_n = 0;
    c.impulse_t = std::clamp(-bt / Dtt, -c.bound, c.bound);
    return true;
  }
  bn -= c.target_n;
  c.impulse_n = c.impulse_t = 0;
  if (c.tangent < 0) {
    c.impulse_n = std::max(0.0, -bn / Dnn);
    return true;
  }
  if (c.bound > 0) {  // friction without normal force, if the contact stays open
    c.impulse_t = std::clamp(-bt / Dtt, -c.bound, c.bound);
    if (bn + Dnt * c.impulse_t >= 0) return true;
  } else if (bn >= 0) {
    return true;
  }
  const double determinant = Dnn * Dtt - Dnt * Dnt;
  const bool regular = determinant > same_freedom * Dnn * Dtt;
  const double Pn = (-bn * Dtt + bt * Dnt) / determinant, Pt = (-bt * Dnn + bn * Dnt) / determinant;
  if (regular && Pn >= 0 && std::abs(Pt) <= c.bound + c.friction * Pn) {
    c.impulse_n = Pn;
    c.impulse_t = Pt;
    return true;
  }
  // If both rows depend on one freedom, sticking is a limit of sliding: take the end with the
  // smaller impulse.
  bool found = false;
  for (double s : {1.0, -1.0}) {
    const double slope = Dnn - s * c.friction * Dnt;
    if (!(slope > (regular ? 0 : same_freedom * Dnn))) continue;
    const double P = (-bn + s * c.bound * Dnt) / slope, T = -s * (c.bound + c.friction * P);
    const double none = regular ? 0 : same_freedom * (std::abs(bt) + std::abs(Dnt * P) + std::abs(Dtt * T));
    if (P < 0 || s * (bt + Dnt * P + Dtt * T) < -none) continue;
    if (found && P > c.impulse_n * (1 - same_freedom)) {
      // friction has no effect on the motion
      if (P < c.impulse_n * (1 + same_freedom)) c.impulse_t = 0;
      continue;
    }
    c.impulse_n = P;
    c.impulse_t = T;
    found = true;
    if (regular) break;
  }
  return found;
}

bool singular_pair(const ContactEquations& p, const ContactUnknown& c) {
  if (c.normal < 0 || c.tangent < 0) return false;
  const double nn = p.D(c.normal, c.normal), tt = p.D(c.tangent, c.tangent), nt = p.D(c.normal, c.tangent);
  return nn * tt - nt * nt <= same_freedom * nn * tt;
}

SolverSummary closed_form(ContactEquations& p, double, SolverRoom&) {
  auto& c = p.unknowns.front();
  const int n = c.normal, t = c.tangent;
  return {solve_one(c, n >= 0 ? p.b[n] : 0, t >= 0 ? p.b[t] : 0, n >= 0 ? p.D(n, n) : 0,
                    n >= 0 && t >= 0 ? p.D(n, t) : 0, t >= 0 ? p.D(t, t) : 0)};
}

}  // namespace freeplay
