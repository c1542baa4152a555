// The two paths of the saddle-point solve against each other and against a dense factorisation of
// the whole matrix; for dependent rows against the complete orthogonal decomposition, which gives
// least-norm multipliers directly.
#include "numerics/saddle_point.hpp"

#include <catch2/catch.hpp>

#include <Eigen/Dense>
#include <random>

#include "numerics/sparse.hpp"

using namespace freeplay;

namespace {

struct Problem {
  std::vector<double> mass, values;
  CsrPattern G;
  Eigen::MatrixXd dense;
  Eigen::VectorXd f, r;
};

/// A chain-like random G: each row touches six neighbouring columns.
Problem random_problem(std::mt19937& engine, int n, int m, int copies) {
  std::uniform_real_distribution<double> u(-1, 1);
  Problem p;
  p.G.columns = n;
  p.dense.setZero(m + copies, n);
  for (int i = 0; i < n; ++i) p.mass.push_back(std::exp(3 * u(engine)));
  for (int k = 0; k < m + copies; ++k) {
    const int original = k < m ? k : k - m;
    const int first = std::min(n - 6, original * std::max(1, (n - 6) / std::max(1, m)));
    for (int c = first; c < first + 6; ++c) {
      // a multiple of an earlier row
      const double x = k < m ? u(engine) : 2 * p.dense(original, c);
      p.dense(k, c) = x;
      p.G.column.push_back(c);
      p.values.push_back(x);
    }
    p.G.end_row();
  }
  p.f = Eigen::VectorXd::NullaryExpr(n, [&](Eigen::Index) { return u(engine); });
  // consistent
  p.r = p.dense * Eigen::VectorXd::NullaryExpr(n, [&](Eigen::Index) { return u(engine); });
  return p;
}

}  // namespace

TEST_CASE("dense and sparse saddle-point solves agree with a dense factorisation", "[saddle]") {
  std::mt19937 engine(7);
  for (auto [n, m] : {std::pair{9, 7}, {30, 20}, {60, 41}, {150, 100}}) {
    const auto p = random_problem(engine, n, m, 0);
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n + m, n + m);
    K.topLeftCorner(n, n).diagonal() = Eigen::Map<const Eigen::VectorXd>(p.mass.data(), n);
    K.topRightCorner(n, m) = p.dense.transpose();
    K.bottomLeftCorner(m, n) = p.dense;
    Eigen::VectorXd rhs(n + m);
    rhs << p.f, p.r;
    const Eigen::VectorXd expected = K.fullPivLu().solve(rhs);
    for (auto path : {SolvePath::dense, SolvePath::sparse}) {
      SaddlePoint solver(p.mass, p.G, path);
      Eigen::VectorXd a(n), lambda(m);
      REQUIRE(solver.factor(p.values.data()));
      REQUIRE_FALSE(solver.singular());
      solver.solve(p.f.data(), p.r.data(), a.data(), lambda.data());
      // Rounding times the condition of the Schur complement (up to 1e5 for these).
      REQUIRE((a - expected.head(n)).norm() <= 1e-9 * expected.head(n).norm());
      REQUIRE((lambda - expected.tail(m)).norm() <= 1e-9 * expected.tail(m).norm());
    }
  }
}

// A pin at a lever arm of 1 m and an angle of 45 degrees, a body of 1 kg and J = 1e-10 kg m², and a
// force along n across the arm:
//
//     a = n F/(m + J/L²) = n F (1 − 1e-10),      α = a·n/L,
//     λ = 0 along the arm and F J/L²/(m + J/L²) across it.
//
// S has the eigenvalues 1 and 1e10: the error of Cholesky alone is 1e10 roundings, 1e-6, along the
// arm. Bound: 1e-12, some hundreds of roundings, and the square of them after one refinement.
TEST_CASE("a body of negligible inertia is solved to full precision", "[saddle]") {
  const double root = std::sqrt(0.5), J = 1e-10, F = 3;
  CsrPattern G;
  G.columns = 3;
  G.column = {0, 2, 1, 2};
  G.begin = {0, 2, 4};
  G.rows = 2;
  const std::vector<double> mass{1, 1, J}, values{1, root, 1, -root};  // arm −(cos 45°, sin 45°)
  for (const auto path : {SolvePath::dense, SolvePath::sparse}) {
    CAPTURE(path == SolvePath::dense);
    SaddlePoint solver(mass, G, path);
    REQUIRE(solver.factor(values.data()));
    const std::vector<double> f{-root * F, root * F, 0};
    std::vector<double> a(3), lambda(2);
    solver.solve(f.data(), nullptr, a.data(), lambda.data());
    const double expected = F / (1 + J);
    CHECK(std::abs(-root * a[0] + root * a[1] - expected) <= 1e-12 * F);
    CHECK(std::abs(root * a[0] + root * a[1]) <= 1e-12 * F);
    CHECK(std::abs(a[2] - expected) <= 1e-12 * F);
    // Constraints alone.
    const std::vector<double> r{0.7, -0.2};
    solver.solve(nullptr, r.data(), a.data(), lambda.data());
    for (const int k : {0, 1})
      CHECK(std::abs(a[static_cast<std::size_t>(k)] + (k == 0 ? root : -root) * a[2] -
                     r[static_cast<std::size_t>(k)]) <= 1e-12);
  }
}

