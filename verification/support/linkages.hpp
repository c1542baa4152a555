// Random linkages for measurements of the default scheme: crank-rockers with clearance in one to
// three joints, at 30 to 600 rpm.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "values/vec2.hpp"
#include "verification/support/scene_text.hpp"

namespace freeplay::verification {

/// A scene: a four-bar by Grashof's rule (the crank is the shortest link; shortest + longest < the
/// other two), of bars of 1 to 5 kg/m,
/// over one revolution of its crank from the ideal joints' start. Clearances are 3e-4 to 1e-2 of
/// the crank, e is 0.1 to 0.9, most have
/// friction and weight.
inline std::string random_linkage(std::uint64_t index) {
  std::mt19937_64 engine(20260000 + index);
  const auto between = [&](double a, double b) {
    return a + (b - a) * static_cast<double>(engine() >> 11) * 0x1p-53;
  };
  const auto decades = [&](double a, double b) { return std::pow(10, between(a, b)); };
  const double crank = between(0.03, 0.1);
  double coupler = 0, rocker = 0, base = 0;
  do {
    coupler = crank * between(2, 5);
    rocker = crank * between(1.5, 4);
    base = crank * between(1.5, 4.5);
  } while (2 * std::max({coupler, rocker, base}) > coupler + rocker + base - 1.2 * crank);
  std::string text = between(0, 1) < 0.7 ? "gravity = [0.0, -9.81]\n" : "";
  text += fmt::format("[surfaces.s]\nrestitution = {:.4f}\n", between(0.1, 0.9));
  if (between(0, 1) < 0.7) text += fmt::format("friction = {:.4f}\n", decades(-2, -0.7));
  // Circles about the crank pin and the rocker's pivot intersect.
  const double angle = between(0, 2 * std::numbers::pi);
  const Vec2 pin = crank * Vec2{std::cos(angle), std::sin(angle)}, pivot{base, 0}, d = pivot - pin;
  const double s = d.norm(), along = (s * s + coupler * coupler - rocker * rocker) / (2 * s),
               up = std::sqrt(coupler * coupler - along * along);
  const Vec2 end = pin + (along / s) * d + (up / s) * Vec2{-d.y(), d.x()};
  const auto bar = [&](const char* name, Vec2 from, Vec2 to) {
    const double length = (to - from).norm(), mass = length * between(1, 5);
    const Vec2 middle = 0.5 * (from + to);
    text += fmt::format(
        "[bodies.{}]\nmass = {:.17g}\ninertia = {:.17g}\nposition = [{:.17g}, {:.17g}]\nangle = {:.17g}\n",
        name, mass, mass * length * length / 12, middle.x(), middle.y(),
        std::atan2(to.y() - from.y(), to.x() - from.x()));
  };
  bar("crank", {0, 0}, pin);
  bar("coupler", pin, end);
  bar("rocker", pivot, end);
  std::vector<bool> clearance_joint(3);
  for (int missing = 1 + static_cast<int>(between(0, 3)); missing > 0;) {
    const auto which = static_cast<std::size_t>(between(0, 3));
    missing -= !clearance_joint[which];
    clearance_joint[which] = true;
  }
  const auto joint = [&](const char* name, const char* of, double at, double on) {
    text += fmt::format(
        "[joints.{}]\ntype = \"revolute\"\nbetween = [{}]\nat = [[{:.17g}, 0.0], [{:.17g}, 0.0]]\n", name, of,
        at, on);
  };
  const auto play = [&](std::size_t which) {
    const double c = crank * decades(-3.5, -2);
    if (clearance_joint[which])
      text +=
          fmt::format("clearance = {:.17g}\nbearing_radius = {:.17g}\nsurface = \"s\"\n", c, 0.15 * crank);
  };
  joint("main", R"("ground", "crank")", 0, -0.5 * crank);
  joint("crank_pin", R"("crank", "coupler")", 0.5 * crank, -0.5 * coupler);
  play(0);
  joint("rocker_pin", R"("coupler", "rocker")", 0.5 * coupler, 0.5 * rocker);
  play(1);
  joint("pivot", R"("ground", "rocker")", base, -0.5 * rocker);
  play(2);
  const double rpm = 30 * std::pow(20, between(0, 1));
  return text + test::drive("motor", "main", fmt::format("speed_rpm = {:.17g}\n", rpm)) +
         "[run]\nrevolutions = 1\nstart = \"ideal\"\n";
}

}  // namespace freeplay::verification
