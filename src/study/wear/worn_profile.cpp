#include "study/wear/worn_profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "mechanism/mechanism.hpp"
#include "numerics/convex_hull.hpp"

namespace freeplay {
namespace {

constexpr double whole_turn = 2 * std::numbers::pi;

/// The greatest (R + d) cos u − R of a segment on which d is linear from d0 at u0 to d1 at u1 (rad).
double highest(double radius, double u0, double d0, double u1, double d1) {
  const double slope = (d1 - d0) / (u1 - u0);
  const auto at = [&](double u) {
    const double half = std::sin(0.5 * u), d = d0 + slope * (u - u0);
    return d - 2 * (radius + d) * half * half;
  };
  // tan u = d'/(R + d) at the greatest value
  double u = 0.5 * (u0 + u1);
  for (int i = 0; i < 4; ++i) {
    u = std::atan(slope / (radius + d0 + slope * (u - u0)));
    u = std::clamp(u, u0, u1);
  }
  return std::max({at(u0), at(u1), at(u)});
}

/// The profile of one surface, with its share of the clearance.
struct Side {
  std::vector<double> exact, smooth;  // h (m)
  double changed = 0;                 // m
};

/// `clearance` (m): its share; `sign`: 1 for a bearing, −1 for a journal.
Side side_of(std::span<const double> form, double radius, double clearance, double sign, double corner) {
  const auto count = support_points(form.size());
  Side side{support_deviations(form, radius, count), {}, 0};
  for (auto& h : side.exact) h = clearance + sign * h;
  side.exact = convex_support(side.exact);
  const auto h = rounded_support(side.exact, corner);
  for (std::size_t k = 0; k < count; ++k) {
    side.smooth.push_back((h[(k + count - 1) % count] + 4 * h[k] + h[(k + 1) % count]) / 6);
    side.changed = std::max(side.changed, std::abs(side.smooth[k] - side.exact[k]));
  }
  return side;
}

/// The profile p = sign (h − clearance).
Profile profile_of(std::string name, const Side& side, double clearance, double sign) {
  Profile profile{.name = std::move(name), .harmonics = {}, .points = {}};
  const double step = whole_turn / static_cast<double>(side.smooth.size());
  for (std::size_t k = 0; k < side.smooth.size(); ++k)
    profile.points.emplace_back(step * static_cast<double>(k), sign * (side.smooth[k] - clearance));
  return profile;
}

bool is_level(const std::vector<double>& form) {
  return std::ranges::all_of(form, [&](double d) { return d == 0; });
}

}  // namespace

std::size_t support_points(std::size_t n) { return std::min<std::size_t>(n, 360) / 2 * 2; }

std::vector<double> support_deviations(std::span<const double> d, double radius, std::size_t count) {
  const auto n = static_cast<long>(d.size());
  const double step = whole_turn / static_cast<double>(n);
  const double most = *std::ranges::max_element(d), least = *std::ranges::min_element(d);
  // (R + d) cos u exceeds the value at u = 0 only where R (1 − cos u) < d − d(0).
  const double far = std::min(1.0, (most - least) / (radius + most));
  const auto reach = static_cast<long>(std::ceil(std::acos(1 - far) / step)) + 1;
  std::vector<double> h(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double phi = whole_turn * static_cast<double>(k) / static_cast<double>(count);
    const auto middle = static_cast<long>(std::floor(phi / step));
    double best = -INFINITY;
    for (long i = middle - reach; i <= middle + reach; ++i) {
      const auto at = [&](long place) { return d[static_cast<std::size_t>((place % n + n) % n)]; };
      const double u = step * static_cast<double>(i) - phi;
      best = std::max(best, highest(radius, u, at(i), u + step, at(i + 1)));
    }
    h[k] = best;
  }
  return h;
}

std::vector<double> convex_support(const std::vector<double>& h) {
  // The set is the polar dual of the convex hull of the points n/h.
  const auto count = h.size();
  const auto normal = [&](std::size_t k) {
    const double angle = whole_turn * static_cast<double>(k) / static_cast<double>(count);
    return Vec2{std::cos(angle), std::sin(angle)};
  };
  std::vector<Vec2> points(count);
  for (std::size_t k = 0; k < count; ++k) points[k] = (1 / h[k]) * normal(k);
  const auto vertices = convex_hull(points);
  std::vector<double> convex = h;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const auto from = vertices[i], to = vertices[(i + 1) % vertices.size()];
    const Vec2 a = points[from], edge = points[to] - a;
    for (auto k = (from + 1) % count; k != to; k = (k + 1) % count) {
      // The ray along n_k crosses the edge at the distance 1/h.
      convex[k] = cross(normal(k), edge) / cross(a, edge);
    }
  }
  return convex;
}

std::vector<double> rounded_support(const std::vector<double>& h, double radius) {
  auto eroded = h;
  for (auto& value : eroded) value -= radius;
  eroded = convex_support(eroded);
  for (auto& value : eroded) value += radius;
  return eroded;
}

WornProfiles worn_profiles(const WornBearing& worn) {
  WornProfiles profiles;
  if (!worn.bearing_worn() && !worn.journal_worn()) return profiles;
  const auto& f = worn.joint().foundation;
  const bool of_bearing = !is_level(worn.bearing_form()), of_journal = !is_level(worn.journal_form());
  const double share = of_bearing && of_journal ? 0.5 * f.clearance : f.clearance;
  const auto profile = [&](const std::vector<double>& form, double radius, double sign, const char* surface) {
    const auto side = side_of(form, radius, share, sign, corner_share * share);
    profiles.changed += side.changed;
    return profile_of(fmt::format("{}-worn-{}", worn.joint().name, surface), side, share, sign);
  };
  if (of_bearing) profiles.bearing = profile(worn.bearing_form(), f.bearing_radius, 1, "bearing");
  if (of_journal) profiles.journal = profile(worn.journal_form(), f.journal_radius(), -1, "journal");
  return profiles;
}

double set_worn(Mechanism& mechanism, const WornBearing& worn) {
  auto profiles = worn_profiles(worn);
  for (auto& joint : mechanism.joints) {
    auto* revolute = std::get_if<RevoluteJoint>(&joint);
    if (!revolute || revolute->name != worn.joint().name) continue;
    const auto set = [&](std::optional<Profile>& profile, int& index) {
      if (!profile) return;
      index = static_cast<int>(mechanism.profiles.size());
      mechanism.profiles.push_back(std::move(*profile));
    };
    set(profiles.bearing, revolute->clearance->bearing_profile);
    set(profiles.journal, revolute->clearance->journal_profile);
    return profiles.changed;
  }
  return 0;
}

}  // namespace freeplay