// A chain of pins at lever arms of 1 m, each third body of inertia J, in 20 configurations: KLU
// chooses its pivots in the first and keeps them. It forms no Schur complement, and a row of M
// whose J is below a thousandth of the arms beside it is no pivot, so that there is no division by
// J. The residuals of G a = r and M a + Gᵀλ = f are rounding, some 100 operations of it, times the
// growth of the factors on old pivots, at most 1/0.001 for KLU's pivot tolerance. Bounds: 1e-13 and
// 1e-11.
TEST_CASE("a chain with bodies of negligible inertia is solved to full precision by the sparse path",
          "[saddle]") {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> angle(-3, 3), u(-1, 1);
  for (const double J : {1e-6, 1e-8, 1e-10, 1e-12}) {
    CAPTURE(J);
    constexpr int bodies = 60;
    CsrPattern G;
    G.columns = 3 * bodies;
    std::vector<double> mass;
    for (int i = 0; i < bodies; ++i) mass.insert(mass.end(), {1, 1, i % 3 == 1 ? J : 0.3});
    for (int i = 0; i < bodies; ++i)
      for (const int k : {0, 1}) {
        if (i > 0) G.column.insert(G.column.end(), {3 * (i - 1) + k, 3 * (i - 1) + 2});
        G.column.insert(G.column.end(), {3 * i + k, 3 * i + 2});
        G.end_row();
      }
    SaddlePoint solver(mass, G);
    for (int configuration = 0; configuration < 20; ++configuration) {
      Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(G.rows, G.columns);
      std::vector<double> values, arms;  // across, of each body's pins
      for (int i = 0; i < bodies; ++i) {
        const double a = angle(engine);
        arms.insert(arms.end(), {-std::sin(a), std::cos(a)});
      }
      for (std::size_t i = 0; i < static_cast<std::size_t>(bodies); ++i)
        for (const std::size_t k : {0, 1}) {
          if (i > 0) values.insert(values.end(), {-1, -arms[2 * (i - 1) + k]});
          values.insert(values.end(), {1, -arms[2 * i + k]});
        }
      for (int k = 0; k < G.rows; ++k)
        for (int e = G.begin[k]; e < G.begin[k + 1]; ++e)
          dense(k, G.column[e]) = values[static_cast<std::size_t>(e)];
      Eigen::VectorXd f(G.columns), a(G.columns), r(G.rows), lambda(G.rows);
      for (int c = 0; c < G.columns; ++c) f[c] = mass[static_cast<std::size_t>(c)] > J ? u(engine) : 0;
      for (int k = 0; k < G.rows; ++k) r[k] = u(engine);
      REQUIRE(solver.factor(values.data()));
      REQUIRE_FALSE(solver.singular());
      solver.solve(f.data(), r.data(), a.data(), lambda.data());
      const Eigen::VectorXd M = Eigen::Map<const Eigen::VectorXd>(mass.data(), G.columns);
      const double rows = (dense * a - r).lpNorm<Eigen::Infinity>() / a.lpNorm<Eigen::Infinity>();
      const double forces = (M.cwiseProduct(a) + dense.transpose() * lambda - f).lpNorm<Eigen::Infinity>() /
                            lambda.lpNorm<Eigen::Infinity>();
      CHECK(rows <= 1e-13);
      CHECK(forces <= 1e-11);
    }
  }
}

