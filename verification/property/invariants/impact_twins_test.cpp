// Impacts with non-unique impulses: a lever on a stop in closed form, and random impacts against
// their mirror images and in other units of time, with every solver and law.
#include <Eigen/Core>

#include "formulations/contact/impact.hpp"
#include "verification/random_scenes/transform.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using verification::random_scenes::mirrored;
using verification::random_scenes::rescaled;
using verification::random_scenes::turned;

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

// Impacts of compound mechanisms, rotated, mirrored and in other units of time. All of them must
// leave the same motion.

namespace {

// s: the impact is at the start. Steps of a quarter: the rounding error of a gap, 1e-17 m, is 1e-12
// m/s over one.
constexpr double end = 4e-5;

Vec2 turn(Vec2 p, double a) {
  return {p.x() * std::cos(a) - p.y() * std::sin(a), p.x() * std::sin(a) + p.y() * std::cos(a)};
}
/// A corner or disc of a body in contact with a wall at the point `on`, which is `at` in the body.
std::string wall(const char* name, Vec2 on, Vec2 at, double axis, double radius) {
  return test::plane(name, "ground", "b", radius, "s",
                     fmt::format("at = [[{}, {}], [{}, {}]]\naxis = [{}, {}]\n", on.x(), on.y(), at.x(),
                                 at.y(), std::cos(axis), std::sin(axis)));
}

/// A pinned rod on a stop (one degree of freedom), a disc in a corner, a rod that lands on both
/// ends, a row of two discs against a wall: each is in contact and approaches at the start.
Scene built(std::mt19937& engine, int trial) {
  const auto uniform = [&](double low = -1, double high = 1) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  const auto body = [&](const char* name, Vec2 velocity, double spin, Vec2 position = {}) {
    const double mass = uniform(0.3, 3);
    return test::body(name, mass, 0.02 * uniform(0.3, 3),
                      fmt::format("position = [{}, {}]\nvelocity = [{}, {}]\nangular_velocity = {}\n",
                                  position.x(), position.y(), velocity.x(), velocity.y(), spin));
  };
  const double e = trial % 5 == 0 ? 0 : 0.5 + 0.5 * uniform(), friction = 0.6 + 0.6 * uniform(),
               speed = 1.5 + uniform();
  auto text = test::surface("s", e, trial % 7 != 0 ? fmt::format("friction = {}\n", friction) : "") +
              test::run_for(end, "start = \"given\"\n");
  switch (trial % 4) {
    case 0: {
      // About the pin, so that the tip moves down.
      const Vec2 pin{0.3 * uniform(), 0.2}, tip{-0.4 + 0.2 * uniform(), 0};
      const double spin = tip.x() < pin.x() ? speed : -speed;
      text += test::pin("pin", "ground", "b", pin, pin) + wall("stop", tip, tip, 0, 0) +
              body("b", spin * Vec2{pin.y(), -pin.x()}, spin);
      break;
    }
    case 1: {
      // Walls at ± this from the vertical, the disc between them.
      const double half = 0.4 + 0.3 * uniform(), axis = std::numbers::pi / 2 - half;
      const Vec2 on{0, -0.05 / std::sin(half)};
      const double across = 0.2 * speed * std::sin(half) * uniform();
      text += wall("right", on, {}, axis, 0.05) + wall("left", on, {}, -axis, 0.05) +
              body("b", {across, -speed}, 10 * uniform());
      break;
    }
    case 2: {
      const double across = speed * uniform();
      text += wall("left", {-0.3, -0.1}, {-0.3, -0.1}, 0, 0) + wall("right", {0.2, -0.1}, {0.2, -0.1}, 0, 0) +
              body("b", {across, -speed}, speed * uniform());
      break;
    }
    default: {
      const Vec2 along{std::cos(0.9), std::sin(0.9)};
      text += wall("floor", {0, -0.05}, {}, 0, 0.05) + test::discs("discs", "b", "c", 0.05, 0.07) +
              body("b", {0, -0.2 * speed}, 5 * uniform()) + body("c", -speed * along, 0, 0.12 * along);
    }
  }
  return parse_scene(text, "built");
}

/// Velocities after the impact, rotated back, mirrored back and in the scene's own time unit.
std::vector<double> left(const Scene& scene, double angle, bool mirror, double time) {
  const auto run = test::simulate(scene, Family::nonsmooth);
  REQUIRE(run.ending.status == Ending::Status::finished);
  REQUIRE_FALSE(run.events.empty());
  auto v = run.final_state.v;
  for (std::size_t i = 0; i < v.size(); i += 3) {
    const auto back = turn({v[i], v[i + 1]}, -angle);
    v[i] = (mirror ? -1 : 1) * back.x() * time;
    v[i + 1] = back.y() * time;
    v[i + 2] *= (mirror ? -1 : 1) * time;
  }
  return v;
}

}  // namespace

TEST_CASE("impacts of compound rods and discs leave the same motion when rotated, mirrored and slowed down",
          "[impact][twins]") {
  // The required bound of 1e-10 of the greatest speed: rounding of positions (1e-16 m of 1 m)
  // rotates the rows by as much, and with D's condition of up to 1e3 that is 1e-13.
  constexpr unsigned seed = 50;
  std::mt19937 engine(seed);
  struct Way {
    Scheme scheme;
    ImpactLaw law;
  };
  const Way ways[] = {{Scheme::event_driven, ImpactLaw::newton},
                      {Scheme::event_driven, ImpactLaw::poisson},
                      {Scheme::event_driven, ImpactLaw::energetic},
                      {Scheme::moreau_jean, ImpactLaw::newton}};
  for (int trial = 0; trial < 50; ++trial) {
    auto scene = built(engine, trial);
    for (const auto& way : ways) {
      scene.nonsmooth.scheme = way.scheme;
      scene.nonsmooth.impact_law = way.law;
      if (way.scheme == Scheme::moreau_jean) scene.nonsmooth.step = end / 4;
      std::vector<double> first;
      for (const auto solver : {LcpSolver::automatic, LcpSolver::enumeration, LcpSolver::lemke,
                                LcpSolver::gauss_seidel, LcpSolver::newton}) {
        scene.nonsmooth.solver = solver;
        struct Twin {
          double angle;
          bool mirror;
          double time;
        };
        for (const auto& twin :
             {Twin{0, false, 1}, {0, true, 1}, {1.1, false, 1}, {-2.5, true, 1}, {0, false, 1024}}) {
          CAPTURE(seed, trial, static_cast<int>(way.scheme), static_cast<int>(way.law),
                  static_cast<int>(solver), twin.angle, twin.mirror, twin.time);
          auto other = twin.mirror ? mirrored(scene) : scene;
          if (twin.time != 1) other = rescaled(other, {1, 1, twin.time});
          const auto v = left(turned(other, twin.angle), twin.angle, twin.mirror, twin.time);
          if (first.empty()) first = v;
          double greatest = 0, apart = 0;
          for (std::size_t i = 0; i < v.size(); ++i) {
            greatest = std::max(greatest, std::abs(first[i]));
            apart = std::max(apart, std::abs(v[i] - first[i]));
          }
          CHECK(apart <= 1e-10 * std::max(greatest, 1.0));
        }
      }
    }
  }
}
