// Decompositions of numerics/dense against matrices with results known by hand.
#include "numerics/dense.hpp"

#include <catch2/catch.hpp>

#include <Eigen/Dense>

using Catch::Matchers::WithinAbs;
using Eigen::Matrix2d, Eigen::MatrixXd, Eigen::Vector2d, Eigen::VectorXd;

TEST_CASE("LU decomposition: solution, sign of the determinant and pivots", "[numerics]") {
  freeplay::DenseLu lu;
  VectorXd x;
  // [0 2; 3 1] x = (4, 5): x = (1, 2), determinant −6 with a change of rows.
  lu.compute(Matrix2d{{0, 2}, {3, 1}});
  lu.solve(Vector2d(4, 5), x);
  CHECK_THAT(x[0], WithinAbs(1, 1e-15));
  CHECK_THAT(x[1], WithinAbs(2, 1e-15));
  CHECK(lu.sign() == -1);
  lu.compute(Matrix2d{{3, 1}, {0, 2}});
  CHECK(lu.sign() == 1);
  CHECK_THAT(lu.pivot_ratio(), WithinAbs(2.0 / 3, 1e-15));
  lu.compute(Matrix2d{{1, 2}, {2, 4}});
  CHECK(lu.pivot_ratio() < 1e-15);
}

TEST_CASE("rank-deficient least squares: the solution of minimum norm", "[numerics]") {
  // x + y = 2 twice: (1, 1) is the solution nearest to the origin; for x + y = 2 and x + y = 4 it
  // is that of their mean.
  const MatrixXd A = MatrixXd::Ones(2, 2);
  const freeplay::MinimumNorm least(A, 1e-10);
  CHECK(least.rank() == 1);
  CHECK((least.solve(Vector2d(2, 2)) - Vector2d(1, 1)).norm() < 1e-15);
  CHECK((least.solve(Vector2d(2, 4)) - Vector2d(1.5, 1.5)).norm() < 1e-15);
  // A pivot of 1e-6 counts or not, according to the threshold.
  CHECK(freeplay::MinimumNorm(MatrixXd(Matrix2d{{1, 0}, {0, 1e-6}})).rank() == 2);
  CHECK(freeplay::MinimumNorm(MatrixXd(Matrix2d{{1, 0}, {0, 1e-6}}), 1e-5).rank() == 1);
}

TEST_CASE("singular systems, kernels and orthogonal complements", "[numerics]") {
  const MatrixXd singular = MatrixXd::Ones(2, 2);
  CHECK(!freeplay::solve_regular(singular, Vector2d(1, 1)));
  const auto x = freeplay::solve_regular(Matrix2d{{2, 0}, {0, 4}}, Vector2d(2, 4));
  REQUIRE(x);
  CHECK((*x - Vector2d(1, 1)).norm() < 1e-15);
  const MatrixXd k = freeplay::kernel(singular, 1e-9);
  REQUIRE(k.cols() == 1);
  CHECK(k.norm() > 0.1);
  CHECK((singular * k).norm() < 1e-15);
  CHECK(freeplay::kernel(MatrixXd::Identity(2, 2), 1e-9).norm() == 0);
  MatrixXd column(3, 1);
  column << 1, 2, 2;
  const MatrixXd Q = freeplay::orthogonal_complement(column, 1e-10);
  REQUIRE(Q.cols() == 2);
  CHECK((Q.transpose() * Q - MatrixXd::Identity(2, 2)).norm() < 1e-14);
  CHECK((Q.transpose() * column).norm() < 1e-14);
}

TEST_CASE("eigenvalues of a symmetric matrix and of a damped oscillator", "[numerics]") {
  const auto s = freeplay::symmetric_eigen(Matrix2d{{2, 1}, {1, 2}});
  CHECK((s.values - Vector2d(1, 3)).norm() < 1e-14);
  CHECK(std::abs(s.vectors.col(1).dot(Vector2d(1, 1).normalized())) > 1 - 1e-14);
  // ẍ + 0.2 ẋ + x = 0: −0.1 ± i √0.99.
  const Matrix2d A{{0, 1}, {-1, -0.2}};
  const auto g = freeplay::general_eigen(A);
  for (int i = 0; i < 2; ++i) {
    CHECK_THAT(g.values[i].real(), WithinAbs(-0.1, 1e-14));
    CHECK_THAT(std::abs(g.values[i].imag()), WithinAbs(std::sqrt(0.99), 1e-14));
    CHECK((A * g.vectors.col(i) - g.values[i] * g.vectors.col(i)).norm() < 1e-14);
  }
}