TEST_CASE("dependent rows give least-norm multipliers on both paths", "[saddle]") {
  std::mt19937 engine(11);
  for (auto [n, m] : {std::pair{12, 6}, {60, 30}}) {
    const auto p = random_problem(engine, n, m, 2);
    const int rows = m + 2;
    const auto kept = independent_rows(p.G, p.values, p.mass);
    REQUIRE(static_cast<int>(kept.size()) == m);
    // With B = G M^(−1/2): a' = B⁺ r + (I − B⁺B) f', λ = (Bᵀ)⁺ (f' − a'), where x' = M^(∓1/2) x.
    const Eigen::VectorXd root = Eigen::Map<const Eigen::VectorXd>(p.mass.data(), n).cwiseSqrt();
    const Eigen::MatrixXd B = p.dense * root.cwiseInverse().asDiagonal();
    const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> cod(B), cod_t(B.transpose());
    const Eigen::VectorXd f = p.f.cwiseQuotient(root);
    const Eigen::VectorXd a_scaled = f + cod.solve(p.r - B * f);
    const Eigen::VectorXd lambda_expected = cod_t.solve(f - a_scaled);
    const Eigen::VectorXd a_expected = a_scaled.cwiseQuotient(root);
    for (auto path : {SolvePath::dense, SolvePath::sparse})
      for (bool announced : {true, false}) {
        SaddlePoint solver(p.mass, p.G, path, RowFacts{announced, false});
        Eigen::VectorXd a(n), lambda(rows);
        REQUIRE(solver.factor(p.values.data()));
        REQUIRE(solver.singular());
        solver.solve(p.f.data(), p.r.data(), a.data(), lambda.data());
        // The proximal term is 1e-9 of the Schur complement: its factors lose nine digits,
        // iteration restores most.
        REQUIRE((a - a_expected).norm() <= 1e-6 * a_expected.norm());
        REQUIRE((lambda - lambda_expected).norm() <= 1e-5 * lambda_expected.norm());
      }
  }
}

TEST_CASE("rows that become dependent during a motion are detected and released again", "[saddle]") {
  // A mechanism at a change point: two rows that are different before it, equal at it, and
  // different after it.
  std::mt19937 engine(5);
  for (auto path : {SolvePath::dense, SolvePath::sparse}) {
    auto p = random_problem(engine, 12, 5, 1);  // the sixth row is twice the first
    const auto at = p.values;
    auto beside = at;
    beside[beside.size() - 6] += 0.5;
    Eigen::MatrixXd apart = p.dense;
    apart(5, p.G.column[beside.size() - 6]) += 0.5;
    const Eigen::VectorXd motion = Eigen::VectorXd::LinSpaced(12, -1, 1.3);
    const auto solved = [&](SaddlePoint& solver, const std::vector<double>& values,
                            const Eigen::MatrixXd& G) {
      Eigen::VectorXd a(12), lambda(6);
      const Eigen::VectorXd r = G * motion;
      REQUIRE(solver.factor(values.data()));
      solver.solve(p.f.data(), r.data(), a.data(), lambda.data());
      CHECK(solver.converged());
      // M a + Gᵀ λ = f and G a = r: rounding times a condition number of 1e5 or, at the change
      // point, the residual of the proximal iteration.
      const Eigen::VectorXd mass = Eigen::Map<const Eigen::VectorXd>(p.mass.data(), 12);
      CHECK((mass.cwiseProduct(a) + G.transpose() * lambda - p.f).norm() <=
            1e-6 * (p.f.norm() + lambda.norm()));
      CHECK((G * a - r).norm() <= 1e-6 * r.norm());
      return lambda;
    };
    SaddlePoint solver(p.mass, p.G, path);
    const auto before = solved(solver, beside, apart);
    CHECK_FALSE(solver.singular());
    CHECK(solver.nearest_singular() > 1e-6);
    const auto there = solved(solver, at, p.dense);
    CHECK(solver.singular());
    // The multipliers of least norm: the sixth row is twice the first, so λ has no component along
    // (2, 0, ..., 0, −1).
    CHECK(there[5] == Approx(2 * there[0]).epsilon(1e-4).margin(1e-7));
    if (path == SolvePath::dense) CHECK(solver.nearest_singular() < 1e-6);
    const auto behind = solved(solver, beside, apart);
    CHECK_FALSE(solver.singular());
    CHECK((behind - before).norm() <= 1e-12 * before.norm());
    // Dependent rows with inconsistent right-hand sides: there is no solution, and this is
    // reported.
    Eigen::VectorXd a(12), lambda(6), r = p.dense * motion;
    r[5] += 1;
    REQUIRE(solver.factor(at.data()));
    solver.solve(p.f.data(), r.data(), a.data(), lambda.data());
    CHECK_FALSE(solver.converged());
  }
}

