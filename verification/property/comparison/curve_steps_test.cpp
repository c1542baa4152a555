// Steps over curves of time, angle, position and speed. Every recorded row of a run is compared
// with the closed form, since a step may jump over part of a curve and still agree with it at both
// ends.
#include "verification/references/curve_shapes.hpp"
#include "verification/support/named.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

constexpr double pi = std::numbers::pi;

using test::Way, test::scene_by;

const std::vector<Way> schemes{test::automatic, test::event_driven, test::chosen_steps};
/// The schemes, and the penalty formulation with each adaptive integrator.
const auto all_ways = test::with_integrators(schemes);

test::MotionRows rows_of(const Way& way, const std::string& scene, double apart,
                         const std::vector<std::string>& options = {}) {
  return test::motion_rows(scene_by(way, test::scene_named(scene), options), way.family, apart);
}

bool doubtful(const Result& run) { return test::notes_of(run).find("warning: ") != std::string::npos; }

/// A run against a barrier of 2 J.
Result on_hill(const Way& way, const std::string& between) {
  return test::finished(way, test::scene_file("tests/slider_on_hill"), {"curves.hill.between=" + between});
}

double smooth_rise(double s) { return s * s * s * (10 + s * (-15 + 6 * s)); }

}  // namespace

TEST_CASE("curves: recorded rows of a prescribed motion lie on its curve between the ends of steps",
          "[curves]") {
  constexpr double A = 0.03, w = 2 * pi * 10;
  // Steps of time stepping are a 32nd of the period, with Hermite's cubic through their halves: an
  // error of (2π/64)⁴/384 = 2.4e-7 of the amplitude in position, and (2π/64)³/(36√12) = 8e-6 of it
  // in speed. Those of Dormand and Prince have less. The bound is a factor of ten above.
  for (const auto& way : schemes) {
    CAPTURE(way.name);
    const auto rows = rows_of(way, "tests/shaken_slider", 1e-4);
    CHECK(rows.worst([&](const auto& r) { return r.q[0] - A * std::sin(w * r.t); }) < 2.4e-6 * A);
    CHECK(rows.worst([&](const auto& r) { return r.v[0] - A * w * std::cos(w * r.t); }) < 8e-5 * A * w);
  }
}

TEST_CASE("curves: a ball on a table shaken at 60 to 500 Hz, in every scheme and without a hand-over",
          "[curves]") {
  // Amplitudes of 3 g: the ball separates from the table. Time stepping's bound as above;
  // event-driven far below it.
  for (const double f : {60.0, 200.0, 500.0})
    for (const auto& way : schemes) {
      CAPTURE(f, way.name);
      const double w = 2 * pi * f, A = 3 * 9.81 / (w * w);
      const auto text = "gravity = [0, -9.81]\n" + test::body("table", 10.0, 1.0) +
                        test::body("ball", 0.1, 4e-6, "position = [0, 0.0101]\n") +
                        test::guide("guide", "ground", "table", {0, 1}) +
                        test::plane("top", "table", "ball", 0.01, "hard") + test::surface("hard", 0.9) +
                        test::drive("shaker", "guide", "position = \"shake\"\n") +
                        fmt::format(
                            "[curves.shake]\nshape = \"harmonic\"\namplitude = {:.17g}\n"
                            "frequency = {:.17g}\n",
                            A, f) +
                        test::run_for(0.1, "discard = 0\nstart = \"assembled\"\n");
      const auto rows = test::motion_rows(scene_by(way, text), way.family, 1e-5);
      CHECK(rows.run.work.handovers == 0);
      CHECK(rows.worst([&](const auto& r) { return r.q[1] - A * std::sin(w * r.t); }) < 1e-5 * A);
      // The ball does not penetrate the table in any row: the contact is with the table at its
      // present position.
      CHECK(rows.worst([&](const auto& r) { return std::min(0.0, r.q[4] - 0.01 - A * std::sin(w * r.t)); }) <
            1e-4 * A);
    }
}

