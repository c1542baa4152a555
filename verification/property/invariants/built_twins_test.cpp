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

Body body(const char* name, std::mt19937& engine) {
  std::uniform_real_distribution<double> uniform(0.3, 3);
  Body b;
  b.name = name;
  b.mass = uniform(engine);
  b.inertia = 0.02 * uniform(engine);
  return b;
}
/// A corner or disc of a body in contact with a wall at the point `on`, which rotated by `angle` is
/// `at` in the body.
PlaneContact wall(const char* name, int of, Vec2 on, Vec2 at, double axis, double radius) {
  PlaneContact c;
  c.name = name;
  c.between = {ground, of};
  c.at = {on, at};
  c.axis = {std::cos(axis), std::sin(axis)};
  c.radius = radius;
  c.surface = 0;
  return c;
}
Vec2 turn(Vec2 p, double a) {
  return {p.x() * std::cos(a) - p.y() * std::sin(a), p.x() * std::sin(a) + p.y() * std::cos(a)};
}

/// A pinned rod on a stop (one degree of freedom), a disc in a corner, a rod that lands on both
/// ends, a row of two discs against a wall: each is in contact and approaches at the start.
Scene built(std::mt19937& engine, int trial) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Scene scene;
  auto& m = scene.mechanism;
  Surface s;
  s.name = "s";
  s.restitution = trial % 5 == 0 ? 0 : 0.5 + 0.5 * uniform(engine);
  if (trial % 7 != 0) s.friction = 0.6 + 0.6 * uniform(engine);
  m.surfaces.push_back(s);
  auto b = body("b", engine);
  const double speed = 1.5 + uniform(engine);
  switch (trial % 4) {
    case 0: {
      const Vec2 pin{0.3 * uniform(engine), 0.2}, tip{-0.4 + 0.2 * uniform(engine), 0};
      RevoluteJoint j;
      j.name = "pin";
      j.between = {ground, 0};
      j.at = {pin, pin};
      m.joints.push_back(j);
      // About the pin, so that the tip moves down: the tip is to its left.
      const double left = tip.x() - pin.x();
      b.angular_velocity = left < 0 ? speed : -speed;
      b.velocity = *b.angular_velocity * Vec2{pin.y(), -pin.x()};
      m.contacts.push_back(wall("stop", 0, tip, tip, 0, 0));
      break;
    }
    case 1: {
      const double half =
          0.4 + 0.3 * uniform(engine);  // walls at ± this from the vertical, the disc between them
      for (const double side : {1.0, -1.0}) {
        const double axis = side * (std::numbers::pi / 2 - half);
        m.contacts.push_back(
            wall(side > 0 ? "right" : "left", 0, {0, -0.05 / std::sin(half)}, {0, 0}, axis, 0.05));
      }
      b.velocity = {0.2 * speed * std::sin(half) * uniform(engine), -speed};
      b.angular_velocity = 10 * uniform(engine);
      break;
    }
    case 2:
      m.contacts.push_back(wall("left", 0, {-0.3, -0.1}, {-0.3, -0.1}, 0, 0));
      m.contacts.push_back(wall("right", 0, {0.2, -0.1}, {0.2, -0.1}, 0, 0));
      b.velocity = {speed * uniform(engine), -speed};
      b.angular_velocity = speed * uniform(engine);
      break;
    default: {
      auto other = body("c", engine);
      other.position = {0.12 * std::cos(0.9), 0.12 * std::sin(0.9)};
      other.velocity = -speed * Vec2{std::cos(0.9), std::sin(0.9)};
      m.contacts.push_back(wall("floor", 0, {0, -0.05}, {0, 0}, 0, 0.05));
      DiscContact d;
      d.name = "discs";
      d.between = {0, 1};
      d.radii = {0.05, 0.07};
      d.surface = 0;
      m.contacts.push_back(d);
      b.velocity = {0, -0.2 * speed};
      b.angular_velocity = 5 * uniform(engine);
      m.bodies = {b, other};
    }
  }
  if (m.bodies.empty()) m.bodies = {b};
  scene.run.duration = end;
  scene.run.start = RunOptions::Start::given;
  return scene;
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
