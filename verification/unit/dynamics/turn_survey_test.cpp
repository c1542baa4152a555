// The survey of a drive's turn against closed forms: ranges of Grashof's four-bars and of
// slider-cranks, dead centres, transmission angles; undriven motions by name.
#include "dynamics/assembly/turn_survey.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/mobility.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

constexpr double pi = std::numbers::pi;
const std::string motor = test::drive("motor", "A", "speed_rpm = 60.0\n");

std::string link(const std::string& name, double angle) {
  return test::body(name, 1.0, 0.01, fmt::format("angle = {}\n", angle));
}

/// Angles but that of the crank are rough.
const std::string rough = "format = 2\nassembly.approximate = true\n";

/// Four-bar with links d (ground), a, b, c; the crank starts at `crank`, the others at rough angles.
std::string four_bar(double d, double a, double b, double c, double crank, double coupler, double rocker,
                     const std::string& drive = motor) {
  return rough + link("crank", crank) + link("coupler", coupler) + link("rocker", rocker) +
         test::pin("A", "ground", "crank", {0, 0}, {-a / 2, 0}) +
         test::pin("B", "crank", "coupler", {a / 2, 0}, {-b / 2, 0}) +
         test::pin("C", "coupler", "rocker", {b / 2, 0}, {c / 2, 0}) +
         test::pin("D", "ground", "rocker", {d, 0}, {-c / 2, 0}) + drive + test::run_for(1.0);
}

/// Slider-crank with the guide at the height e.
std::string slider_crank(double r, double l, double e, const std::string& drive = motor) {
  return rough + link("crank", 0.1) + link("rod", 0.0) + test::body("slider", 1.0, 0.01) +
         test::pin("A", "ground", "crank", {0, 0}, {-r / 2, 0}) +
         test::pin("B", "crank", "rod", {r / 2, 0}, {-l / 2, 0}) +
         test::pin("C", "rod", "slider", {l / 2, 0}) +
         test::guide("G", "ground", "slider", {1, 0}, {0.0, e}) + drive + test::run_for(1.0);
}

std::optional<TurnSurvey> survey(const std::string& text) {
  const auto scene = parse_scene(text, "s.toml");
  return survey_turn(scene.mechanism, assemble(scene.mechanism, RunOptions::Start::ideal).q);
}

/// The distance of an angle from another, modulo full turns.
double apart(double a, double b) { return std::abs(std::remainder(a - b, 2 * pi)); }

/// Angle opposite to the side x of a triangle with sides p and q.
double opposite(double x, double p, double q) { return std::acos((p * p + q * q - x * x) / (2 * p * q)); }
double sharp(double angle) { return std::min(angle, pi - angle); }

UndrivenMotions undriven(const std::string& text) {
  const auto scene = parse_scene(text, "s.toml");
  return undriven_motions(scene.mechanism, assemble(scene.mechanism, RunOptions::Start::ideal).q);
}

/// Two links on the ground, the second at an angle.
std::string chain(double angle) {
  return "format = 2\n" + link("one", 0.0) + link("two", angle) +
         test::pin("A", "ground", "one", {}, {-0.1, 0}) + test::pin("B", "one", "two", {0.1, 0}, {-0.1, 0}) +
         test::run_for(1.0);
}

/// Crank angles of two dead centres in either order, from those by hand; the sum of both errors.
double dead_centre_error(const OutputMotion& out, double outer, double inner) {
  REQUIRE(out.dead_centres.size() == 2);
  const double first = out.dead_centres[0].angle, second = out.dead_centres[1].angle;
  return std::min(apart(first, outer) + apart(second, inner), apart(first, inner) + apart(second, outer));
}

}  // namespace

// A gap of 1e-6 of the longest arm counts as closed, and an end is located to 1e-6 of 5 degrees. An
// extremum is located by a bracket of 0.13 degrees and a parabola: its error is below the square of
// that, 5e-6 rad, times the ratio of third and second derivatives, below 10 here.
constexpr double located = 5e-5;

TEST_CASE("a crank-rocker closes over a turn, with its dead centres and transmission angles",
          "[whole-turn]") {
  const double d = 0.4, a = 0.1, b = 0.35, c = 0.3;
  const auto s = survey(four_bar(d, a, b, c, 0.4, 0.3, 1.3));
  REQUIRE(s);
  CHECK(s->full);
  CHECK(s->joint == "A");
  // Dead centres: crank and coupler in line, AC = b + a and b − a. AC is at the angle between d and
  // AC in the triangle with c; the crank points to C, or away from it.
  REQUIRE(s->outputs.size() == 1);
  const auto& out = s->outputs[0];
  CHECK(out.joint == "D");
  CHECK(dead_centre_error(out, opposite(c, d, b + a), opposite(c, d, b - a) + pi) < 2 * located);
  // Angle of the rocker DC from AD: π minus the angle at D.
  const double swing = opposite(b + a, d, c) - opposite(b - a, d, c);
  CHECK(out.travel == Approx(std::abs(swing)).margin(1e-6));
  // Transmission angle: BD is d − a with the crank at 0, and d + a at π.
  REQUIRE(s->transmission.size() == 1);
  const auto& mu = s->transmission[0];
  const double at_0 = sharp(opposite(d - a, b, c)), at_pi = sharp(opposite(d + a, b, c));
  CHECK(mu.joint == "C");
  CHECK(mu.least.value == Approx(std::min(at_0, at_pi)).margin(1e-6));
  CHECK(apart(mu.least.angle, at_0 < at_pi ? 0 : pi) < located);
  // It passes a right angle, where BD² = b² + c².
  CHECK(mu.greatest.value == Approx(pi / 2).margin(1e-3));
}

