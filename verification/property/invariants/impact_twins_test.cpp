// Impacts with non-unique impulses: a lever on a stop in closed form, and random impacts against
// their mirror images and in other units of time, with every solver and law.
#include <Eigen/Core>

#include "formulations/contact/impact.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

constexpr LcpSolver solvers[] = {LcpSolver::automatic, LcpSolver::enumeration, LcpSolver::lemke,
                                 LcpSolver::gauss_seidel, LcpSolver::newton};
constexpr ImpactLaw laws[] = {ImpactLaw::newton, ImpactLaw::poisson, ImpactLaw::energetic};

struct Impact {
  Eigen::MatrixXd D;
  Eigen::VectorXd u;
  std::vector<ImpactContact> contacts;
};

/// D is singular if there are fewer degrees of freedom than rows.
Impact random_impact(std::mt19937& engine, int n, int freedoms) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Eigen::MatrixXd W = Eigen::MatrixXd::NullaryExpr(2 * n, freedoms, [&] { return uniform(engine); });
  const Eigen::VectorXd v = Eigen::VectorXd::NullaryExpr(freedoms, [&] { return uniform(engine); });
  Impact impact;
  for (int i = 0; i < n; ++i) {
    if (W.row(2 * i).dot(v) > 0) W.row(2 * i) *= -1;
    ImpactContact c;
    c.normal = 2 * i;
    c.tangent = 2 * i + 1;
    c.friction = uniform(engine) < -0.8 ? 0 : 0.6 + 0.6 * uniform(engine);
    c.restitution = 0.5 + 0.5 * uniform(engine);
    impact.contacts.push_back(c);
  }
  impact.D = W * W.transpose();
  impact.u = W * v;
  return impact;
}

/// Impacts of n contacts on one to six degrees of freedom leave the motion of their mirror images and of
/// other time units, by every law and solver.
void check_twins(int n, int trials = 12) {
  constexpr unsigned seed = 20261122;
  std::mt19937 engine(seed);
  for (int trial = 0; trial < trials; ++trial) {
    const auto given = random_impact(engine, n, 1 + trial % 6);
    double approach = 0;
    for (int i = 0; i < n; ++i) approach = std::max(approach, -given.u[2 * i]);
    for (const auto law : laws) {
      Eigen::VectorXd first;
      for (const double mirror : {1.0, -1.0})
        for (const auto solver : solvers) {
          const double time = mirror > 0 ? 1.0 : 1e3;
          Eigen::VectorXd sign = Eigen::VectorXd::Ones(2 * n);
          for (int i = 0; i < n; ++i) sign[2 * i + 1] = mirror;
          const Eigen::MatrixXd D = sign.asDiagonal() * given.D * sign.asDiagonal();
          const Eigen::VectorXd u = time * sign.cwiseProduct(given.u);
          auto contacts = given.contacts;
          ImpactProblem problem(law, solver, 1e-10);
          CAPTURE(seed, n, trial, static_cast<int>(law), static_cast<int>(solver), mirror);
          REQUIRE(problem.solve(D, u, 2 * n, contacts).empty());
          Eigen::VectorXd after = u;
          for (const auto& c : contacts)
            after += c.impulse_n * D.col(c.normal) + c.impulse_t * D.col(c.tangent);
          after = sign.cwiseProduct(after) / time;
          if (first.size() == 0) first = after;
          // 1e4 times the rounding error of D
          CHECK((after - first).cwiseAbs().maxCoeff() <= 1e-10 * approach);
        }
    }
  }
}

}  // namespace