TEST_CASE("curves: a table with four discs keeps its sine through hand-overs to time stepping", "[curves]") {
  // Impacts accumulate. Steps of time stepping as in the test of rows: 2.4e-7 of the amplitude; those
  // of the event-driven scheme less. Bound: 1e-6.
  constexpr double w = 2 * pi * 40, A = 0.9 * 9.81 / (w * w);
  const auto rows = rows_of(test::automatic, "tests/shaken_discs", 1e-4);
  CHECK(rows.run.work.handovers > 0);
  CHECK(rows.run.work.stepped > 0);
  CHECK(rows.rows.size() == 10001);
  CHECK(rows.worst([&](const auto& r) { return r.q[1] - A * std::sin(w * r.t); }) < 1e-6 * A);
  CHECK(rows.worst([&](const auto& r) { return r.v[1] - A * w * std::cos(w * r.t); }) < 8e-5 * A * w);
  CHECK_FALSE(doubtful(rows.run));
}

TEST_CASE("curves: fixed steps longer than the pieces of a force curve are reported as doubtful",
          "[curves]") {
  // A step of more than a fifth of a piece does not resolve it (20 steps a period of such a row of
  // kinks); one of 0.04 m uses the mean of all its pieces, zero, and the slider passes.
  for (const double step : {0.013, 0.04, 0.1}) {
    CAPTURE(step);
    CHECK_THAT(test::notes_of(on_hill(test::fixed_steps(step), "linear")),
               Catch::Contains("warning: the curve of it deviates from a straight line"));
  }
  // a hundred steps a piece
  const auto run = on_hill(test::fixed_steps(1e-4), "linear");
  CHECK_FALSE(doubtful(run));
  // Second order: the error of the time of reversal is (100/s · 1e-4 s)² of its π/100 s.
  CHECK(run.final_state.q[0] == Approx(0.48 - (1 - 0.48 - pi / 100)).margin(1e-4).epsilon(0));
  CHECK(run.final_state.v[0] == Approx(-1).margin(1e-3).epsilon(0));
}

TEST_CASE("curves: a position prescribed over a joint's angle is on its curve in every row", "[curves]") {
  constexpr double lift = 0.03, speed = 10, start = 0.5, rise = 1.0, dwell = 0.5;
  const auto smooth = [&](double x) {
    if (x < start) return 0.0;
    if (x < start + rise) return lift * smooth_rise((x - start) / rise);
    if (x < start + rise + dwell) return lift;
    return x < start + 2 * rise + dwell ? lift * smooth_rise((start + 2 * rise + dwell - x) / rise) : 0.0;
  };
  // A spline with flat ends and symmetry: y = lift s² (3 − 2s) on either side of the middle.
  const auto spline = [&](double x) {
    const double s = std::max(0.0, 1 - std::abs(x - start - rise) / rise);
    return lift * s * s * (3 - 2 * s);
  };
  const auto check = [&](const std::vector<Way>& ways, const char* curve, const auto& y, double bound) {
    for (const auto& way : ways) {
      CAPTURE(way.name, curve);
      const auto rows =
          rows_of(way, "tests/driven_follower", 1e-4, {fmt::format("drives.cam.position={}", curve)});
      CHECK(rows.worst([&](const auto& r) { return r.q[2] - speed * r.t; }) < 1e-9);
      CHECK(rows.worst([&](const auto& r) { return r.q[4] - y(r.q[2]); }) < bound * lift);
    }
  };
  // y⁗ ≤ 360 lift: over half a 32nd of the rise the error of Hermite's cubic is 360
  // (1/64)⁴/384 = 5.6e-8 of the lift. Projection leaves a velocity error of second order, part of
  // which enters the cubic: a hundred times that.
  check(all_ways, "lift", smooth, 5.6e-6);
  // The step that passes the first knot ends 1e-4 of the rise after it, at a rate of 6e-4 lift/rise.
  // Hermite's cubic over a step of a fifth of a radian before it has an error of 4/27 · 0.2 · 6e-4 =
  // 1.8e-5 of the lift in position. The bound was set before the cause of the error was known.
  check(schemes, "spline", spline, 1.8e-5);
}