TEST_CASE("elimination of rows that fix a coordinate does not change the solution", "[saddle]") {
  std::mt19937 engine(11);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int trial = 0; trial < 50; ++trial) {
    auto p = random_problem(engine, 30, 18, 0);
    // Three more rows with one entry each; p.r stays consistent by making them part of it.
    const int fixed[] = {2, 9, 29};
    Eigen::MatrixXd dense(21, 30);
    dense.topRows(18) = p.dense;
    dense.bottomRows(3).setZero();
    for (int i = 0; i < 3; ++i) {
      const double g = u(engine) > 0 ? 1.0 : -0.5;
      dense(18 + i, fixed[i]) = g;
      p.G.column.push_back(fixed[i]);
      p.values.push_back(g);
      p.G.end_row();
    }
    const Eigen::VectorXd r =
        dense * Eigen::VectorXd::NullaryExpr(30, [&](Eigen::Index) { return u(engine); });
    SparseRow row;
    for (const int c : {1, 2, 3, 27, 28, 29}) row.push(c, u(engine));
    Eigen::VectorXd a[2], lambda[2], b[2], mu[2];
    for (const bool eliminate : {false, true}) {
      SaddlePoint solver(p.mass, p.G, SolvePath::automatic, {false, eliminate});
      CHECK(solver.eliminated().size() == (eliminate ? 3 : 0));
      REQUIRE(solver.factor(p.values.data()));
      for (auto* x : {&a[eliminate], &b[eliminate]}) x->resize(30);
      for (auto* x : {&lambda[eliminate], &mu[eliminate]}) x->resize(21);
      solver.solve(p.f.data(), r.data(), a[eliminate].data(), lambda[eliminate].data());
      solver.respond(row, nullptr, 0, b[eliminate].data(), mu[eliminate].data());
    }
    CHECK((a[0] - a[1]).norm() <= 1e-9 * a[0].norm());
    CHECK((lambda[0] - lambda[1]).norm() <= 1e-9 * lambda[0].norm());
    CHECK((b[0] - b[1]).norm() <= 1e-9 * b[0].norm());
    CHECK((mu[0] - mu[1]).norm() <= 1e-9 * mu[0].norm());
  }
}

// Without elimination, each coordinate fixed by a row is a separate part: a contact of two bodies
// touches six, and twelve with the row beside it.
TEST_CASE("the response of a sparse row equals that of its full vector", "[saddle]") {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> u(-1, 1);
  for (const bool eliminate : {false, true}) {
    constexpr int bodies = 5, n = 3 * bodies;
    CsrPattern G;
    G.columns = n;
    std::vector<double> mass, values;
    for (int c = 0; c < n; ++c) {
      mass.push_back(std::exp(u(engine)));
      if (c % 3 == 2 && c > 6) continue;  // some rotate freely
      G.column.push_back(c);
      values.push_back(1 + u(engine) * u(engine));
      G.end_row();
    }
    SaddlePoint saddle(mass, G, SolvePath::automatic, RowFacts{false, eliminate});
    REQUIRE(saddle.blocks() == (eliminate ? 0 : G.rows));
    REQUIRE(saddle.factor(values.data()));
    const auto between = [&](int a, int b) {
      SparseRow row;
      for (const int body : {a, b})
        for (int k = 0; k < 3; ++k) row.push(3 * body + k, u(engine));
      return row;
    };
    const auto row = between(0, 1), beside = between(3, 4);
    for (const auto* other : {static_cast<const SparseRow*>(nullptr), &beside}) {
      std::vector<double> f(n), a(n), lambda(G.rows), whole_a(n), whole_lambda(G.rows), summed(n);
      row.add_to(f.data(), 1);
      if (other) other->add_to(f.data(), 0.7);
      saddle.solve(f.data(), nullptr, whole_a.data(), whole_lambda.data());
      saddle.respond(row, other, 0.7, a.data(), lambda.data());
      CHECK(a == whole_a);
      CHECK(lambda == whole_lambda);
      Responses responses(1);
      responses.use(saddle);
      responses.take(0, row, other, 0.7);
      responses.add(0, 1, summed.data());
      CHECK(summed == whole_a);
      CHECK(responses.along(row, 0) == row.dot(whole_a.data()));
    }
  }
}
