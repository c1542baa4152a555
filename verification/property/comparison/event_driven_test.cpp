// The event-driven scheme on a slider with clearance in its guide, against an independent
// event-driven program. The claims of "mechanisms" contain its free flight, those of "orders" the
// order of time stepping across impacts.
#include "verification/references/impact_tables.hpp"
#include "verification/references/loose_guide.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

Scene event_driven(const std::filesystem::path& file, double duration) {
  auto scene = test::read_short(file, duration);
  scene.instruments.clear();
  scene.nonsmooth.scheme = Scheme::event_driven;
  return scene;
}

void compare_corners(const Scene& scene, const std::vector<reference::CornerImpact>& impacts) {
  const auto run = test::finished(scene, Family::nonsmooth);
  const auto found = test::touches(run);
  REQUIRE(found.size() >= impacts.size());
  for (std::size_t i = 0; i < impacts.size(); ++i) {
    const auto& expected = impacts[i];
    const auto& e = found[i];
    CAPTURE(i, expected.t, expected.corner);
    REQUIRE(run.contacts.at(static_cast<std::size_t>(e.contact)).name ==
            std::string("guide.") + expected.corner);
    const double speed = -expected.v_n_minus, slide = speed + std::abs(expected.v_t_plus);
    // Tolerance 1e-10 a step; each bounce of the short slider multiplies an error by a few. Times
    // have a relative accuracy of 1e-13, and of 1e-10 s where the table's two runs differ by that.
    CHECK(e.t == Approx(expected.t).margin(2e-11 + 2e-10 * (expected.t > 0.01)).epsilon(0));
    CHECK(e.v_n_minus == Approx(expected.v_n_minus).margin(1e-7 * speed).epsilon(0));
    CHECK(e.v_n_plus == Approx(expected.v_n_plus).margin(1e-7 * speed).epsilon(0));
    CHECK(e.v_t_plus == Approx(expected.v_t_plus).margin(1e-7 * slide).epsilon(0));
    CHECK(e.impulse_n == Approx(expected.impulse_n).epsilon(1e-7));
    CHECK(e.impulse_t == Approx(expected.impulse_t).margin(1e-7 * expected.impulse_n).epsilon(0));
  }
}

}  // namespace

TEST_CASE("corners of a slider with clearance in simultaneous and single impacts with friction",
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

TEST_CASE("a slider that lands flat has an impact of both corners at any tolerance",
          "[cross][event-driven][guide]") {
  // Errors of integration tilt the slider a little: they must not turn one impact of both corners
  // into a cascade of single impacts, nor keep contacts closed that separate together (near 0.015
  // s).
  const auto& table = reference::guide_tables.front();
  auto scene = event_driven(test::source_folder() / "cases/flores2010-translational/scene.toml", 0.2);
  for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12}) {
    scene.nonsmooth.tolerance = tolerance;
    CAPTURE(tolerance);
    const auto run = test::finished(scene, Family::nonsmooth);
    const auto found = test::touches(run);
    REQUIRE(found.size() >= table.impacts.size());
    for (std::size_t i = 0; i < 6; ++i) {
      CAPTURE(i);
      // Up to a hundred steps, each with an error of the tolerance; the table has 10 digits of
      // rates.
      CHECK(found[i].t == Approx(table.impacts[i].t).epsilon(100 * tolerance + 1e-11));
      CHECK(found[i].impulse_n == Approx(table.impacts[i].impulse_n).epsilon(100 * tolerance + 1e-9));
    }
  }
}

TEST_CASE("a free slider that sticks in its impacts: tangential restitution",
          "[cross][event-driven][guide]") {
  compare_corners(event_driven(test::scene_file("free_slider"), 0.08), reference::free_slider_impacts);
}

