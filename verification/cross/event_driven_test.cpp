// The event-driven scheme against independent event-driven programs, and time stepping against it.
#include <fmt/format.h>
#include <catch2/catch.hpp>

#include "mechanism/scene.hpp"
#include "verification/references/impact_tables.hpp"
#include "verification/references/loose_guide.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;

namespace {

Scene event_driven(const std::filesystem::path& file, double duration) {
  auto scene = read_scene(file);
  scene.run.duration = duration;
  scene.run.discard = 0;
  scene.instruments.clear();
  scene.nonsmooth.scheme = Scheme::event_driven;
  return scene;
}

void compare_corners(const Scene& scene, const std::vector<reference::CornerImpact>& impacts) {
  const auto run = test::simulate(scene, Family::nonsmooth);
  CAPTURE(run.ending.reason);
  REQUIRE(run.ending.status == Ending::Status::finished);
  const auto found = test::touches(run);
  REQUIRE(found.size() >= impacts.size());
  for (std::size_t i = 0; i < impacts.size(); ++i) {
    const auto& expected = impacts[i];
    const auto& e = found[i];
    CAPTURE(i, expected.t, expected.corner);
    REQUIRE(run.contacts.at(static_cast<std::size_t>(e.contact)).name ==
            std::string("guide.") + expected.corner);
    const double speed = -expected.v_n_minus, slide = speed + std::abs(expected.v_t_plus);
    // Tolerance 1e-10 a step; each rattle of the short slider multiplies an error by a few. Times are known
    // to 1e-13 of themselves and to 1e-10 s where the table's two runs differ by that.
    CHECK(e.t == Approx(expected.t).margin(2e-11 + 2e-10 * (expected.t > 0.01)).epsilon(0));
    CHECK(e.v_n_minus == Approx(expected.v_n_minus).margin(1e-7 * speed).epsilon(0));
    CHECK(e.v_n_plus == Approx(expected.v_n_plus).margin(1e-7 * speed).epsilon(0));
    CHECK(e.v_t_plus == Approx(expected.v_t_plus).margin(1e-7 * slide).epsilon(0));
    CHECK(e.impulse_n == Approx(expected.impulse_n).epsilon(1e-7));
    CHECK(e.impulse_t == Approx(expected.impulse_t).margin(1e-7 * expected.impulse_n).epsilon(0));
  }
}

}  // namespace

TEST_CASE("event-driven meets the tables of nine mechanisms", "[cross][event-driven]") {
  for (const auto& table : reference::impact_tables) {
    auto scene = event_driven(test::scene_file(table.scene), 0.035);
    const auto run = test::simulate(scene, Family::nonsmooth);
    CAPTURE(table.scene, run.ending.reason);
    REQUIRE(run.ending.status == Ending::Status::finished);
    const auto found = test::touches(run);
    for (int i = 0; i < 3; ++i) {
      const auto& expected = table.nonsmooth[i];
      CAPTURE(i);
      REQUIRE(run.contacts.at(static_cast<std::size_t>(found.at(i).contact)).name == expected.joint);
      // The tables have 10 to 11 digits in times and 9 in rates.
      const double speed = -expected.v_n_minus, relative = 1e-8;
      CHECK(found[i].t == Approx(expected.t).margin(1e-11).epsilon(0));
      CHECK(found[i].v_n_minus == Approx(expected.v_n_minus).margin(relative * speed).epsilon(0));
      CHECK(found[i].v_n_plus == Approx(expected.v_n_plus).margin(relative * speed).epsilon(0));
      CHECK(found[i].v_t_minus ==
            Approx(expected.v_t_minus).margin(relative * (speed + std::abs(expected.v_t_minus))).epsilon(0));
      CHECK(found[i].impulse_n == Approx(expected.impulse_n).epsilon(relative));
      CHECK(found[i].impulse_t ==
            Approx(expected.impulse_t).margin(relative * expected.impulse_n).epsilon(0));
    }
  }
}

TEST_CASE("a loose slider's corners, struck together and one by one, with friction",
          "[cross][event-driven][guide]") {
  for (const auto& table : reference::guide_tables) {
    auto scene = event_driven(test::source_folder() / "cases/flores2010-translational/scene.toml",
                              table.impacts.back().t + 1e-6);
    scene.mechanism.bodies[2].angular_velocity = table.slider_speed;
    scene.mechanism.surfaces[0].friction = table.friction;
    scene.mechanism.surfaces[0].tangential_restitution = table.e_T;
    CAPTURE(table.slider_speed, table.friction, table.e_T);
    compare_corners(scene, table.impacts);
  }
}

