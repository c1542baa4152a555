// The contact problem of one step. Of every active contact and friction element, with b the rates at the end
// of a step without their impulses and D = WᵀAW the Delassus matrix (A: forces to accelerations, constraints
// kept):
//
//     u⁺ = D P + b
//     0 ≤ u_N⁺ + e u_N⁻ ⊥ P_N ≥ 0,                      (Newton; e acts on approach only)
//     −P_T ∈ μ P_N Sgn(u_T⁺)  or, preloaded,  −P_T ∈ B Sgn(u_T⁺).
//
// As a linear complementarity problem (Glocker, Set-Valued Force Laws, 2001): with P_T = P_R − μP_N and
// u_T = u_R − u_L the unknowns are z = (P_N, P_R, u_L) and w = (u_N⁺ + e u_N⁻, u_R, P_L = 2μP_N − P_R). One
// contact alone, or one friction element alone, is solved in closed form by cases.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "numerics/lcp.hpp"

namespace freeplay {

/// One set-valued element of the problem and, after a solve, its impulses. Rows of D and b: `normal`,
/// `tangent`, −1 where there is none.
struct ContactUnknown {
  int normal = -1, tangent = -1;
  double friction = 0;  ///< μ of a contact
  double bound = 0;     ///< N s, of a preloaded joint (no normal row)
  double target_n = 0;  ///< −e u_N⁻ for an approaching contact, else 0: u_N⁺ is to be at least this
  double impulse_n = 0, impulse_t = 0;
};

class ContactProblem {
 public:
  explicit ContactProblem(bool lemke_always) : lemke_always_(lemke_always), lemke_(0) {}

  /// Makes room for this many rows of D; grows, never shrinks.
  void reserve(int rows);
  void clear() {
    unknowns.clear();
    rows = 0;
  }
  /// Solves for the impulses of `unknowns`. The residual is relative to the greatest |b| of the problem.
  LcpResult solve();

  std::vector<ContactUnknown> unknowns;
  int rows = 0;
  Eigen::MatrixXd D;
  Eigen::VectorXd b;

 private:
  bool one_contact(ContactUnknown& c) const;
  void one_preloaded(ContactUnknown& c) const;
  double residual(const ContactUnknown& c) const;
  LcpResult by_lemke();

  bool lemke_always_;
  Lemke lemke_;
  int lemke_size_ = 0;
  Eigen::MatrixXd A_;
  Eigen::VectorXd q_, z_;
};

}  // namespace freeplay
