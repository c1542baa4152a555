// Impacts of several contacts with friction by Poisson's and the energetic law. Friction opposes
// sliding at every instant, so it dissipates energy at every contact, and the solution agrees with
// an integration by many small steps.
#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <random>

#include "formulations/contact/impact.hpp"

using namespace freeplay;

namespace {

struct StepImpacts {
  Eigen::MatrixXd D;
  Eigen::VectorXd u;
  std::vector<ImpactContact> contacts;
};

/// Approaching and sliding contacts, coupled at random by D = WᵀW of as many degrees of freedom as
/// rows, and two more.
StepImpacts in_impact(std::mt19937& engine, int contacts) {
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  const int rows = 2 * contacts;
  Eigen::MatrixXd W(rows + 2, rows);
  for (auto& w : W.reshaped()) w = normal(engine);
  StepImpacts s{W.transpose() * W, Eigen::VectorXd(rows),
                std::vector<ImpactContact>(static_cast<std::size_t>(contacts))};
  const double mu = uniform(engine);
  for (int i = 0; i < contacts; ++i) {
    s.u[2 * i] = -uniform(engine);
    s.u[2 * i + 1] = 0.5 * normal(engine);
    auto& c = s.contacts[static_cast<std::size_t>(i)];
    c.normal = 2 * i;
    c.tangent = 2 * i + 1;
    c.friction = mu;
    c.restitution = uniform(engine);
  }
  return s;
}

/// The same by Poisson's law in `steps` equal parts of each phase, in each of which friction
/// opposes the sliding at its end.
struct Stepped {
  Eigen::VectorXd rates;
  double friction_work = 0;
  bool solved = true;
};
Stepped stepped(const StepImpacts& s, int steps) {
  const auto n = s.contacts.size();
  Stepped end{s.u};
  std::vector<double> pressed(n, 0);
  for (int step = 0; step < 2 * steps; ++step) {
    const bool compresses = step < steps;
    const Eigen::VectorXd before = end.rates;
    ContactProblem p(LcpSolver::automatic, 1e-12);
    p.reserve(static_cast<int>(s.u.size()));
    p.rows = static_cast<int>(s.u.size());
    p.D = s.D;
    p.b.head(p.rows) = before;
    for (std::size_t i = 0; i < n; ++i) {
      const auto& c = s.contacts[i];
      ContactUnknown x;
      x.normal = c.normal;
      x.tangent = c.tangent;
      x.friction = c.friction;
      if (compresses) {
        x.target_n = (1 - (step + 1.0) / steps) * s.u[c.normal];
      } else {
        const double given = c.restitution * pressed[i] / steps;
        p.b.head(p.rows) += given * s.D.col(c.normal);
        x.bound = c.friction * given;
      }
      p.unknowns.push_back(x);
    }
    const Eigen::VectorXd moved = p.b.head(p.rows);
    end.solved &= p.solve().solved;
    end.rates = moved;
    for (std::size_t i = 0; i < n; ++i) {
      const auto& x = p.unknowns[i];
      if (compresses) pressed[i] += x.impulse_n;
      end.rates += x.impulse_n * s.D.col(x.normal) + x.impulse_t * s.D.col(x.tangent);
    }
    for (const auto& x : p.unknowns)
      end.friction_work += 0.5 * x.impulse_t * (before[x.tangent] + end.rates[x.tangent]);
  }
  return end;
}

}  // namespace

TEST_CASE("friction never adds energy in an impact of several contacts", "[impact]") {
  std::mt19937 engine(18);
  for (const auto law : {ImpactLaw::poisson, ImpactLaw::energetic}) {
    int solved = 0, gained = 0, without_ratios = 0;
    for (int trial = 0; trial < 1000; ++trial) {
      auto s = in_impact(engine, 2 + (trial % 20 == 0) + (trial % 40 == 0));
      ImpactProblem impact(law, LcpSolver::automatic, 1e-11);
      if (!impact.solve(s.D, s.u, static_cast<int>(s.u.size()), s.contacts).empty() || impact.inelastic())
        continue;
      ++solved;
      const double scale = 0.5 * s.u.dot(s.D.ldlt().solve(s.u));  // energy released by a full stop
      CAPTURE(static_cast<int>(law), trial);
      CHECK(impact.tangential_work() <= 1e-12 * scale);
      without_ratios += impact.wedged();
      // By the energetic law each normal direction returns e² of the energy that it absorbed.
      if (law == ImpactLaw::energetic && !impact.wedged()) CHECK(impact.normal_work() <= 1e-9 * scale);
      gained += impact.normal_work() + impact.tangential_work() > 1e-9 * scale;
    }
    INFO("law " << static_cast<int>(law) << ": " << solved << " of 1000 solved, " << gained << " gain, "
                << without_ratios << " without ratios");
    CHECK(solved > 980);
    CHECK(gained == 0);
  }
}

TEST_CASE("impacts of two contacts with friction agree with an integration by many small steps", "[impact]") {
  // First order in the steps: a step in which sliding stops is treated as sticking throughout.
  // 4,000 steps, rates of order one.
  std::mt19937 engine(21);
  int turned = 0;
  for (int trial = 0; trial < 60; ++trial) {
    auto s = in_impact(engine, 2);
    const auto fine = stepped(s, 4000);
    ImpactProblem impact(ImpactLaw::poisson, LcpSolver::automatic, 1e-12);
    REQUIRE(impact.solve(s.D, s.u, 4, s.contacts).empty());
    Eigen::VectorXd after = s.u;
    for (const auto& c : s.contacts)
      after += c.impulse_n * s.D.col(c.normal) + c.impulse_t * s.D.col(c.tangent);
    CAPTURE(trial, after, fine.rates);
    REQUIRE(fine.solved);
    const double scale = 0.5 * s.u.dot(s.D.ldlt().solve(s.u));
    CHECK((after - fine.rates).cwiseAbs().maxCoeff() < 2e-3);
    CHECK(impact.tangential_work() == Approx(fine.friction_work).margin(2e-3 * scale));
    for (const auto& c : s.contacts) turned += s.u[c.tangent] * after[c.tangent] < 0;
  }
  CHECK(turned > 10);  // the case under test occurs
}