TEST_CASE("a slider that lands flat strikes with both corners, whatever the tolerance",
          "[cross][event-driven][guide]") {
  // Errors of integration tilt the slider a little: they must not make a cascade of single impacts of one
  // with both corners, nor keep feet closed that leave together (near 0.015 s).
  const auto& table = reference::guide_tables.front();
  auto scene = event_driven(test::source_folder() / "cases/flores2010-translational/scene.toml", 0.2);
  for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12}) {
    scene.nonsmooth.tolerance = tolerance;
    const auto run = test::simulate(scene, Family::nonsmooth);
    CAPTURE(tolerance, run.ending.reason);
    REQUIRE(run.ending.status == Ending::Status::finished);
    const auto found = test::touches(run);
    REQUIRE(found.size() >= table.impacts.size());
    for (std::size_t i = 0; i < 6; ++i) {
      CAPTURE(i);
      // Up to a hundred steps, each wrong by the tolerance; the table has 10 digits of rates.
      CHECK(found[i].t == Approx(table.impacts[i].t).epsilon(100 * tolerance + 1e-11));
      CHECK(found[i].impulse_n == Approx(table.impacts[i].impulse_n).epsilon(100 * tolerance + 1e-9));
    }
  }
}

TEST_CASE("a slider alone that sticks in its impacts: tangential restitution",
          "[cross][event-driven][guide]") {
  compare_corners(event_driven(test::scene_file("free_slider"), 0.08), reference::free_slider_impacts);
}

TEST_CASE("a loose slider in free flight: its state at 2 ms", "[cross][guide]") {
  // Two coordinates, the angles a and b of crank and rod, with k = m2 l1 l2/2 + m3 l1 l2:
  //
  //     M11 a'' + k cos(a−b) b'' = −k sin(a−b) b'² − g l1 (m1/2 + m2 + m3) cos a,
  //
  // and so on (references/loose_guide_flight.hpp has both), integrated at 1e-12 by another program.
  // The values that circulate for this scene (0.043936 turns, −0.135102, 120.824, −56.680, y/c 0.4871) are up
  // to 1.5 % off this, by what explicit Euler leaves at steps of 0.6e-5 to 8e-5 s.
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    auto scene = event_driven(test::source_folder() / "cases/flores2010-translational/scene.toml", 0.002);
    const auto end = test::simulate(scene, family).final_state;
    const auto &q = end.q, &v = end.v;
    // Tolerance 1e-9 or 1e-10 a step in units of 1 mm, some hundred steps: 1e-10 m, 1e-9 rad and rad/s
    // relative.
    CHECK(q[2] / (2 * M_PI) == Approx(0.04389404441618265).margin(1e-9).epsilon(0));
    CHECK(q[5] == Approx(-0.1349492638658336).margin(1e-9).epsilon(0));
    CHECK(v[2] == Approx(120.46388171355167).epsilon(1e-7));
    CHECK(v[5] == Approx(-56.47339414244658).epsilon(1e-7));
    CHECK(q[7] / 1e-3 == Approx(0.4943955541187525).margin(1e-6).epsilon(0));
  }
}

TEST_CASE("what the projection takes back below its bound holds on, and is not decided with all that touches",
          "[event-driven][modes]") {
  // Twenty turns of the rig at 40 clearances: its one contact sticks and slides a thousand times each. At the error of a step, 1e-5, the
  // instant at which it gives way is past or before the bound by as much, and 7 of 40 runs were decided together from there on.
  for (int i = 0; i < 40; ++i) {
    const auto scene =
        read_scene(test::source_folder() / "cases/flores2011-attractors/scene.toml",
                   {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.tolerance=1e-5", "run.revolutions=20",
                    fmt::format("joints.gudgeon.clearance={}", 0.04e-3 + i / 39.0 * 0.96e-3)});
    const auto run = test::simulate(scene, Family::nonsmooth);
    CAPTURE(i, run.notes);
    REQUIRE(run.ending.status == Ending::Status::finished);
    CHECK(run.notes.empty());
    CHECK(run.work.events < 20 * 300);  // 10 to 80 a turn
  }
}

TEST_CASE("Moreau-Jean converges to the event-driven solution with order one", "[order][event-driven]") {
  // Impact times, approach speeds and impulses of the first three impacts of the paper's scene. Where within
  // a step an impact falls is a sawtooth in h, so the order is that of the greatest error over a window of
  // steps.
  auto scene = event_driven(test::flores(), 0.0107);
  const auto exact = test::touches(test::simulate(scene, Family::nonsmooth));
  REQUIRE(exact.size() >= 3);
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  std::vector<double> steps, time, speed, impulse;
  for (const double h : {4e-6, 2e-6, 1e-6, 5e-7, 2.5e-7}) {
    double worst[3] = {0, 0, 0};
    for (int part = 0; part < 40; ++part) {
      scene.nonsmooth.step = h * (1 + 0.5 * part / 40);
      const auto found = test::touches(test::simulate(scene, Family::nonsmooth));
      REQUIRE(found.size() >= 3);
      for (int i = 0; i < 3; ++i) {
        worst[0] = std::max(worst[0], std::abs(found[i].t - exact[i].t));
        worst[1] = std::max(worst[1], std::abs(found[i].v_n_minus - exact[i].v_n_minus));
        worst[2] = std::max(worst[2], std::abs(found[i].impulse_n - exact[i].impulse_n));
      }
    }
    steps.push_back(h);
    time.push_back(worst[0]);
    speed.push_back(worst[1]);
    impulse.push_back(worst[2]);
  }
  CAPTURE(time, speed, impulse);
  for (const auto* errors : {&time, &speed, &impulse}) {
    const double p = test::observed_order(steps, *errors);
    CHECK(p > 0.9);
    CHECK(p < 1.1);
  }
}
