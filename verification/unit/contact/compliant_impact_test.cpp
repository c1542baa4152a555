// The compliant impact law: single contacts against an independent program, and conservation laws
// for several contacts. The reference solves slip in closed form and stick by its two harmonic
// modes; the law uses Taylor series.
#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <random>

#include "formulations/contact/impact.hpp"
#include "verification/references/compliant_impact.hpp"

using namespace freeplay;

namespace {

ImpactContact contact_of(int row, double e, double mu, double kappa) {
  ImpactContact c;
  c.normal = row;
  c.tangent = row + 1;
  c.restitution = e;
  c.friction = mu;
  c.stiffness_ratio = kappa;
  return c;
}

/// A random positive definite matrix of the given size.
Eigen::MatrixXd random_delassus(int size, std::mt19937& engine) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Eigen::MatrixXd W(size + 2, size);
  for (int i = 0; i < W.rows(); ++i)
    for (int j = 0; j < W.cols(); ++j) W(i, j) = uniform(engine);
  return W.transpose() * W + 0.05 * Eigen::MatrixXd::Identity(size, size);
}

}  // namespace

TEST_CASE("a compliant impact of one contact equals that of an independent program", "[impact]") {
  std::mt19937 engine(20261125);
  std::uniform_real_distribution<double> uniform(0, 1);
  ImpactProblem impact(ImpactLaw::compliant, LcpSolver::automatic, 1e-12);
  for (int trial = 0; trial < 500; ++trial) {
    const Eigen::MatrixXd D = random_delassus(2, engine);
    Eigen::VectorXd u(2);
    u << -0.1 - uniform(engine), 4 * uniform(engine) - 2;
    const double e = trial % 5 == 0 ? 1 : 0.05 + 0.9 * uniform(engine);
    const double mu = 0.02 + uniform(engine), kappa = 0.3 + 2 * uniform(engine);
    std::vector<ImpactContact> contacts{contact_of(0, e, mu, kappa)};
    CAPTURE(trial, D, u, e, mu, kappa);
    REQUIRE(impact.solve(D, u, 2, contacts).empty());
    CHECK_FALSE(impact.inelastic());
    const reference::Delassus<long double> d{D(0, 0), D(0, 1), D(1, 1)};
    const auto exact = reference::compliant_impact<long double>(d, u[0], u[1], e, mu, kappa);
    const double size = static_cast<double>(exact.impulse_n);
    CHECK(contacts[0].impulse_n == Approx(size).epsilon(1e-10));
    CHECK(contacts[0].impulse_t == Approx(static_cast<double>(exact.impulse_t)).margin(1e-10 * size));
    CHECK(impact.normal_work() <= 1e-13);
    CHECK(impact.tangential_work() <= 1e-13 * size);
  }
}

TEST_CASE("compliant impacts of several contacts make no energy", "[impact]") {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  ImpactProblem impact(ImpactLaw::compliant, LcpSolver::automatic, 1e-12);
  int solved = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + trial % 3;
    const Eigen::MatrixXd D = random_delassus(2 * n, engine);
    Eigen::VectorXd u(2 * n);
    std::vector<ImpactContact> contacts;
    for (int i = 0; i < n; ++i) {
      u[2 * i] = i == 0 ? -1 : uniform(engine) - 0.7;
      u[2 * i + 1] = 2 * uniform(engine) - 1;
      contacts.push_back(contact_of(2 * i, trial % 2 ? 1 : uniform(engine), uniform(engine), 0.8));
    }
    REQUIRE(impact.solve(D, u, 2 * n, contacts).empty());
    if (impact.inelastic()) continue;
    ++solved;
    Eigen::VectorXd P(2 * n);
    for (int i = 0; i < n; ++i) P[2 * i] = contacts[i].impulse_n, P[2 * i + 1] = contacts[i].impulse_t;
    const Eigen::VectorXd after = u + D * P;
    const auto energy = [&](const Eigen::VectorXd& rates) { return 0.5 * rates.dot(D.ldlt().solve(rates)); };
    CAPTURE(trial);
    CHECK(energy(after) <= energy(u) * (1 + 1e-12));
    CHECK(energy(after) - energy(u) ==
          Approx(impact.normal_work() + impact.tangential_work()).margin(1e-11 * energy(u)));
    CHECK(impact.tangential_work() <= 1e-11 * energy(u));
    for (int i = 0; i < n; ++i) {
      CHECK(after[2 * i] >= -1e-9);
      CHECK(std::abs(P[2 * i + 1]) <= contacts[i].friction * P[2 * i] * (1 + 1e-12));
    }
  }
  CHECK(solved == 200);
}