TEST_CASE(
    "a contact that the projection returns below its friction limit keeps sticking, "
    "without a decision on all contacts",
    "[event-driven][modes]") {
  // Twenty revolutions of the rig at 40 clearances: its one contact sticks and slides a thousand
  // times each. With the error of a step, 1e-5, the instant of slip lies after or before the
  // friction limit by as much; in 7 of 40 runs all contacts were decided together from there on.
  for (int i = 0; i < 40; ++i) {
    const auto scene =
        read_scene(test::source_folder() / "cases/flores2011-attractors/scene.toml",
                   {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.tolerance=1e-5", "run.revolutions=20",
                    fmt::format("joints.gudgeon.clearance={}", 0.04e-3 + i / 39.0 * 0.96e-3)});
    const auto run = test::finished(scene, Family::nonsmooth);
    CAPTURE(i, run.notes);
    CHECK(run.notes.empty());
    CHECK(run.work.events < 20 * 300);  // 10 to 80 a revolution
  }
}

// Both formulations and the event-driven scheme on nine mechanisms (four slider-cranks, a big end
// with clearance, four-bars with clearance in one and two pins, pendulums, a free ring and
// journal), against the solutions of verification/references/impact_tables.hpp.

namespace {

/// Required accuracy of a method: the error of the time of impact i, and of its velocities and
/// impulses relative to its approach speed and normal impulse, after a flight of this length.
struct Way {
  const char* name;
  Family family;
  std::vector<std::string> keys;
  double (*time)(int i);
  double (*relative)(int i, double flight);
};
const Way ways[] = {
    // The tables have 10 to 11 digits in times and 9 in rates.
    {"event-driven",
     Family::nonsmooth,
     {"nonsmooth.scheme=\"event-driven\""},
     [](int) { return 1e-11; },
     [](int, double) { return 1e-8; }},
    // Tolerance 1e-9 of the clearance and speed per step, some hundred steps a flight, and an
    // amplification of up to ten per impact: 1e-7, 1e-6, 1e-5 of a speed. A time is a position
    // error over a speed: 1e-9 s after one impact.
    {"penalty",
     Family::penalty,
     {},
     [](int i) {
       return std::array{1e-9, 3e-9, 1e-8}[static_cast<std::size_t>(i)];
     },
     [](int i, double) { return 2e-7 * std::pow(10, i); }},
    // An impact is displaced by up to a step, and each later one inherits that: 2h per impact.
    // Velocities change over a step by about their size times h over the flight, at either end of
    // it: 4h/flight per impact so far.
    {"Moreau–Jean",
     Family::nonsmooth,
     {"nonsmooth.step=1e-6"},
     [](int i) { return 2e-6 * (i + 1); },
     [](int i, double flight) { return 4e-6 * (i + 1) / flight; }}};

}  // namespace

TEST_CASE("each method reproduces the event-driven tables of nine mechanisms", "[cross][event-driven]") {
  for (const auto& way : ways)
    for (const auto& table : reference::impact_tables) {
      auto scene = test::read_short(test::scene_file(table.scene), 0.035, way.keys);
      scene.instruments.clear();
      CAPTURE(way.name, table.scene);
      const auto run = test::finished(scene, way.family);
      const auto found = test::touches(run);
      double before = 0;
      for (int i = 0; i < 3; ++i) {
        const auto& expected = way.family == Family::penalty ? table.penalty[i] : table.nonsmooth[i];
        CAPTURE(i, expected.t);
        REQUIRE(static_cast<int>(found.size()) > i);
        const auto& e = found[i];
        REQUIRE(run.contacts.at(static_cast<std::size_t>(e.contact)).name == expected.joint);
        const double relative = way.relative(i, expected.t - before), speed = -expected.v_n_minus;
        const auto meets = [](double value, double exact, double bound) {
          CHECK(value == Approx(exact).margin(bound).epsilon(0));
        };
        meets(e.t, expected.t, way.time(i));
        meets(e.v_n_minus, expected.v_n_minus, relative * speed);
        meets(e.v_n_plus, expected.v_n_plus, relative * speed);
        meets(e.v_t_minus, expected.v_t_minus, relative * (speed + std::abs(expected.v_t_minus)));
        meets(e.impulse_n, expected.impulse_n, relative * expected.impulse_n);
        meets(e.impulse_t, expected.impulse_t, relative * expected.impulse_n);
        before = expected.t;
      }
    }
}
