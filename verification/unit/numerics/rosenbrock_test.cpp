// Implicit steps: the elimination of integrals and of quantities on which nothing depends.
#include <Eigen/Dense>
#include <cstddef>

#include "numerics/rosenbrock4.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// dx/dt = A x + t b as a problem of Rosenbrock4.
struct LinearProblem {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;

  Eigen::VectorXd step(const Eigen::VectorXd& x, double h, Eigen::VectorXd& error,
                       bool* damps_growth = nullptr) const {
    Rosenbrock4::Problem problem;
    problem.context = const_cast<LinearProblem*>(this);
    problem.side = [](void* self, const double* y, double* dydt, double t) {
      const auto& p = *static_cast<const LinearProblem*>(self);
      const auto n = p.b.size();
      Eigen::Map<Eigen::VectorXd>(dydt, n) = p.A * Eigen::Map<const Eigen::VectorXd>(y, n) + t * p.b;
    };
    problem.jacobian = [](void* self, const double*, double, double* J, double* dfdt) {
      const auto& p = *static_cast<const LinearProblem*>(self);
      std::copy_n(p.A.data(), p.A.size(), J);
      std::copy_n(p.b.data(), p.b.size(), dfdt);
    };
    Rosenbrock4 method(static_cast<int>(x.size()));
    Eigen::VectorXd to(x.size());
    error.resize(x.size());
    method.step(problem, x.data(), 0.3, h, to.data(), error.data());
    if (damps_growth) *damps_growth = method.damps_growth();
    return to;
  }
};

}  // namespace

TEST_CASE("rosenbrock4: a step does not depend on the unknowns in which it is written") {
  // With y = T x the steps of dy/dt = T A T⁻¹ y are T times those of dx/dt = A x, for any regular
  // T. A has all kinds of rows and columns; T A T⁻¹ has none that is special. Coordinates 0 and 1
  // are integrals of 3 and 4, 4 is one of 5, 6 is one of itself, 7 and 8 depend on the others only,
  // 8 on nothing but t.
  std::mt19937 engine(20261127);
  std::uniform_real_distribution<double> uniform(-1, 1);
  constexpr int n = 9;
  for (int draw = 0; draw < 20; ++draw) {
    LinearProblem plain{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd(n)};
    auto& A = plain.A;
    A(0, 3) = A(1, 4) = A(4, 5) = A(6, 6) = 1;
    for (const int r : {2, 3, 5, 7})
      for (int c = 0; c < 7; ++c)
        if ((r + c + draw) % 3 != 0) A(r, c) = uniform(engine) * std::pow(10.0, draw % 4);
    Eigen::MatrixXd T(n, n);
    Eigen::VectorXd x(n);
    for (int i = 0; i < n; ++i) {
      plain.b[i] = uniform(engine);
      x[i] = uniform(engine);
      for (int k = 0; k < n; ++k) T(i, k) = uniform(engine) + (i == k ? 3 : 0);
    }
    const Eigen::MatrixXd inverse = T.inverse();
    const LinearProblem mixed{T * A * inverse, T * plain.b};
    const double h = 0.2 / A.cwiseAbs().maxCoeff();
    Eigen::VectorXd error, mixed_error;
    const Eigen::VectorXd to = plain.step(x, h, error), other = mixed.step(T * x, h, mixed_error);
    INFO(draw);
    // T has a condition below 100: rounding of 1e-16 becomes 1e-14, times the length of the sums.
    CHECK((inverse * other - to).norm() < 1e-12 * to.norm());
    CHECK((inverse * mixed_error - error).norm() < 1e-12 * to.norm());
  }
}

TEST_CASE("rosenbrock4: steps that damp growth are known from the sign of the determinant") {
  // x'' = 9 x − 2 x' has the rates −1 ± √10; x alone is an integral, x₂ and an integral of both
  // stand beside it.
  LinearProblem p{Eigen::MatrixXd::Zero(4, 4), Eigen::VectorXd::Zero(4)};
  p.A(0, 1) = p.A(3, 0) = p.A(3, 2) = 1;
  p.A(1, 0) = 9;
  p.A(1, 1) = -2;
  p.A(2, 2) = -1e4;
  const double pole = 4 / (std::sqrt(10.0) - 1);
  for (const double h : {1e-3, 0.99 * pole, 1.01 * pole, 100.0}) {
    CAPTURE(h);
    Eigen::VectorXd error;
    bool damped = false;
    p.step(Eigen::VectorXd::Ones(4), h, error, &damped);
    CHECK(damped == (h > pole));
  }
}