TEST_CASE("three balls on equal linear springs leave a compliant impact with the velocities of their modes",
          "[impact]") {
  // Unit masses, e = 1. While both contacts are closed, the modes of the chain have ω = 1 and √3:
  // compressions δ₁ = (sin t + sin(√3 t)/√3)/2, δ₂ = (sin t − sin(√3 t)/√3)/2. The first contact
  // opens where δ₁ = 0; afterwards the last two are a pair, whose contact opens after a part of a
  // half-wave of ω = √2.
  double t = 2.5;  // the first zero of δ₁ after t = 0, by Newton's method
  const double r = std::sqrt(3.0);
  for (int i = 0; i < 50; ++i) t -= (std::sin(t) + std::sin(r * t) / r) / (std::cos(t) + std::cos(r * t));
  const double delta2 = 0.5 * (std::sin(t) - std::sin(r * t) / r),
               rate1 = 0.5 * (std::cos(t) + std::cos(r * t)), rate2 = 0.5 * (std::cos(t) - std::cos(r * t));
  // Rates δ̇₁ = v₁ − v₂, δ̇₂ = v₂ − v₃, momentum 1.
  const double v3 = (1 - rate1 - 2 * rate2) / 3, v2 = v3 + rate2, v1 = v2 + rate1;
  const double opening = std::sqrt(rate2 * rate2 + 2 * delta2 * delta2);  // of the pair
  const double mean = 0.5 * (v2 + v3);
  REQUIRE(delta2 > 0);

  ImpactProblem impact(ImpactLaw::compliant, LcpSolver::automatic, 1e-12);
  Eigen::MatrixXd D(2, 2);
  D << 2, -1, -1, 2;
  Eigen::VectorXd u(2);
  u << -1, 0;
  std::vector<ImpactContact> contacts(2);
  for (int i = 0; i < 2; ++i) contacts[i].normal = i, contacts[i].restitution = 1;
  REQUIRE(impact.solve(D, u, 2, contacts).empty());
  const double P = contacts[0].impulse_n, Q = contacts[1].impulse_n;
  CHECK(1 - P == Approx(v1).margin(1e-12));
  CHECK(P - Q == Approx(mean - 0.5 * opening).margin(1e-12));
  CHECK(Q == Approx(mean + 0.5 * opening).margin(1e-12));
}

TEST_CASE("compliant impacts on resting and inelastic contacts end, and have mirror images", "[impact]") {
  std::mt19937 engine(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  ImpactProblem impact(ImpactLaw::compliant, LcpSolver::automatic, 1e-12);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + trial % 2;
    const Eigen::MatrixXd D = random_delassus(2 * n, engine);
    Eigen::VectorXd u = Eigen::VectorXd::Zero(2 * n), mirror(2 * n);
    u[0] = -1;
    u[1] = trial % 3 == 0 ? 0 : 2 * uniform(engine) - 1;
    std::vector<ImpactContact> contacts;
    for (int i = 0; i < n; ++i) {
      contacts.push_back(contact_of(2 * i, trial % 4 == i ? 0 : uniform(engine), uniform(engine), 0.8));
      mirror.segment(2 * i, 2) << 1, -1;
    }
    auto other = contacts;
    CAPTURE(trial);
    REQUIRE(impact.solve(D, u, 2 * n, contacts).empty());
    CHECK_FALSE(impact.inelastic());
    Eigen::VectorXd P(2 * n);
    for (int i = 0; i < n; ++i) P[2 * i] = contacts[i].impulse_n, P[2 * i + 1] = contacts[i].impulse_t;
    const Eigen::VectorXd after = u + D * P;
    CHECK(0.5 * after.dot(D.ldlt().solve(after)) <= 0.5 * u.dot(D.ldlt().solve(u)) * (1 + 1e-12));
    for (int i = 0; i < n; ++i) CHECK(after[2 * i] >= -1e-9);
    const Eigen::MatrixXd turned = mirror.asDiagonal() * D * mirror.asDiagonal();
    REQUIRE(impact.solve(turned, mirror.cwiseProduct(u), 2 * n, other).empty());
    for (int i = 0; i < n; ++i) {
      CHECK(other[i].impulse_n == Approx(contacts[i].impulse_n).margin(1e-9));
      CHECK(other[i].impulse_t == Approx(-contacts[i].impulse_t).margin(1e-9));
    }
  }
}

