// Random scenes: their references against closed forms, and runs that earlier versions assessed
// wrongly.
#include "simulation/trajectory.hpp"
#include "verification/random_scenes/checks/checks.hpp"
#include "verification/support/named.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using namespace freeplay::verification::random_scenes;
namespace reference = freeplay::reference;

namespace {

/// A spline through points with flat ends, or periodic.
reference::CurveShape spline(std::vector<std::pair<double, double>> points, bool repeats) {
  reference::CurveShape y;
  y.kind = reference::CurveShape::Kind::spline;
  if (!repeats) y.ends = reference::CurveShape::Ends::flat;
  y.repeats = repeats;
  y.points = std::move(points);
  y.prepare();
  return y;
}

}  // namespace

TEST_CASE("reference integrator: a bouncing ball follows its parabolas", "[random-scenes]") {
  reference::OneCoordinate one;
  const double g = 9.81, drop = 0.1, e = 0.8, fall = std::sqrt(2 * drop / g);
  one.acceleration = [g](double, double, double) { return -g; };
  one.walls = {reference::MovingWall{[](double) { return reference::CurvePoint{}; }, 1, e}};
  one.x = drop;
  one.step = 1e-3;
  // The top of the first bounce: e² of the drop height, after a fall and a rise of e times its
  // duration. Constant accelerations are exact in the Runge–Kutta method; the instant of the impact
  // is bisected to rounding.
  const auto rows = one.at({fall * (1 + e)});
  REQUIRE(rows.known == 1);
  CHECK(std::abs(rows.x[0] - e * e * drop) < 1e-12);
  CHECK(std::abs(rows.v[0]) < 1e-11);
  CHECK(rows.impacts == 1);
}

TEST_CASE("reference integrator: a compliant wall delivers the given restitution", "[random-scenes]") {
  for (const double e : {1.0, 0.7, 0.3}) {
    reference::OneCoordinate one;
    one.acceleration = [](double, double, double) { return 0.0; };
    one.walls = {reference::MovingWall{[](double) { return reference::CurvePoint{}; }, 1, e, 1e6, 1.5}};
    one.x = 0.01, one.v = -1;
    one.step = 1e-3, one.step_in_contact = 1e-5;
    const auto rows = one.at({0.5});
    CHECK(std::abs(rows.v[0] - e) <
          1e-6);  // of fourth order in some thousand steps of the contact; δ^1.5 at its ends
  }
}

// A cos t against a wall at −1 with A = 1 + 1e-8, e = 1: the impact speed is 1.4e-4, without the
// wall the motion is beyond it for 2.8e-4, less than a step of 1e-3, and each impact removes 2
// arccos(1/A) of the phase.
TEST_CASE("reference integrator: grazing impacts are not missed", "[random-scenes]") {
  reference::OneCoordinate one;
  const double A = 1 + 1e-8;
  one.acceleration = [](double, double x, double) { return -x; };
  one.walls = {reference::MovingWall{[](double) { return reference::CurvePoint{-1, 0, 0}; }, 1, 1}};
  one.x = A, one.step = 1e-3;
  const double t = 10, phase = t + 2 * 2 * std::acos(1 / A);  // after two impacts
  const auto rows = one.at({t});
  REQUIRE(rows.known == 1);
  CHECK(rows.impacts == 2);
  // The phase error t h⁴/120 of the Runge–Kutta method is 8e-14, its loss of amplitude t h⁵/144
  // 7e-17; the shift alone is 5.7e-4.
  CHECK(std::abs(rows.x[0] - A * std::cos(phase)) < 1e-8);
}

// a = −1 for x > 0, else 0: from x = −1 at speed 1 the motion reverses at 1/2 and returns to 0
// after 3 s.
TEST_CASE("reference integrator: a force jump does not reduce the order", "[random-scenes]") {
  reference::OneCoordinate one;
  one.acceleration = [](double, double x, double) { return x > 0 ? -1.0 : 0.0; };
  one.kinks = {0};
  one.x = -1, one.v = 1, one.step = 0.3;
  // Constant accelerations are exact; the kink is bisected to rounding.
  const auto rows = one.at({2.5, 3.7});
  REQUIRE(rows.known == 2);
  CHECK(std::abs(rows.x[0] - 0.375) < 1e-12);
  CHECK(std::abs(rows.v[0] + 0.5) < 1e-12);
  CHECK(std::abs(rows.x[1] + 0.7) < 1e-12);
  CHECK(std::abs(rows.v[1] + 1) < 1e-12);
}

