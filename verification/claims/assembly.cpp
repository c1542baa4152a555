// Assembly of mechanisms: poses of both branches of a four-bar against Freudenstein's equation, and
// the branch after turns of the crank, by every scheme.
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/four_bar.hpp"
#include "dynamics/planar.hpp"
#include "io/scene/write_scene.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/four_bar_pose.hpp"
#include "verification/references/pendulum.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

constexpr double d = 0.4, a = 0.1, b = 0.35, c = 0.3;  // m, of cases/four-bar

Scene four_bar(const char* branch, double degrees) {
  return read_scene(
      test::source_folder() / "cases/four-bar/scene.toml",
      {fmt::format("assembly.branch={}", branch), fmt::format("drives.motor.initial_angle={} deg", degrees)});
}
double apart(double angle, double other) { return std::abs(std::remainder(angle - other, 2 * M_PI)); }

void poses(Findings& f) {
  for (const bool open : {true, false}) {
    double worst = 0;
    for (int degrees = 5; degrees < 180; degrees += 5) {
      const auto scene = four_bar(open ? "open" : "crossed", degrees);
      const auto s = assemble(scene.mechanism, RunOptions::Start::ideal);
      const auto exact = reference::four_bar_pose(d, a, b, c, degrees * M_PI / 180, open);
      worst = greatest(worst, apart(planar::angle(s.q.data(), 1), exact.coupler));
      worst = greatest(worst, apart(planar::angle(s.q.data(), 2), exact.rocker));
    }
    f.at_most(claim_name(open ? "four-bar assembled open" : "four-bar assembled crossed",
                         "angles of coupler and rocker, greatest error, crank at 5° to 175°"),
              "rad", worst, 1e-11, "Freudenstein's equation",
              "loop closure to 1e-14 of the length; angles err by at most 1/sin of the transmission angle, "
              "above 30°");
  }
}

/// With ideal joints the pose is a function of the crank angle alone, so that the error of a scheme
/// is its drift.
void driven_turn(Findings& f) {
  const struct {
    test::Way way;
    double bound;
    const char* reason;
  } hows[] = {
      {{"penalty", Family::penalty, {}, 0, {"penalty.alpha=50", "penalty.beta=50"}},
       1e-6,
       "tolerance 1e-9 per step, drift during 0.4 s bounded by Baumgarte stabilisation at 50 1/s"},
      {test::fixed_steps(1e-4, "Moreau–Jean, h = 1e-4 s"), 1e-9, "positions are projected at each step"},
      {test::event_driven, 1e-8, "tolerance 1e-10 per step, positions are projected"},
      {test::automatic, 1e-8, "tolerance 1e-10 per step, positions are projected"}};
  for (const auto& [way, bound, reason] : hows)
    for (const bool open : {true, false}) {
      auto set = way.options;
      set.push_back(fmt::format("assembly.branch={}", open ? "open" : "crossed"));
      set.push_back("run.revolutions=1.2");
      auto scene = read_scene(test::source_folder() / "cases/four-bar/scene.toml", set);
      way.choose(scene);
      scene.mechanism = idealised(scene.mechanism);
      const auto end = test::simulate(scene, way.family).final_state;
      const auto exact = reference::four_bar_pose(d, a, b, c, M_PI / 2 + 1.2 * 2 * M_PI, open);
      f.within(claim_name(open ? "four-bar assembled open" : "four-bar assembled crossed",
                          "rocker angle after 1.2 turns of the crank", way.name),
               "rad", std::remainder(planar::angle(end.q.data(), 2), 2 * M_PI),
               std::remainder(exact.rocker, 2 * M_PI), bound, "Freudenstein's equation", reason);
    }
}

void released_pendulum(Findings& f) {
  const reference::Pendulum p{1, 0.03, 0.3, 9.81, M_PI / 2};
  const double quarter = reference::pendulum_period(p) / 4;
  for (const auto& [name, family, scheme, bound, reason] :
       {std::tuple{"penalty", Family::penalty, "automatic", 1e-7,
                   "tolerance 1e-9 per step over some hundred steps"},
        {"event-driven", Family::nonsmooth, "event-driven", 1e-8, "tolerance 1e-10 per step"},
        {"Moreau–Jean, h = 1e-5 s", Family::nonsmooth, "moreau-jean", 1e-4,
         "half a step at 7 rad/s is 3.5e-5 rad"}}) {
    auto scene = read_scene(test::source_folder() / "cases/pendulum/scene.toml",
                            {fmt::format("nonsmooth.scheme={}", scheme)});
    if (scene.nonsmooth.scheme == Scheme::moreau_jean) scene.nonsmooth.step = 1e-5;
    scene.run.duration = quarter;
    const auto end = test::simulate(scene, family).final_state;
    f.within(claim_name("pendulum released horizontally", "angle after a quarter of its period", name), "rad",
             planar::angle(end.q.data(), 0), -M_PI / 2, bound, "vertical after T/4, T = 4 K(sin 45°)/ω₀",
             reason);
  }
}

void units_and_named_points(Findings& f) {
  // The scene of the double pendulum uses mm, kg cm², degrees and named points.
  auto scene = read_scene(test::source_folder() / "cases/double-pendulum/scene.toml");
  auto plain = scene;
  plain.mechanism.bodies[0].inertia = 35.325e-4;
  plain.mechanism.bodies[0].angle = -30 * M_PI / 180;
  plain.mechanism.bodies[1].inertia = 20.442708333e-4;
  plain.mechanism.bodies[1].angle = -110 * M_PI / 180;
  auto& pivot = std::get<RevoluteJoint>(plain.mechanism.joints[0]);
  pivot.at = {Vec2{0, 0}, Vec2{0 - 0.15, 0}};
  auto& elbow = std::get<RevoluteJoint>(plain.mechanism.joints[1]);
  elbow.at = {Vec2{0.3 - 0.15, 0}, Vec2{0 - 0.125, 0}};
  elbow.clearance->radial = 0.3e-3;
  elbow.clearance->bearing_radius = 8e-3;
  plain.mechanism.surfaces[0].young = 207e9;
  f.at_most("double pendulum in units with named points: mismatch with the scene in SI units and coordinates",
            "", first_difference(to_toml(scene), to_toml(plain)).empty() ? 0 : 1, 0, "equal scenes",
            "exact, bit for bit: decimal units shift the digits before conversion");
}

}  // namespace

Parts assembly() { return {poses, driven_turn, released_pendulum, units_and_named_points}; }

}  // namespace freeplay::verification
