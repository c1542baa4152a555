// Lemke against enumeration: for a P-matrix the solution is unique, and one of the 2ⁿ complementary
// bases has it.
#include "numerics/complementarity.hpp"

#include <catch2/catch.hpp>

#include <Eigen/Dense>
#include <optional>
#include <random>

#include "formulations/contact/contact_problem.hpp"

using namespace freeplay;

namespace {

/// Solution of w = A z + b, 0 ≤ w ⊥ z ≥ 0 by trying every complementary basis.
std::optional<Eigen::VectorXd> enumerate(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const int n = static_cast<int>(b.size());
  for (int mask = 0; mask < (1 << n); ++mask) {
    Eigen::MatrixXd basis = Eigen::MatrixXd::Identity(n, n);
    for (int i = 0; i < n; ++i)
      if (mask >> i & 1) basis.col(i) = -A.col(i);
    const Eigen::VectorXd x = basis.fullPivLu().solve(b);
    if ((basis * x - b).norm() > 1e-9 * (1 + b.norm()) || x.minCoeff() < -1e-11) continue;
    Eigen::VectorXd z = Eigen::VectorXd::Zero(n);
    for (int i = 0; i < n; ++i)
      if (mask >> i & 1) z[i] = x[i];
    return z;
  }
  return std::nullopt;
}

}  // namespace

TEST_CASE("Lemke solves random P-matrix problems of size 1 to 12 exactly", "[lcp]") {
  std::mt19937 engine(42);
  std::normal_distribution<double> g;
  for (int n = 1; n <= 12; ++n) {
    Lemke lemke(n);
    for (int trial = 0; trial < (n <= 7 ? 100 : n <= 10 ? 10 : 3); ++trial) {
      // Positive definite symmetric part makes a P-matrix; a skew part makes it unsymmetric.
      const Eigen::MatrixXd R = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return g(engine); });
      const Eigen::MatrixXd K = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return g(engine); });
      const Eigen::MatrixXd A = R * R.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n) + K - K.transpose();
      const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(n, [&] { return g(engine); });
      Eigen::VectorXd z(n);
      const auto result = lemke.solve(n, A.data(), n, b.data(), z.data());
      REQUIRE(result.status == LcpResult::Status::solved);
      const auto expected = enumerate(A, b);
      REQUIRE(expected);
      // Condition numbers of these matrices are below 1e5; the error of pivoting is that times
      // rounding.
      REQUIRE((z - *expected).norm() <= 1e-9 * (1 + expected->norm()));
      REQUIRE(result.residual < 1e-10);
    }
  }
}

TEST_CASE("Lemke solves degenerate problems or reports failure", "[lcp]") {
  std::mt19937 engine(5);
  std::uniform_int_distribution<int> small(-2, 2);
  int solved = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const int n = 1 + trial % 6;
    Lemke lemke(n);
    // Integer data of low rank: ties and singular bases are frequent.
    const int rank = std::max(1, n / 2);
    const Eigen::MatrixXd R = Eigen::MatrixXd::NullaryExpr(n, rank, [&] { return double(small(engine)); });
    const Eigen::MatrixXd A = R * R.transpose();
    const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(n, [&] { return double(small(engine)); });
    Eigen::VectorXd z(n);
    const auto result = lemke.solve(n, A.data(), n, b.data(), z.data());
    const bool solvable = enumerate(A, b).has_value();
    CAPTURE(A, b.transpose(), z.transpose(), result.residual);
    if (result.status == LcpResult::Status::solved) {
      REQUIRE(result.residual < 1e-9);
      ++solved;
    } else {
      // For a positive semidefinite matrix Lemke ends on a ray only if there is no solution.
      REQUIRE_FALSE(solvable);
    }
  }
  REQUIRE(solved > 1000);
}

TEST_CASE("the closed form of a single frictional contact equals Lemke's solution", "[lcp]") {
  std::mt19937 engine(9);
  std::uniform_real_distribution<double> u(-1, 1);
  int by_mode[4] = {0, 0, 0, 0};
  for (int trial = 0; trial < 5000; ++trial) {
    const double a = 0.2 + std::abs(u(engine)), d = 0.2 + std::abs(u(engine));
    const double off = 0.9 * std::sqrt(a * d) * u(engine), mu = 0.5 * std::abs(u(engine));
    if (mu * std::abs(off) > 0.95 * a) continue;  // Painlevé: not unique
    ContactUnknown result[2];
    const double bn = u(engine), bt = u(engine), target = 0.3 * std::abs(u(engine));
    for (bool lemke : {false, true}) {
      ContactProblem p(lemke ? LcpSolver::lemke : LcpSolver::automatic);
      p.reserve(2);
      p.rows = 2;
      p.D << a, off, off, d;
      p.b << bn, bt;
      ContactUnknown c;
      c.normal = 0;
      c.tangent = 1;
      c.friction = mu;
      c.target_n = target;
      p.unknowns.push_back(c);
      REQUIRE(p.solve().solved);
      result[lemke] = p.unknowns[0];
    }
    REQUIRE(result[0].impulse_n == Approx(result[1].impulse_n).margin(1e-12));
    REQUIRE(result[0].impulse_t == Approx(result[1].impulse_t).margin(1e-12));
    const double slip = bt + off * result[0].impulse_n + d * result[0].impulse_t;
    ++by_mode[result[0].impulse_n == 0 ? 0 : std::abs(slip) < 1e-12 ? 1 : slip > 0 ? 2 : 3];
  }
  for (int count : by_mode)
    REQUIRE(count > 100);  // separation, stick and slip in both directions all occurred
}

TEST_CASE("Lemke solves problems with frictionless and frictional contacts", "[lcp]") {
  // With μ = 0 the rows 2μP_N − P_R ≥ 0 are ties at zero at the start, and z₀ may end basic at
  // zero.
  std::mt19937 engine(77);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int trial = 0; trial < 20000; ++trial) {
    ContactProblem p(LcpSolver::lemke);
    p.reserve(4);
    p.rows = 4;
    const Eigen::MatrixXd R = Eigen::MatrixXd::NullaryExpr(4, 4, [&] { return u(engine); });
    p.D = R * R.transpose() + 0.05 * Eigen::MatrixXd::Identity(4, 4);
    p.b = Eigen::VectorXd::NullaryExpr(4, [&] { return u(engine); });
    for (int i : {0, 1}) {
      ContactUnknown c;
      c.normal = 2 * i;
      c.tangent = 2 * i + 1;
      c.friction = trial % 2 ? 0 : 0.05 * i;
      p.unknowns.push_back(c);
    }
    const auto result = p.solve();
    REQUIRE(result.solved);
    REQUIRE(result.retries == 0);
    REQUIRE(result.residual < 1e-10);
  }
}