// Bounces with e = 0.69 at a position of 24 mm, the last ones lower than the rounding of the
// position: they end, and the ball stays.
TEST_CASE("reference integrator: a ball comes to rest far from zero", "[random-scenes]") {
  reference::OneCoordinate one;
  const double R = 0.0244179048971;
  one.acceleration = [](double, double, double) { return -9.81; };
  one.walls = {reference::MovingWall{[R](double) { return reference::CurvePoint{R, 0, 0}; }, 1, 0.69}};
  one.x = R + 1.4e-6, one.v = 1.2e-3, one.rest = 2e-10, one.step = 1e-6;
  const auto rows = one.at({0.01}, 20'000);
  REQUIRE(rows.known == 1);
  CHECK(rows.x[0] == R);
  CHECK(rows.v[0] == 0);
}

TEST_CASE("a column of touching bodies with one restitution bounces as one body", "[random-scenes]") {
  reference::TouchingRow row;
  row.floor = true;
  row.gravity = 9.81, row.restitution = 0.7;
  for (int i = 0; i < 5; ++i) {
    row.mass.push_back(1 + 0.3 * i), row.v.push_back(0), row.reach.push_back(0.005);
    row.x.push_back(0.05 + 0.005 + 0.01 * i);
  }
  const double fall = std::sqrt(2 * 0.05 / 9.81);
  const auto rows = row.at({1.7 * fall}, 100);
  REQUIRE(rows.known == 1);
  for (std::size_t i = 0; i < 5; ++i)
    CHECK(std::abs(rows.x[0][i] - 0.005 - 0.01 * static_cast<double>(i) - 0.49 * 0.05) < 1e-12);
}

TEST_CASE("seed, index and kinds determine a random scene", "[random-scenes]") {
  for (int i = 0; i < 20; ++i) CHECK(draw(5, i, "new").text == draw(5, i, "new").text);
  CHECK(draw(5, 1, "barrier").kind == "barrier");
  CHECK_THROWS_WITH(draw(5, 1, "heap"), Catch::Contains("there is no kind of random scene \"heap\""));
}

// Speeds that a spring causes from rest are not impacts that raise the energy: adaptive time
// stepping once stopped here for that reason at 0.14 mm/s.
TEST_CASE("a block accelerated from rest by a spring rebounds from a frictionless stop", "[random-scenes]") {
  const auto run = test::finished(read_scene(test::scene_file("tests/block_to_stop")), Family::nonsmooth);
  // From rest at A down to the stop at s: at t₁ with cos ωt₁ = s/A, then back with e times that
  // speed.
  const double A = 0.0235, s = -0.00318, w = std::sqrt(972 / 0.01875), t1 = std::acos(s / A) / w;
  const double v = 0.66 * A * w * std::sin(w * t1), t = 0.01 - t1;
  const double x = s * std::cos(w * t) + v / w * std::sin(w * t);
  // Adaptive time stepping: a hundredth of the motion, as for every row of random scenes.
  CHECK(std::abs(run.final_state.q[0] - x) < 1e-2 * A);
}

// A position that is constant up to an angle of 2.4 rad and follows a spline from there, whose
// second derivative jumps at its start and at its end, 9.5 rad. Rows between the ends of long steps
// were formerly off by 4e-3 of the lift, because the acceleration at a step's end was that after
// the knot, and at the last knot the run stopped.
TEST_CASE("a position prescribed over an angle is correct on both sides of a knot", "[random-scenes]") {
  const auto y = spline(
      {{2.4, -0.05}, {3.8, -0.06}, {5.1, -0.045}, {6.4, 0}, {7.7, -0.03}, {8.7, 0.01}, {9.5, -0.05}}, false);
  for (const auto& way : {test::event_driven, test::automatic, test::penalty, test::penalty_by("dopri5"),
                          test::penalty_by("rosenbrock4")}) {
    INFO(way.name);
    Trajectory rows;
    Simulation simulation(test::scene_by(way, test::scene_named("tests/follower_over_angle")),
                          test::name_of(way.family));
    test::finished(simulation, {&rows});
    double place = 0, rate = 0;
    const double energy = 0.5 * 1.2e-3 * 477 * 477;
    double lost = 0;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto q = rows.q(k), v = rows.v(k);
      const auto p = y.at(q[2]);
      place = std::max(place, std::abs(q[4] - p.y));
      rate = std::max(rate, std::abs(v[4] - p.slope * v[2]));
      lost = std::max(lost, std::abs(0.5 * (1.2e-3 * v[2] * v[2] + 2e-3 * v[4] * v[4]) / energy - 1));
    }
    // 1e-5 of the lift (0.07 m) and 1e-4 of its greatest speed (40 m/s), as for random scenes;
    // energy by the tolerance of 1e-9 to 1e-10 and some hundred steps.
    CHECK(place < 7e-7);
    CHECK(rate < 4e-3);
    CHECK(lost < 1e-6);
  }
}

