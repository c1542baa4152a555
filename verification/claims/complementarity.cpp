// Solvers of the contact problem u = D P + b on random problems with a unique solution: the
// violation of the contact laws, evaluated here from D, b and the impulses alone, and the
// differences between solvers. Also piles of discs.
#include <cmath>

#include "verification/claims/claim.hpp"
#include "verification/support/random_contact.hpp"

namespace freeplay::verification {
namespace {

/// Greatest violation of 0 ≤ u_N − target ⊥ P_N ≥ 0 and −P_T ∈ bound·Sgn(u_T − target).
double violation(const ContactProblem& p) {
  Eigen::VectorXd P = Eigen::VectorXd::Zero(p.rows);
  for (const auto& c : p.unknowns) {
    if (c.normal >= 0) P[c.normal] = c.impulse_n;
    if (c.tangent >= 0) P[c.tangent] = c.impulse_t;
  }
  const Eigen::VectorXd u = p.D.topLeftCorner(p.rows, p.rows) * P + p.b.head(p.rows);
  double worst = 0;
  for (const auto& c : p.unknowns) {
    if (c.normal >= 0) worst = greatest(worst, std::abs(std::min(u[c.normal] - c.target_n, P[c.normal])));
    if (c.tangent < 0) continue;
    const double slip = u[c.tangent] - c.target_t;
    const double bound = c.bound + (c.normal >= 0 ? c.friction * P[c.normal] : 0);
    // The projection of P_T − slip onto [−bound, bound] is P_T itself.
    worst = greatest(worst, std::abs(P[c.tangent] - std::clamp(P[c.tangent] - slip, -bound, bound)));
  }
  return worst;
}

void solvers(Findings& f) {
  struct MethodName {
    LcpSolver solver;
    const char* name;
    bool newton;
  };
  constexpr MethodName ways[] = {{LcpSolver::automatic, "default solver", false},
                                 {LcpSolver::enumeration, "enumeration", false},
                                 {LcpSolver::lemke, "Lemke", false},
                                 {LcpSolver::gauss_seidel, "Gauss–Seidel", false},
                                 {LcpSolver::newton, "semismooth Newton", true}};
  constexpr int trials = 3000;
  const char* const subject = "random contact problems of 1 to 4 contacts";
  std::vector<Eigen::VectorXd> first(trials);
  for (const auto& way : ways) {
    test::Random u;
    double worst = 0, apart = 0;
    int unsolved = 0, helped = 0;
    for (int i = 0; i < trials; ++i) {
      auto p = test::random_problem(u, 1 + i % 4, true);
      const auto result = test::solve_by(way.solver, p);
      unsolved += !result.solved;
      helped += result.retries > 0;
      worst = greatest(worst, violation(p));
      Eigen::VectorXd P(2 * p.unknowns.size());
      for (std::size_t k = 0; k < p.unknowns.size(); ++k) {
        P[2 * k] = p.unknowns[k].impulse_n;
        P[2 * k + 1] = p.unknowns[k].impulse_t;
      }
      if (first[i].size() == 0) first[i] = P;
      for (Eigen::Index k = 0; k < P.size(); ++k) apart = greatest(apart, std::abs(P[k] - first[i][k]));
    }
    const std::string name = way.name;
    f.at_most(claim_name(subject,
                         way.newton ? "problems of 3000 unsolved"
                                    : "problems of 3000 unsolved or solved by a fallback",
                         name),
              "", unsolved + (way.newton ? 0 : helped), 0, "every problem is solvable",
              way.newton ? "exact; a fallback is allowed, since the method has no guarantee" : "exact");
    f.at_most(claim_name(subject, "greatest violation of the contact laws", name), "", worst, 1e-9,
              "0, impulses and rates of order one",
              "solutions are accepted below 1e-10 of the greatest rate");
    if (way.solver == LcpSolver::automatic) continue;  // the reference of the comparison
    f.at_most(claim_name(subject, "greatest difference of impulses to the default solver", name), "", apart,
              1e-8, "0: the solution is unique",
              "violation over the least eigenvalue of D, 0.3, margin of three");
  }
}

}  // namespace

Parts complementarity() { return {solvers, piles}; }

}  // namespace freeplay::verification
