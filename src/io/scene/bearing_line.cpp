#include "io/scene/bearing_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

constexpr int surface_points = 360;

SurfaceLine line_of(const Roundness& surface, const Vec2& centre, double radius, double journal_radius) {
  SurfaceLine line;
  for (int k = 0; k <= surface_points; ++k) {
    const double phi = 2 * std::numbers::pi * (k % surface_points) / surface_points;
    const auto p = surface.at(phi);
    const Vec2 n{std::cos(phi), std::sin(phi)};
    line.points.push_back(centre + (radius + p.h) * n + p.d1 * perp(n));
    line.nominal.push_back(centre + journal_radius * n);
  }
  return line;
}

}  // namespace

std::vector<Vec2> SurfaceLine::magnified(double factor, const Vec2& bearing) const {
  Vec2 centre{0, 0};
  for (std::size_t k = 0; k + 1 < nominal.size(); ++k)
    centre += nominal[k] / static_cast<double>(nominal.size() - 1);
  std::vector<Vec2> list;
  for (std::size_t k = 0; k < points.size(); ++k)
    list.push_back(nominal[k] + factor * (points[k] - nominal[k]) + (factor - 1) * (centre - bearing));
  return list;
}

std::vector<SurfaceLine> surface_lines(const Mechanism& mechanism, const RevoluteJoint& joint) {
  const auto surfaces = out_of_round(mechanism, joint);
  if (!surfaces) return {};
  const auto& c = *joint.clearance;
  const double journal = c.bearing_radius - c.radial;
  return {line_of(surfaces->bearing, joint.at[0], c.bearing_radius, journal),
          line_of(surfaces->journal, joint.at[1], journal, journal)};
}

bool has_profiles(const Mechanism& mechanism) {
  return std::ranges::any_of(mechanism.joints, [](const Joint& joint) {
    const auto* pin = std::get_if<RevoluteJoint>(&joint);
    return pin && pin->clearance && pin->clearance->has_profile();
  });
}

std::string magnified_words(double factor, bool beams, bool surfaces) {
  return fmt::format("{}{}{} × {:g}", beams ? "deflection" : "", beams && surfaces ? ", " : "",
                     surfaces ? "clearance and deviations" : "", factor);
}

}  // namespace freeplay