TEST_CASE("curves: a follower's spring turns a rotor back at the angle given by its energy", "[curves]") {
  // ½ J Ω² = 0.1 J against ½ k lift² = 0.45 J: the follower rises to √(2 · 0.1/1000) m = 0.0141421
  // m, and the rotor turns to the angle of that lift. Without dissipation it returns to its start
  // with −Ω.
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i)
    (0.03 * smooth_rise(0.5 * (low + high)) < std::sqrt(2 * 0.1 / 1000) ? low : high) = 0.5 * (low + high);
  const double turn = 1 + 0.5 * low;
  for (const auto& way : all_ways) {
    CAPTURE(way.name);
    const auto rows = rows_of(way, "tests/sprung_follower", 1e-4);
    // Rows miss the reversal by up to half their distance: ½ α (5e-5 s)², with α = k y y′/J < 400
    // rad/s² · 60.
    const double farthest = -rows.worst([&](const auto& r) { return std::min(0.0, -r.q[2]); });
    CHECK(-farthest == Approx(turn).margin(3e-5).epsilon(0));
    CHECK(rows.rows.back().v[2] == Approx(-10).epsilon(1e-4));
  }
}

TEST_CASE("curves: a slider does not pass a potential barrier higher than its energy",
          "[curves][integrators]") {
  // 1 J against a barrier of 2 J, whose sides do no net work. Linear between its points the force
  // increases by 20,000 N/m from 0.48 m on, so that 1 J is spent at 0.49 m, where it is 200 N; the
  // motion reverses there. With ω = 100/s, x − 0.48 = 0.01 sin ωt on the way up: a quarter of a
  // period there and one back, so that it is at 0.48 − (1 − 0.48 − π/100) m at 1 s. A spline
  // barrier reverses it elsewhere.
  for (const auto& way : all_ways)
    for (const char* between : {"linear", "spline"}) {
      CAPTURE(way.name, between);
      const auto run = on_hill(way, between);
      CHECK_FALSE(doubtful(run));
      // A hundred steps at a tolerance of 1e-9, of adaptive time steps 1e-6. The force decreases
      // just beyond the reversal: 1e-6 more energy moves it 1e-6·√… further.
      CHECK(run.final_state.v[0] == Approx(-1).margin(way.penalty() ? 1e-6 : 1e-4).epsilon(0));
      if (between[0] == 'l')
        CHECK(run.final_state.q[0] == Approx(0.48 - (1 - 0.48 - pi / 100)).margin(1e-4).epsilon(0));
    }
}

TEST_CASE("curves: the speed under a force much faster than the run is exact in every row",
          "[curves][integrators]") {
  // F sin ωt on m at rest: v = F/(m ω) (1 − cos ωt), x = F/(m ω) (t − sin ωt/ω). Time stepping's
  // speed between a step and its half has an error of (2π/64)²/8 = 1.2e-3 of the amplitude; with
  // steps of a sixteenth of a period, a cubic between the ends of an integrator's step has an error
  // of (2π/16)⁴/384 = 6e-5 of the sine.
  for (const double f : {200.0, 3000.0}) {
    const auto scene_of = [f](const Way& way) {
      auto scene = scene_by(way, test::scene_named("tests/slider_under_harmonic_force"),
                            {fmt::format("curves.push.frequency={}", f)});
      scene.run.duration = 20 / f;
      return scene;
    };
    const double w = 2 * pi * f, A = 5 / w;
    for (const auto& way : all_ways) {
      if (way.scheme == Scheme::event_driven) continue;  // same as automatic
      CAPTURE(f, way.name);
      const auto rows = test::motion_rows(scene_of(way), way.family, 0.01 / f);
      CHECK(rows.worst([&](const auto& r) { return r.v[0] - A * (1 - std::cos(w * r.t)); }) <
            (way.penalty() ? 1e-4 : 1.5e-3) * A);
      CHECK(rows.worst([&](const auto& r) { return r.q[0] - A * (r.t - std::sin(w * r.t) / w); }) <
            1e-4 * A / w);
      CHECK_FALSE(doubtful(rows.run));
    }
    auto fixed = scene_of(test::penalty_by("rk4"));
    fixed.penalty.step = 0.03 / f;
    CHECK_FALSE(doubtful(test::finished(fixed, Family::penalty)));
    fixed.penalty.step = 0.3 / f;
    CHECK_THAT(test::notes_of(test::finished(fixed, Family::penalty)),
               Catch::Contains("warning: penalty.step is 4.8 times too long"));
  }
}

