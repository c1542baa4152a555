#include "study/wear/worn_profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
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

/// The profile p = ±(h − share) of one surface.
struct Side {
  double share = 0;       // m, of the clearance
  std::vector<double> h;  // m
  double changed = 0;     // m, greatest change of p from the surface with the whole clearance
};

/// `rise` (m): h of a surface without clearance.
Side side_of(const std::vector<double>& rise, double clearance, double share) {
  const auto with = [&](double c) {
    auto h = rise;
    for (auto& value : h) value += c;
    return convex_support(h);
  };
  const auto exact = with(clearance), h = rounded_support(with(share), corner_share * share);
  const auto count = rise.size();
  Side side{share, {}, 0};
  for (std::size_t k = 0; k < count; ++k) {
    side.h.push_back((h[(k + count - 1) % count] + 4 * h[k] + h[(k + 1) % count]) / 6);
    side.changed = std::max(side.changed, std::abs(clearance - share + side.h[k] - exact[k]));
  }
  return side;
}

/// Those of a bearing and a journal that both deviate. Of some shares, the greater change is least.
std::array<Side, 2> sides_of(const std::vector<double>& bearing, const std::vector<double>& journal,
                             double clearance) {
  const auto pair = [&](double part) {
    return std::array{side_of(bearing, clearance, part * clearance),
                      side_of(journal, clearance, (1 - part) * clearance)};
  };
  const auto changed = [](const std::array<Side, 2>& sides) {
    return std::max(sides[0].changed, sides[1].changed);
  };
  // Of a set that its share leaves after the rounding.
  const auto fits = [&](const std::vector<double>& rise, double part) {
    return (1 - corner_share) * part * clearance + *std::ranges::min_element(rise) > 0;
  };
  auto best = pair(0.5);
  for (const double part : {0.02, 0.1, 0.2, 0.3, 0.4, 0.6, 0.7, 0.8, 0.9, 0.98}) {
    if (!fits(bearing, part) || !fits(journal, 1 - part)) continue;
    if (auto sides = pair(part); changed(sides) < changed(best)) best = std::move(sides);
  }
  return best;
}

Profile profile_of(std::string name, const Side& side, double sign) {
  Profile profile{.name = std::move(name), .harmonics = {}, .points = {}};
  const double step = whole_turn / static_cast<double>(side.h.size());
  for (std::size_t k = 0; k < side.h.size(); ++k)
    profile.points.emplace_back(step * static_cast<double>(k), sign * (side.h[k] - side.share));
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
  const auto rise_of = [](const std::vector<double>& form, double radius, double sign) {
    auto rise = support_deviations(form, radius, support_points(form.size()));
    for (auto& value : rise) value *= sign;
    return rise;
  };
  const auto add = [&](std::optional<Profile>& profile, const char* surface, const Side& side, double sign) {
    profile = profile_of(fmt::format("{}-worn-{}", worn.joint().name, surface), side, sign);
    profiles.changed += side.changed;
  };
  const bool of_bearing = !is_level(worn.bearing_form()), of_journal = !is_level(worn.journal_form());
  std::vector<double> bearing, journal;
  if (of_bearing) bearing = rise_of(worn.bearing_form(), f.bearing_radius, 1);
  if (of_journal) journal = rise_of(worn.journal_form(), f.journal_radius(), -1);
  if (of_bearing && of_journal) {
    const auto sides = sides_of(bearing, journal, f.clearance);
    add(profiles.bearing, "bearing", sides[0], 1);
    add(profiles.journal, "journal", sides[1], -1);
  } else if (of_bearing) {
    add(profiles.bearing, "bearing", side_of(bearing, f.clearance, f.clearance), 1);
  } else if (of_journal) {
    add(profiles.journal, "journal", side_of(journal, f.clearance, f.clearance), -1);
  }
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