// An implicit step replaces those that the knots leave; rows within it formerly came from the
// interpolant of an earlier step, with an error of 5e19 times a motion of 5e-7 m.
TEST_CASE("rows within an implicit step belong to that step", "[random-scenes]") {
  const auto y = spline(
      {{3.5e-4, -9.8e-8}, {6.7e-4, -3.6e-7}, {9.5e-4, 4.3e-7}, {1.22e-3, -3.7e-7}, {1.47e-3, -9.8e-8}}, true);
  Trajectory rows;
  Simulation simulation(read_scene(test::scene_file("tests/ball_on_spline")), "penalty");
  test::finished(simulation, {&rows});
  double off = 0;
  for (std::size_t k = 0; k < rows.size(); ++k)
    off = std::max(off, std::abs(rows.q(k)[1] - y.at(rows.t(k)).y));
  CHECK(off < 1e-4 * 8e-7);  // of its motion, as for random scenes in every penalty method
}

// Fixed steps formerly stopped once the speed was the rounding of the two balanced torques, "the
// forces of dampers do not converge".
TEST_CASE("fixed steps follow a damped one-sided spring to rest", "[random-scenes]") {
  const auto run = test::finished(read_scene(test::scene_file("tests/rotor_on_spring")), Family::nonsmooth);
  // Where the torques balance: the transient decays by e^(−d t/2J) = e^−70.
  CHECK(std::abs(run.final_state.q[2] - (-3.65e-4 + 3.84 / 4008)) < 1e-15);
}

// Three discs on each other fall on a floor. The upper contacts are compressed after their onset,
// whose speed, nearly zero, is that at which their damping begins. A step of bulirsch_stoer is as
// long as that.
TEST_CASE("integrators of every order detect the impacts between touching discs", "[random-scenes]") {
  std::string text =
      "format = 2\ngravity = [0, -22]\n[surfaces.s]\nyoung = 5.8e11\npoisson = 0.3\nrestitution = 0.88\n";
  for (int i = 0; i < 3; ++i) {
    text += test::body(fmt::format("d{}", i), 1.44, 3.3e-5,
                       fmt::format("position = [0, {}]\n", 0.02448 + 0.0136 * i));
    text += i == 0 ? test::plane("floor", "ground", "d0", 0.0068)
                   : test::discs(fmt::format("c{}", i - 1), fmt::format("d{}", i - 1), fmt::format("d{}", i),
                                 0.0068, 0.0068);
  }
  text += "[run]\nduration = 0.05\nstart = \"given\"\n[penalty]\nv0_floor = 8.8e-4\nintegrator = ";
  std::vector<std::vector<double>> rates;
  for (const auto* integrator : {"\"dopri5\"", "\"adams_bashforth_moulton\"", "\"bulirsch_stoer\""})
    rates.push_back(test::simulate(parse_scene(text + integrator, "column"), Family::penalty).final_state.v);
  // A thousandth of the impact speed (0.88 m/s), as for random scenes; missed impacts gave 5e-3
  // m/s.
  for (std::size_t way = 1; way < rates.size(); ++way)
    for (const std::size_t i : {1U, 4U, 7U}) CHECK(std::abs(rates[way][i] - rates[0][i]) < 1e-3 * 0.88);
}

// Half of the time that an adaptive step had left was zero in the arithmetic, and the state was not
// finite.
TEST_CASE("a run of adaptive steps ends at its end time when only rounding separates them",
          "[random-scenes]") {
  const auto run = test::finished(read_scene(test::scene_file("tests/ball_on_ramp")), Family::nonsmooth);
  const double t = 0.0122776970208;
  CHECK(run.t_end == t);
  // Free fall, which is exact to rounding in steps of second order.
  CHECK(std::abs(run.final_state.q[4] - (0.131381743105 - 0.5 * 9.81 * t * t)) < 1e-14);
}