TEST_CASE("curves: a slow drive beside a fast oscillator on a stop causes no hand-over", "[curves]") {
  // x = A sin φ up to the stop at 0.2 mm, e = 1: there φ jumps from θ to π − θ, and a period is
  // (π + 2θ)/ω.
  constexpr double m = 0.1, k = 1.0106e5, v = 0.45, stop = 2e-4;
  const double w = std::sqrt(k / m), A = v / w, theta = std::asin(stop / A), round = (pi + 2 * theta) / w;
  const auto rows = rows_of(test::automatic, "tests/oscillator_on_stop", 1e-4);
  CHECK(rows.run.work.handovers == 0);
  // 1e-10 at a scale of 1 m in each of at most 28,000 steps.
  CHECK(rows.worst([&](const auto& r) {
    const double phi = w * std::fmod(r.t + (pi + theta) / w, round) - (pi + theta);
    return r.q[3] - A * std::sin(phi);
  }) < 1e-4 * A);
}

TEST_CASE("curves: a kink that lies ahead of a step only by rounding counts as passed", "[curves]") {
  // A torque along a periodic spline: J ω̇ = M(t), so J (ω − ω₀) is the spline's integral. A step
  // that reached the second kink ends 7e-18 s before it, and the next step would have that length.
  const double J = 0.0206786652956, start = 0.0680438091325, until = 3.78303273198;
  reference::CurveShape push;
  push.kind = reference::CurveShape::Kind::spline;
  push.repeats = true;
  push.points = {{0.0460376270259, -0.0117869020976}, {0.0613510077807, -0.000210416995658},
                 {0.0755160247683, -0.0125836383649}, {0.0876733887138, 0.00141295823883},
                 {0.101777227997, 0.0186273146802},   {0.116641210969, 0.0170707347597},
                 {0.132371909921, -0.0355546094372},  {0.146119544348, -0.0313856839775},
                 {0.15564419159, -0.0117869020976}};
  push.prepare();
  std::string points;
  for (const auto& [x, y] : push.points)
    points += fmt::format("{}[{:.17g}, {:.17g}]", points.empty() ? "" : ", ", x, y);
  const auto scene =
      parse_scene(test::body("rotor", 1.0, J, fmt::format("angular_velocity = {:.17g}\n", start)) +
                      test::pin("on", "ground", "rotor") +
                      fmt::format(R"([curves.push]
shape = "table"
points = [{}]
between = "spline"
repeat = true
[loads.push]
type = "torque"
body = "rotor"
torque = 1.0
factor = "push"
)",
                                  points) +
                      test::run_for(until, "start = \"given\"\n") + "[nonsmooth]\nscheme = \"moreau-jean\"\n",
                  "kinks");
  const auto run = test::finished(scene, Family::nonsmooth);
  // The midpoint rule on 1/32 of a piece, extrapolated: far below 1e-5 of the greatest torque over
  // a piece.
  CHECK(run.final_state.v[2] ==
        Approx(start + push.integral(0, until, 1e-3) / J).margin(1e-5 * 0.036 * 0.015 / J).epsilon(0));
}
