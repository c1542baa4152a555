// Springs with kinks, bushings and cams in complete runs: the energy ledger, implicit and fixed
// steps, small and fast scenes.
#include "verification/support/named.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using test::penalty_by, test::event_driven, test::automatic, test::chosen_steps, test::fixed_steps;

TEST_CASE("the energy ledger closes over kinks, dampers and cams in every scheme", "[compliant]") {
  // Relative to kinetic and stored energy: tolerance times some thousand steps; for fixed steps,
  // first order in the changes at kinks.
  for (const auto& scene : {"tests/cable_and_buffer", "tests/cam_and_lever"})
    for (const auto& [way, bound] : {std::pair{test::penalty, 1e-6},
                                     {penalty_by("rosenbrock4"), 1e-5},
                                     {penalty_by("bulirsch_stoer"), 1e-6},
                                     {penalty_by("rk4"), 1e-5},
                                     {event_driven, 1e-7},
                                     {chosen_steps, 1e-3},
                                     {fixed_steps(1e-5), 1e-2}}) {
      CAPTURE(scene, way.name);
      std::vector<std::string> step;
      if (std::string(way.name) == "rk4") step = {"penalty.step=1e-6"};
      const auto l = test::finished(way, test::scene_file(scene), step).ledger;
      CHECK(std::abs(l.closure()) <= bound * l.scale());
      CHECK(l.damping >= -1e-12);  // energy dissipated by dampers
    }
}

TEST_CASE("a lever on an eccentric cam has the angle of the tangent to its circle", "[compliant]") {
  // The face passes through the lever's pivot P; the disc's centre is at e from the cam's axis, its
  // radius is ρ = base + e. The face is a tangent: its angle to the line from P to the centre is
  // asin(ρ/D).
  for (const auto& way : {event_driven, automatic, fixed_steps(1e-5)}) {
    CAPTURE(way.name);
    const auto end =
        test::finished(
            way, test::scene_file("tests/cam_and_lever"),
            {"contacts.lobe.law=harmonic", "contacts.lobe.start=1.5707963267948966",
             "contacts.lobe.rise=3.141592653589793", "contacts.lobe.dwell=0",
             "contacts.lobe.return=3.141592653589793", "bodies.cam.angular_velocity=20",
             "bodies.lever.position=[0.05, 0.0300001]", "joints.rocker.at=[[0.1, 0.0300001], [0.05, 0]]",
             "surfaces.steel.restitution=0", "drives.motor.joint=pin", "drives.motor.speed=20"})
            .final_state;
    const double e = 0.003, rho = 0.033, turn = end.q[2] + M_PI / 2;
    const Vec2 pivot{0.1, 0.0300001}, centre{-e * std::cos(turn), -e * std::sin(turn)};
    const Vec2 away = centre - pivot;
    // No lift at the start: the centre is e below the axis, and rises with the cam.
    const double expected = std::asin(rho / away.norm()) - std::atan2(-away.y(), -away.x());
    CHECK(-end.q[5] == Approx(expected).margin(2e-7));
  }
}

TEST_CASE("a follower at rest on a dwell stays at rest, on cams of any size", "[compliant]") {
  for (const double size : {1e-4, 1.0, 1e3})
    for (const auto& way : {event_driven, automatic, fixed_steps(1e-3)}) {
      CAPTURE(size, way.name);
      const auto end = test::finished(way, test::scene_file("tests/roller_on_dwell"),
                                      {fmt::format("gravity=[0, {}]", -size),
                                       fmt::format("bodies.follower.position=[0, {}]", 1.3 * size),
                                       fmt::format("joints.guide.at=[[0, {}], [0, 0]]", 1.3 * size),
                                       fmt::format("contacts.lobe.roller_radius={}", 0.3 * size),
                                       fmt::format("contacts.lobe.base_radius={}", size),
                                       fmt::format("contacts.lobe.lift={}", 0.1 * size)})
                           .final_state;
      CHECK(end.q[4] == Approx(1.3 * size).epsilon(1e-9));
      CHECK(end.v[4] == Approx(0).margin(1e-9 * size));
      CHECK(end.q[2] == Approx(0).margin(1e-9));
    }
}
