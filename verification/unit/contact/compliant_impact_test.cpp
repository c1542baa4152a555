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

/// Contacts that approach at the rates u, and their impulses by the compliant law.
struct Impact {
  Eigen::MatrixXd D;
  Eigen::VectorXd u;
  std::vector<ImpactContact> contacts;

  /// Solves with the object of all impacts, as a run does.
  const ImpactProblem& solve() {
    static ImpactProblem problem(ImpactLaw::compliant, LcpSolver::automatic, 1e-12);
    REQUIRE(problem.solve(D, u, static_cast<int>(u.size()), contacts).empty());
    return problem;
  }
  Eigen::VectorXd after() const {
    Eigen::VectorXd rates = u;
    for (const auto& c : contacts) {
      rates += c.impulse_n * D.col(c.normal);
      if (c.tangent >= 0) rates += c.impulse_t * D.col(c.tangent);
    }
    return rates;
  }
  double energy(const Eigen::VectorXd& rates) const { return 0.5 * rates.dot(D.ldlt().solve(rates)); }
  void check_loss() const { CHECK(energy(after()) <= energy(u) * (1 + 1e-12)); }
};

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
  for (int trial = 0; trial < 500; ++trial) {
    Impact s{random_delassus(2, engine), Eigen::VectorXd(2), {}};
    s.u << -0.1 - uniform(engine), 4 * uniform(engine) - 2;
    const double e = trial % 5 == 0 ? 1 : 0.05 + 0.9 * uniform(engine);
    const double mu = 0.02 + uniform(engine), kappa = 0.3 + 2 * uniform(engine);
    s.contacts = {contact_of(0, e, mu, kappa)};
    CAPTURE(trial, s.D, s.u, e, mu, kappa);
    const auto& impact = s.solve();
    CHECK_FALSE(impact.inelastic());
    const reference::Delassus<long double> d{s.D(0, 0), s.D(0, 1), s.D(1, 1)};
    const auto exact = reference::compliant_impact<long double>(d, s.u[0], s.u[1], e, mu, kappa);
    const double size = static_cast<double>(exact.impulse_n);
    CHECK(s.contacts[0].impulse_n == Approx(size).epsilon(1e-10));
    CHECK(s.contacts[0].impulse_t == Approx(static_cast<double>(exact.impulse_t)).margin(1e-10 * size));
    CHECK(impact.normal_work() <= 1e-13);
    CHECK(impact.tangential_work() <= 1e-13 * size);
  }
}

TEST_CASE("compliant impacts of several contacts make no energy", "[impact]") {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + trial % 3;
    Impact s{random_delassus(2 * n, engine), Eigen::VectorXd(2 * n), {}};
    for (int i = 0; i < n; ++i) {
      s.u[2 * i] = i == 0 ? -1 : uniform(engine) - 0.7;
      s.u[2 * i + 1] = 2 * uniform(engine) - 1;
      s.contacts.push_back(contact_of(2 * i, trial % 2 ? 1 : uniform(engine), uniform(engine), 0.8));
    }
    CAPTURE(trial);
    const auto& impact = s.solve();
    CHECK_FALSE(impact.inelastic());
    s.check_loss();
    const double start = s.energy(s.u);
    CHECK(s.energy(s.after()) - start ==
          Approx(impact.normal_work() + impact.tangential_work()).margin(1e-11 * start));
    CHECK(impact.tangential_work() <= 1e-11 * start);
    for (const auto& c : s.contacts) {
      CHECK(s.after()[c.normal] >= -1e-9);
      CHECK(std::abs(c.impulse_t) <= c.friction * c.impulse_n * (1 + 1e-12));
    }
  }
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

  Impact balls{Eigen::Matrix2d{{2, -1}, {-1, 2}}, Eigen::Vector2d(-1, 0), {{}, {}}};
  for (int i = 0; i < 2; ++i) balls.contacts[i].normal = i, balls.contacts[i].restitution = 1;
  balls.solve();
  const double P = balls.contacts[0].impulse_n, Q = balls.contacts[1].impulse_n;
  CHECK(1 - P == Approx(v1).margin(1e-12));
  CHECK(P - Q == Approx(mean - 0.5 * opening).margin(1e-12));
  CHECK(Q == Approx(mean + 0.5 * opening).margin(1e-12));
}