TEST_CASE("inelastic compliant impacts that close again make no energy", "[impact]") {
  // Soft tangential springs, which would store much energy if a contact that closes again began in slip.
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  ImpactProblem impact(ImpactLaw::compliant, LcpSolver::automatic, 1e-12);
  int fell_back = 0;
  constexpr int trials = 6000, n = 3;
  for (int trial = 0; trial < trials; ++trial) {
    const Eigen::MatrixXd W = Eigen::MatrixXd::NullaryExpr(2 * n, 2 * n, [&] { return normal(engine); });
    const Eigen::MatrixXd D = W * W.transpose() / (2 * n) + 0.02 * Eigen::MatrixXd::Identity(2 * n, 2 * n);
    Eigen::VectorXd u = Eigen::VectorXd::NullaryExpr(2 * n, [&] { return normal(engine); });
    u[0] = -std::abs(u[0]);
    std::vector<ImpactContact> contacts;
    for (int i = 0; i < n; ++i)
      contacts.push_back(contact_of(2 * i, 0, uniform(engine), 3e-3 * uniform(engine) + 1e-4));
    CAPTURE(trial);
    REQUIRE(impact.solve(D, u, 2 * n, contacts).empty());
    fell_back += impact.inelastic();
    Eigen::VectorXd P(2 * n);
    for (int i = 0; i < n; ++i) P[2 * i] = contacts[i].impulse_n, P[2 * i + 1] = contacts[i].impulse_t;
    const Eigen::VectorXd after = u + D * P;
    CHECK(0.5 * after.dot(D.ldlt().solve(after)) <= 0.5 * u.dot(D.ldlt().solve(u)) * (1 + 1e-12));
  }
  CHECK(fell_back <= trials / 100);
}

TEST_CASE("an inelastic compliant impact without friction is the limit of small restitution", "[impact]") {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  ImpactProblem impact(ImpactLaw::compliant, LcpSolver::automatic, 1e-12);
  for (int trial = 0; trial < 100; ++trial) {
    const int n = 2 + trial % 2;
    const Eigen::MatrixXd D = random_delassus(n, engine);
    Eigen::VectorXd u(n);
    std::vector<ImpactContact> held(n);
    for (int i = 0; i < n; ++i) {
      u[i] = i == 0 ? -1 : uniform(engine) - 0.5;
      held[i].normal = i;
    }
    auto slow = held;
    for (auto& c : slow) c.restitution = 2e-3;
    CAPTURE(trial);
    REQUIRE(impact.solve(D, u, n, held).empty());
    CHECK_FALSE(impact.inelastic());
    REQUIRE(impact.solve(D, u, n, slow).empty());
    CHECK_FALSE(impact.inelastic());
    for (int i = 0; i < n; ++i) CHECK(held[i].impulse_n == Approx(slow[i].impulse_n).margin(0.01 / D(i, i)));
  }
}

TEST_CASE("compliant impacts near the limit of sliding throughout vary smoothly with the angle", "[impact]") {
  // A sphere: slip throughout begins at ψ = max(θ, θ(1 + e) − 1/e), where stick lasts for an instant
  // just before separation.
  ImpactProblem impact(ImpactLaw::compliant, LcpSolver::automatic, 1e-12);
  const double kappa = 0.8, mu = 0.1, e = 0.9, theta = 3.5 * kappa;
  const double limit = std::max(theta, theta * (1 + e) - 1 / e) * mu / kappa;
  const Eigen::MatrixXd D = Eigen::Vector2d(1, 3.5).asDiagonal();
  for (int k = 0; k <= 2000; ++k)
    for (const double side : {-1.0, 1.0}) {
      Eigen::VectorXd u(2);
      u << -1, side * limit * (0.98 + 0.03 * k / 2000);
      std::vector<ImpactContact> contacts{contact_of(0, e, mu, kappa)};
      REQUIRE(impact.solve(D, u, 2, contacts).empty());
      const auto exact = reference::compliant_impact<long double>({1, 0, 3.5L}, -1, u[1], e, mu, kappa);
      CAPTURE(k, side);
      CHECK_FALSE(impact.inelastic());
      CHECK(contacts[0].impulse_n == Approx(1 + e).epsilon(1e-12));
      CHECK(contacts[0].impulse_t == Approx(static_cast<double>(exact.impulse_t)).margin(1e-11));
    }
}