TEST_CASE("a double-rocker's drive is limited by its output links in line", "[whole-turn]") {
  // s + l > p + q: the input ends where coupler and output are in line, at either side of AD.
  const double d = 0.5, a = 0.3, b = 0.25, c = 0.3, last = opposite(b + c, a, d);
  const auto s = survey(four_bar(d, a, b, c, 1.0, 0.2, 2.0));
  REQUIRE(s);
  CHECK_FALSE(s->full);
  CHECK(s->upper == Approx(last).margin(located));
  CHECK(s->lower == Approx(-last).margin(located));
  REQUIRE(s->above);
  REQUIRE(s->below);
  REQUIRE(s->transmission.size() == 1);
  // In line at the limits: a gap of 1e-6 is an angle of the order of √1e-6.
  CHECK(s->transmission[0].least.value < 5e-3);
}

TEST_CASE("a double-crank turns its output fully, without dead centres", "[whole-turn]") {
  // Grashof: the ground d is the shortest link and 0.1 + 0.3 < 0.25 + 0.28, so a and c turn fully.
  const double d = 0.1, a = 0.3, b = 0.25, c = 0.28;
  const auto s = survey(four_bar(d, a, b, c, 0.5, 2.0, 1.0));  // last three: angles of the start
  REQUIRE(s);
  CHECK(s->full);
  REQUIRE(s->outputs.size() == 1);
  CHECK(s->outputs[0].dead_centres.empty());
  CHECK(s->outputs[0].turns == Approx(1));
}

TEST_CASE("slider-cranks have the range, dead centres and transmission angles of their triangle",
          "[whole-turn]") {
  const double r = 0.05, l = 0.12, e = 0.02;
  for (const auto& drive : {motor, test::drive("motor", "A", "torque = 1.0\n")}) {
    const auto s = survey(slider_crank(r, l, e, drive));
    REQUIRE(s);
    CHECK(s->full);
    REQUIRE(s->outputs.size() == 1);
    const auto& out = s->outputs[0];
    CHECK(out.slides);
    // Crank and rod in line: sin φ = e/(l + r), and sin(φ − π) = e/(l − r).
    CHECK(dead_centre_error(out, std::asin(e / (l + r)), pi + std::asin(e / (l - r))) < 2 * located);
    CHECK(out.travel ==
          Approx(std::sqrt((l + r) * (l + r) - e * e) - std::sqrt((l - r) * (l - r) - e * e)).margin(1e-8));
    // cos μ = |r sin φ − e|/l.
    REQUIRE(s->transmission.size() == 1);
    const auto& mu = s->transmission[0];
    CHECK(mu.least.value == Approx(std::acos((r + e) / l)).margin(1e-8));
    CHECK(apart(mu.least.angle, -pi / 2) < located);
    CHECK(mu.greatest.value == Approx(pi / 2).margin(1e-3));  // where r sin φ = e
  }
  const auto limited = survey(slider_crank(0.05, 0.04, 0));
  REQUIRE(limited);
  CHECK_FALSE(limited->full);
  CHECK(limited->upper == Approx(std::asin(0.8)).margin(located));
  CHECK(limited->lower == Approx(-std::asin(0.8)).margin(located));
}

TEST_CASE("no turn is surveyed without a drive, and chains are followed without outputs", "[whole-turn]") {
  CHECK_FALSE(survey(slider_crank(0.05, 0.12, 0, "")));
  const auto s = survey(chain(0) + motor);
  REQUIRE(s);
  CHECK(s->full);
  CHECK(s->outputs.empty());
  CHECK(s->transmission.empty());
}

TEST_CASE("undriven motions are named by independent joint coordinates", "[whole-turn]") {
  const std::vector<std::string> elbow{"rotation at B"}, all{"rotation at A", "rotation at B"};
  CHECK(undriven(chain(0.5) + motor).coordinates == elbow);
  CHECK(undriven(chain(0.5) + motor).bodies == std::vector<int>{1});
  CHECK(undriven(chain(0.5)).coordinates == all);
  // A closed loop has one coordinate.
  CHECK(undriven(slider_crank(0.05, 0.12, 0, "")).coordinates == std::vector<std::string>{"rotation at A"});
  CHECK(undriven(slider_crank(0.05, 0.12, 0)).coordinates.empty());
  // A block on a guide, and a free body.
  const auto free = undriven("format = 2\n" + test::body("block", 1.0, 0.01) + test::body("disc", 1.0, 0.01) +
                             test::guide("G", "ground", "block") + test::run_for(1.0));
  CHECK(free.coordinates ==
        std::vector<std::string>{"sliding at G", "x of disc", "y of disc", "theta of disc"});
}
