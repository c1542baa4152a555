// Impacts of compound mechanisms, rotated, mirrored and in other units of time. All of them must
// leave the same motion.
#include "verification/random_scenes/transform.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using verification::random_scenes::mirrored;
using verification::random_scenes::rescaled;
using verification::random_scenes::turned;

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
