// Implicit steps: the elimination of integrals and of quantities on which nothing depends, and
// Jacobians of penalty runs by traced equations.
#include <Eigen/Dense>
#include <cstddef>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "dynamics/system_tracer.hpp"
#include "formulations/penalty/penalty.hpp"
#include "numerics/rosenbrock4.hpp"
#include "verification/random_scenes/scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
namespace rs = freeplay::verification::random_scenes;

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

/// Moves the bodies of a contact along its normal until it is 1e-3 of its clearance deep, or 1 µm.
void press(const System& system, int k, State& at) {
  const auto n = static_cast<std::size_t>(system.n());
  auto e = system.make_evaluation();
  ContactRow row;
  for (int repeat = 0; repeat < 3; ++repeat) {
    system.place(at.t, at.q.data(), e);
    system.rate(at.q.data(), at.v.data(), e);
    system.contact(k, at.q.data(), at.v.data(), e, row);
    const double clearance = system.contact_facts(k).clearance;
    const double depth = clearance > 0 ? 1e-3 * clearance : 1e-6;
    std::vector<double> normal(n);
    row.normal.add_to(normal.data(), 1);
    double square = 0;
    for (const double w : normal) square += w * w;
    for (std::size_t i = 0; i < n && square > 0; ++i) at.q[i] -= (row.gap + depth) * normal[i] / square;
  }
}

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

TEST_CASE("random scenes: traced Jacobians of penalty runs equal those by dual numbers", "[compiled]") {
  // Both are exact; products of the stiffness 1e10 with rounding of the rows remain.
  constexpr double bound = 1e-9;
  std::mt19937 engine(20261127);
  int scenes = 0, states = 0, pressed = 0, refused = 0;
  for (int index = 0; index < 150 && scenes < 40; ++index) {
    const auto drawn = rs::draw(11, index);
    for (const auto& way : rs::ways(drawn.suite)) {
      if (way.family != Family::penalty || !rs::has_model(drawn, way)) continue;
      const auto scene = rs::scene_for(drawn, way);
      const System system(scene.mechanism);
      const auto start = assemble(scene.mechanism, scene.run.start);
      if (system.n() == 0) break;
      const auto parts = make_penalty_parts(scene, system, start);
      const auto traced = parts.steps->dynamics().twin(), general = parts.steps->dynamics().twin();
      traced->trace_jacobian(start);
      ++scenes;
      INFO(drawn.kind << " " << index << " " << way.name);
      for (int mode = 0; mode < 4; ++mode, ++states) {
        auto at = moved(system, start, still_coordinates(system, start), 31 + mode);
        const int contact = mode > 0 && system.contacts() > 0 ? mode % system.contacts() : -1;
        if (contact >= 0) press(system, contact, at);
        const auto size = static_cast<std::size_t>(traced->size());
        std::vector<double> x(size);
        std::ranges::copy(at.q, x.begin());
        std::ranges::copy(at.v, x.begin() + system.n());
        std::ranges::copy(at.z, x.begin() + traced->state_offset());
        for (auto* f : {traced.get(), general.get()})
          for (int k = 0; k < system.contacts(); ++k)
            f->contacts()[static_cast<std::size_t>(k)].closed = k == contact;
        std::vector<double> J(size * size), t(size), J_general(size * size), t_general(size);
        traced->jacobian(x, at.t, J.data(), t.data());
        general->jacobian(x, at.t, J_general.data(), t_general.data());
        const bool by_traced = traced->jacobian_is_traced();
        CHECK_FALSE(general->jacobian_is_traced());
        if (!by_traced) ++refused;
        if (by_traced && contact >= 0) ++pressed;
        double most = 0, scale = 0;
        for (std::size_t i = 0; i < J.size(); ++i) {
          most = std::max(most, std::abs(J[i] - J_general[i]));
          scale = std::max(scale, std::abs(J_general[i]));
        }
        for (std::size_t i = 0; i < t.size(); ++i) {
          most = std::max(most, std::abs(t[i] - t_general[i]));
          scale = std::max(scale, std::abs(t_general[i]));
        }
        CHECK(most <= bound * scale);
      }
      break;
    }
  }
  CAPTURE(scenes, states, pressed, refused);
  CHECK(scenes >= 20);
  CHECK(pressed >= 40);
  // Scenes with joint friction, films or bristles are not traced, others only at states with other branches.
  CHECK(refused <= states / 2);
}