TEST_CASE("a lever on a stop: every impact law with every solver, and its mirror image", "[impact][twins]") {
  // A lever of 1 kg and 0.1 kg m², pinned 0.3 m beside and 0.2 m above the contact, has one degree
  // of freedom: D = w wᵀ/I, w = (a, ±b), I = 0.23 kg m². Sliding continues through compression,
  // where μ|ab| aids; in expansion it opposes (Routh):
  //   P_C = −u⁻ I/(a² + μab), u⁺ = e P_C (a² − μab)/I by Poisson;
  //   by Stronge ½ r P_E² = e² ½ |u⁻| P_C, r = (a² − μab)/I;
  //   Newton's u⁺ = −e u⁻ needs P = (1 + e)|u⁻|/r.
  // Without restitution all three stop the lever by P_C.
  const double a = 0.3, b = 0.2, I = 0.23, u = -0.6;
  const auto [e, mu] = GENERATE(table<double, double>({{0.5, 0.8}, {0.0, 0.3}}));
  const double into = (a * a + mu * a * b) / I, out = (a * a - mu * a * b) / I;
  const double P_C = -u / into, P_E = std::sqrt(e * e * -u * P_C / out);
  for (const double side : {1.0, -1.0})
    for (const auto solver : solvers)
      for (const auto law : laws) {
        const Eigen::Vector2d w = Eigen::Vector2d(a, side * b) / std::sqrt(I);
        const Eigen::MatrixXd D = w * w.transpose();
        const Eigen::VectorXd before = w * (u / w[0]);
        std::vector<ImpactContact> contacts(1);
        auto& c = contacts[0];
        c.normal = 0;
        c.tangent = 1;
        c.friction = mu;
        c.restitution = e;
        ImpactProblem problem(law, solver, 1e-10);
        CAPTURE(side, static_cast<int>(solver), static_cast<int>(law));
        REQUIRE(problem.solve(D, before, 2, contacts).empty());
        const double after = u + D(0, 0) * c.impulse_n + D(0, 1) * c.impulse_t;
        const double P = e == 0                      ? P_C
                         : law == ImpactLaw::newton  ? (1 + e) * -u / out
                         : law == ImpactLaw::poisson ? (1 + e) * P_C
                                                     : P_C + P_E;
        const double expected = law == ImpactLaw::newton    ? -e * u
                                : law == ImpactLaw::poisson ? e * P_C * out
                                                            : P_E * out;
        CHECK(c.impulse_n == Approx(P).epsilon(1e-10));
        CHECK(after == Approx(expected).epsilon(1e-10).margin(e == 0 ? 1e-10 : 0));
        if (law == ImpactLaw::newton && e > 0) continue;
        // Friction in each phase: μ P times the mean slip, |u_T| = (b/a)|u_N|.
        if (e == 0) CHECK(c.impulse_t == Approx(side * mu * P).epsilon(1e-10));
        const double expansion = law == ImpactLaw::poisson ? e * P_C : P_E;
        const double rubbed = mu * b / a * 0.5 * (P_C * -u + expansion * expected);
        CHECK(problem.tangential_work() == Approx(-rubbed).epsilon(1e-9));
        CHECK(problem.normal_work() == Approx(0.5 * (P_C * u + expansion * expected)).epsilon(1e-9));
      }
}

TEST_CASE("impacts of one to four contacts, mirrored and in other time units, for every solver and law",
          "[impact][twins]") {
  for (const int n : {1, 2, 3}) check_twins(n);
  check_twins(4, 1);
}

TEST_CASE("more impacts of four contacts, mirrored and in other time units, for every solver and law",
          "[impact][twins][slow]") {
  check_twins(4);
}

TEST_CASE("an impact of a rotor keeps its restitution at any step where the normal turns fast",
          "[impact][twins]") {
  // One degree of freedom and no friction: ω⁺ = −e ω⁻ exactly. The remaining error is rounding of
  // the constraints' solve, 1e-9 of ω.
  for (const double step : {2e-5, 1e-5, 1e-6})
    for (const double e : {0.0, 0.5, 1.0}) {
      auto scene = read_scene(test::scene_file("rotor_on_stop"));
      scene.nonsmooth.step = step;
      scene.mechanism.surfaces[0].restitution = e;
      const auto run = test::simulate(scene, Family::nonsmooth);
      CAPTURE(step, e);
      REQUIRE(test::touches(run).size() == 1);
      CHECK(run.final_state.v[2] == Approx(1000 * e).margin(1e-6).epsilon(0));
      const auto touch = test::touch(run, 0);
      CHECK(touch.v_n_plus == Approx(-e * touch.v_n_minus).margin(1e-9 * -touch.v_n_minus).epsilon(0));
    }
}
