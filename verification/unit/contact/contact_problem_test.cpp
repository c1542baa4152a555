// Solutions of contact problems: how often Newton's method needs another, fallbacks, and problems with
// special solutions. The solvers against the contact laws and against each other on 3000 random problems,
// and runs of piles, are claims of "complementarity".
#include <catch2/catch.hpp>

#include "verification/support/random_contact.hpp"

using namespace freeplay;
using test::Random;
using test::random_problem;
using test::solve_by;

TEST_CASE("Newton's method alone solves nearly every problem", "[contact-problem]") {
  Random u;
  int alone = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    auto p = random_problem(u, 3, true);
    alone += solve_by(LcpSolver::newton, p).retries == 0;
  }
  CHECK(alone > 950);
}

TEST_CASE("a solver that fails is replaced by the next, and the retry is counted", "[contact-problem]") {
  // A chain of 100 contacts, D the second difference: Gauss–Seidel converges like (1 − π²/n²) a
  // sweep and would need some 20,000 sweeps; its limit is 2,000.
  ContactProblem p(LcpSolver::gauss_seidel);
  const int n = 100;
  p.reserve(n);
  p.rows = n;
  for (int i = 0; i < n; ++i) {
    p.D(i, i) = 2;
    if (i > 0) p.D(i, i - 1) = p.D(i - 1, i) = -1;
    p.b[i] = -1;
    ContactUnknown c;
    c.normal = i;
    p.unknowns.push_back(c);
  }
  const auto result = p.solve();
  CHECK(result.solved);
  CHECK(result.retries == 1);
  // D P = 1: P_i = i (n + 1 − i)/2.
  for (int i = 0; i < n; ++i) CHECK(p.unknowns[i].impulse_n == Approx(0.5 * (i + 1) * (n - i)));
}

TEST_CASE("Painlevé's configuration is reported, and collinear contacts are solved", "[contact-problem]") {
  // Painlevé: D_NN = 1, D_NT = 2, μ = 1, approaching and sliding to the right. The closed form
  // tries separation, stick and slip without success; P_N = −b/(D_NN − μ D_NT) < 0.
  ContactProblem p;
  p.reserve(2);
  p.rows = 2;
  p.D << 1, 2, 2, 5;
  p.b << -1, 10;
  ContactUnknown c;
  c.normal = 0;
  c.tangent = 1;
  c.friction = 0.9;
  p.unknowns.push_back(c);
  const auto result = p.solve();
  // Jamming: stick needs |P_T| ≤ μ P_N. u = 0: P = −D⁻¹b = (25, −12), within the cone. Open has
  // u_N = −1, slip to the right P_N = 1/(1 − 1.8) < 0, slip to the left P_N = 1/2.8 and u_T > 0:
  // stick is the only motion, and no other is reported.
  CHECK(result.solved);
  CHECK_FALSE(result.ambiguous);
  REQUIRE(p.modes(9).decided);
  CHECK(p.modes(9).motions.size() == 1);
  CHECK(p.unknowns[0].impulse_n == Approx(25));
  CHECK(p.unknowns[0].impulse_t == Approx(-12));

  ContactProblem q(LcpSolver::gauss_seidel);
  q.reserve(2);
  q.rows = 2;
  q.D << 1, 1, 1, 1;  // two collinear contacts with different required opening velocities: Gauss–Seidel
                      // converges slowly
  q.b << -1, -1;
  for (int i : {0, 1}) {
    ContactUnknown x;
    x.normal = i;
    x.target_n = i;
    q.unknowns.push_back(x);
  }
  const auto tie = q.solve();
  CHECK(tie.solved);
  CHECK(q.unknowns[1].impulse_n == Approx(2));
  CHECK(q.unknowns[0].impulse_n == Approx(0).margin(1e-10));
}