TEST_CASE("compliant impacts on resting and inelastic contacts end, and have mirror images", "[impact]") {
  std::mt19937 engine(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + trial % 2;
    Impact s{random_delassus(2 * n, engine), Eigen::VectorXd::Zero(2 * n), {}};
    s.u[0] = -1;
    s.u[1] = trial % 3 == 0 ? 0 : 2 * uniform(engine) - 1;
    Eigen::VectorXd mirror(2 * n);
    for (int i = 0; i < n; ++i) {
      s.contacts.push_back(contact_of(2 * i, trial % 4 == i ? 0 : uniform(engine), uniform(engine), 0.8));
      mirror.segment(2 * i, 2) << 1, -1;
    }
    Impact other{mirror.asDiagonal() * s.D * mirror.asDiagonal(), mirror.cwiseProduct(s.u), s.contacts};
    CAPTURE(trial);
    CHECK_FALSE(s.solve().inelastic());
    s.check_loss();
    other.solve();
    for (int i = 0; i < n; ++i) {
      CHECK(s.after()[2 * i] >= -1e-9);
      CHECK(other.contacts[i].impulse_n == Approx(s.contacts[i].impulse_n).margin(1e-9));
      CHECK(other.contacts[i].impulse_t == Approx(-s.contacts[i].impulse_t).margin(1e-9));
    }
  }
}

TEST_CASE("inelastic compliant impacts that close again make no energy", "[impact]") {
  // Soft tangential springs, which would store much energy if a contact that closes again began in slip.
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  int fell_back = 0;
  constexpr int trials = 2000, n = 3;
  for (int trial = 0; trial < trials; ++trial) {
    const auto draw = [&] { return normal(engine); };
    const Eigen::MatrixXd W = Eigen::MatrixXd::NullaryExpr(2 * n, 2 * n, draw);
    Impact s{W * W.transpose() / (2 * n) + 0.02 * Eigen::MatrixXd::Identity(2 * n, 2 * n),
             Eigen::VectorXd::NullaryExpr(2 * n, draw),
             {}};
    s.u[0] = -std::abs(s.u[0]);
    for (int i = 0; i < n; ++i)
      s.contacts.push_back(contact_of(2 * i, 0, uniform(engine), 3e-3 * uniform(engine) + 1e-4));
    CAPTURE(trial);
    fell_back += s.solve().inelastic();
    s.check_loss();
  }
  CHECK(fell_back <= trials / 100);
}

TEST_CASE("an inelastic compliant impact without friction is the limit of small restitution", "[impact]") {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 100; ++trial) {
    const int n = 2 + trial % 2;
    Impact held{random_delassus(n, engine), Eigen::VectorXd(n), std::vector<ImpactContact>(n)};
    for (int i = 0; i < n; ++i) {
      held.u[i] = i == 0 ? -1 : uniform(engine) - 0.5;
      held.contacts[i].normal = i;
    }
    Impact slow = held;
    for (auto& c : slow.contacts) c.restitution = 2e-3;
    CAPTURE(trial);
    CHECK_FALSE(held.solve().inelastic());
    CHECK_FALSE(slow.solve().inelastic());
    for (int i = 0; i < n; ++i)
      CHECK(held.contacts[i].impulse_n == Approx(slow.contacts[i].impulse_n).margin(0.01 / held.D(i, i)));
  }
}

TEST_CASE("compliant impacts near the limit of sliding throughout vary smoothly with the angle", "[impact]") {
  // A sphere: slip throughout begins at ψ = max(θ, θ(1 + e) − 1/e), where stick lasts for an instant
  // just before separation.
  const double kappa = 0.8, mu = 0.1, e = 0.9, theta = 3.5 * kappa;
  const double limit = std::max(theta, theta * (1 + e) - 1 / e) * mu / kappa;
  const Eigen::MatrixXd D = Eigen::Vector2d(1, 3.5).asDiagonal();
  for (int k = 0; k <= 2000; ++k)
    for (const double side : {-1.0, 1.0}) {
      CAPTURE(k, side);
      Impact impact{
          D, Eigen::Vector2d(-1, side * limit * (0.98 + 0.03 * k / 2000)), {contact_of(0, e, mu, kappa)}};
      CHECK_FALSE(impact.solve().inelastic());
      const auto exact =
          reference::compliant_impact<long double>({1, 0, 3.5L}, -1, impact.u[1], e, mu, kappa);
      CHECK(impact.contacts[0].impulse_n == Approx(1 + e).epsilon(1e-12));
      CHECK(impact.contacts[0].impulse_t == Approx(static_cast<double>(exact.impulse_t)).margin(1e-11));
    }
}
