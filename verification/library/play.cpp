// Ranges of the rocker of a four-bar within the clearances of its coupler's pins, and the clearances of least
// cost for a range. The exit status is the number of failed checks.
#include <freeplay.hpp>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace {

int failures = 0;
void expect(bool holds, const char* what) {
  std::printf("%s: %s\n", holds ? "ok" : "FAILED", what);
  failures += !holds;
}

const char* const four_bar = R"(
format = 2
[bodies.crank]
mass = 1
inertia = 0.01
points = { shaft = [-0.05, 0], pin = [0.05, 0] }
[bodies.coupler]
mass = 1
inertia = 0.01
angle = "32 deg"
points = { B = [-0.15, 0], C = [0.15, 0] }
[bodies.rocker]
mass = 1
inertia = 0.01
angle = "101 deg"
points = { pivot = [-0.125, 0], pin = [0.125, 0] }
[joints.A]
type = "revolute"
between = ["ground", "crank"]
at = [[0, 0], "shaft"]
[joints.B]
type = "revolute"
between = ["crank", "coupler"]
at = ["pin", "B"]
clearance = "0.1 mm"
bearing_radius = "5 mm"
surface = "steel"
[joints.C]
type = "revolute"
between = ["coupler", "rocker"]
at = ["C", "pin"]
clearance = "0.1 mm"
bearing_radius = "5 mm"
surface = "steel"
[joints.D]
type = "revolute"
between = ["ground", "rocker"]
at = [[0.35, 0], "pivot"]
[surfaces.steel]
restitution = 0.5
[drives.motor]
joint = "A"
speed = 1
initial_angle = "60 deg"
[assembly]
approximate = true
[run]
duration = 0.01
)";

/// The angle of the rocker if the coupler has the length l.
double rocker_angle(double crank, double l) {
  const double x = 0.1 * std::cos(crank) - 0.35, y = 0.1 * std::sin(crank), d = std::hypot(x, y);
  return std::atan2(y, x) - std::acos((d * d + 0.25 * 0.25 - l * l) / (2 * 0.25 * d));
}

}  // namespace

int main() {
  const auto scene = freeplay::parse_scene(four_bar, "four-bar");
  const freeplay::PlayOptions options{
      .quantities = {"rocker.theta"}, .over = "A", .from = 0, .to = std::numbers::pi, .points = 7};
  const auto play = freeplay::find_play(scene, options);
  for (const auto& p : play.positions) {
    if (!p.refusal.empty()) continue;
    const auto& range = p.ranges[0];
    std::printf("%.4f rad: %.9f mrad\n", p.coordinate, 1e3 * range.width());
    for (const auto& [joint, part] : freeplay::by_joint(play, range.parts))
      std::printf("  %s: %.3f mrad\n", joint.c_str(), 1e3 * part);
  }
  for (const auto& sentence : freeplay::verdicts(play)) std::printf("%s\n", sentence.c_str());

  for (const auto& p : play.positions) {
    const double width = rocker_angle(p.coordinate, 0.2998) - rocker_angle(p.coordinate, 0.3002);
    expect(p.refusal.empty(), "a range");
    // Half of the digit 1e-9 mrad.
    expect(std::abs(std::abs(width) - p.ranges[0].width()) < 5e-13, "the closed form");
  }

  const auto found = freeplay::allocate_clearances(
      scene, options, 1e-3,
      {{.joint = "B", .cost = 4, .least = 1e-6, .greatest = 1e-3},
       {.joint = "C", .cost = 1, .least = 1e-6, .greatest = 1e-3}});
  for (const auto& c : found.clearances)
    std::printf("%s: %.4g m, cost %.4g\n", c.joint.c_str(), c.after, c.cost);
  // Costs 4/c_B + 1/c_C of equal influences are least with c_B = 2 c_C.
  expect(std::abs(found.clearances[0].after / found.clearances[1].after - 2) < 1e-6, "the ratio of the clearances");
  return failures;
}
