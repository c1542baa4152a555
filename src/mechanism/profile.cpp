#include "mechanism/profile.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"
#include "numerics/convex_hull.hpp"

namespace freeplay {
namespace {

/// Greatest |p′|/R: the polar radius then deviates by less than 0.5 % of R from the support function.
constexpr double steepest = 0.1;
/// More contacts of one joint are not formed.
constexpr std::size_t most_arcs = 64;

/// Number of samples of the turn: at least 256 of the shortest wave, or 32 between two points of a table.
std::size_t samples(const Roundness& a, const Roundness& b) {
  const double waves = CamProfile::turn / std::min(a.narrowest(), b.narrowest());
  return static_cast<std::size_t>(std::clamp(128 * waves, 4096.0, 131072.0));
}

}  // namespace

Roundness::Roundness(const Profile& profile) {
  auto& b = bounds_;
  if (!profile.points.empty()) {
    table_ = CamProfile::through(profile.points);
    const auto& steep = table_->bounds();
    b.low = INFINITY, b.high = -INFINITY;
    double last = NAN, widest = 0;
    auto& w = curvature_.emplace(std::array<double, 2>{INFINITY, -INFINITY});
    table_->each([&](double phi, const CamProfile::Value& y) {
      w = {std::min(w[0], y.h + y.d2), std::max(w[1], y.h + y.d2)};
      b.low = std::min(b.low, y.h), b.high = std::max(b.high, y.h);
      b.d3 = std::max(b.d3, std::abs(y.d3));
      if (phi > last) widest = std::max(widest, phi - last);
      last = phi;
    });
    b.d1 = steep.d1, b.d2 = steep.d2;
    const double between = 0.5 * widest * b.d1;
    b.low -= between, b.high += between;
    w[0] -= between, w[1] += between;
    narrowest_ = table_->narrowest();
    const bool level = std::ranges::all_of(
        profile.points, [&](const auto& p) { return p.second == profile.points.front().second; });
    if (level) {
      const double p = profile.points.front().second;
      b = {p, p}, w = {p, p};
    }
  }
  for (const auto& row : profile.harmonics) {
    const double n = row[0], c = row[1], s = n == 0 ? 0 : row[2], size = std::hypot(c, s);
    harmonics_.push_back({n, c, s});
    b.low += n == 0 ? c : -size;
    b.high += n == 0 ? c : size;
    b.d1 += n * size, b.d2 += n * n * size, b.d3 += n * n * n * size;
    if (n > 1 && size > 0) narrowest_ = std::min(narrowest_, CamProfile::turn / (2 * n));
  }
}

OutOfRound::OutOfRound(Roundness bearing_surface, Roundness journal_surface, double clearance,
                       double journal_radius)
    : bearing(std::move(bearing_surface)), journal(std::move(journal_surface)) {
  const auto &b = bearing.bounds(), &j = journal.bounds();
  if (std::max(b.d1, j.d1) > steepest * journal_radius) {
    refusal = "is too steep: the deviation must change by less than 0.1 of the journal's radius per rad";
    return;
  }
  const auto n = samples(bearing, journal);
  const double spacing = CamProfile::turn / static_cast<double>(n);
  // Between samples, half a spacing times the derivative.
  const double slack = 0.5 * spacing * (b.d1 + b.d3 + j.d1 + j.d3);
  const double slip = 0.5 * spacing * (b.d1 + j.d1);
  struct Least {
    double p = INFINITY, w = INFINITY;
  } outer, inner;           // of p_b and −p_j
  double crest = INFINITY;  // least p_j + p_j″
  for (std::size_t k = 0; k < n; ++k) {
    const double phi = spacing * static_cast<double>(k);
    const auto y = bearing.at(phi), x = journal.at(phi);
    outer = {std::min(outer.p, y.h), std::min(outer.w, y.h + y.d2)};
    inner = {std::min(inner.p, -x.h), std::min(inner.w, -x.h - x.d2)};
    crest = std::min(crest, x.h + x.d2);
  }
  const auto beside = [&](const Roundness& r) {
    return r.curvature() ? 0 : 0.5 * spacing * (r.bounds().d1 + r.bounds().d3);
  };
  if (const auto& w = bearing.curvature()) outer.w = (*w)[0];
  if (const auto& w = journal.curvature()) inner.w = -(*w)[1], crest = (*w)[0];
  if (!(clearance + outer.p + inner.p - slip > 0)) {
    refusal =
        "leaves no clearance: the journal must fit into the bearing at the joint's point, at every angle";
    return;
  }
  if (!(journal_radius + crest - beside(journal) > 0)) {
    refusal = "is too sharp: the journal must have a radius of curvature greater than 0 everywhere";
    return;
  }
  if (const double least = clearance + outer.w + inner.w - beside(bearing) - beside(journal); least > 0) {
    arcs.push_back({.least = least});
    return;
  }
  if (!bearing.is_round() && !journal.is_round()) {
    refusal =
        "lets the journal touch at several places that depend on the angle between both bodies, which is not "
        "described: give one of the two surfaces no profile, or smaller or longer waves";
    return;
  }
  const bool on_journal = bearing.is_round();
  const auto h_at = [&](std::size_t k) {  // h and w
    const double phi = spacing * static_cast<double>(k);
    const auto y = on_journal ? journal.at(phi) : bearing.at(phi);
    const double sign = on_journal ? -1 : 1, rest = clearance + (on_journal ? b.low : -j.low);
    return std::array{rest + sign * y.h, rest + sign * (y.h + y.d2)};
  };
  std::vector<Vec2> points(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double phi = spacing * static_cast<double>(k);
    points[k] = (1 / h_at(k)[0]) * Vec2{std::cos(phi), std::sin(phi)};
  }
  const auto vertices = convex_hull(points);
  // Runs of vertices at successive samples, counted from the first one behind a corner.
  const auto count = vertices.size();
  const auto is_corner = [&](std::size_t i) {  // between vertices i and i + 1
    return (vertices[(i + 1) % count] + n - vertices[i % count]) % n != 1;
  };
  std::size_t first = 0;
  while (first < count && !is_corner(first)) ++first;
  const char* alike =
      "is at its limit: radii of curvature of the bearing and the journal are equal where they touch; "
      "change an amplitude slightly";
  if (first == count) {
    refusal = alike;
    return;
  }
  for (std::size_t i = 1, begin = 1; i <= count; ++i) {
    if (!is_corner(first + i)) continue;
    const auto from = vertices[(first + begin) % count], to = vertices[(first + i) % count];
    const std::size_t length = (to + n - from) % n + 2;  // with one sample more at each end
    begin = i + 1;
    ContactArc arc{false, on_journal, spacing * (static_cast<double>(from) - 1), 0, INFINITY};
    arc.to = arc.from + spacing * static_cast<double>(length);
    for (std::size_t k = 0; k <= length; ++k)
      arc.least = std::min(arc.least, h_at((from + n - 1 + k) % n)[1] - slack);
    if (!(arc.least > 0)) {
      refusal = alike;
      break;
    }
    const double whole = arc.to - arc.from;
    std::vector<double> ends{arc.to};
    if (whole >= 0.999 * std::numbers::pi) ends = {arc.from + 0.3 * whole, arc.from + 0.65 * whole, arc.to};
    for (const double end : ends) {
      arc.to = end;
      arcs.push_back(arc);
      arc.from = end;
    }
    if (arcs.size() > most_arcs) {
      refusal =
          "lets the journal touch at more than 64 separate places: smooth its points, or give fewer waves";
      break;
    }
  }
  if (!refusal.empty()) arcs.clear();
}

std::optional<OutOfRound> out_of_round(const Mechanism& mechanism, const RevoluteJoint& joint) {
  if (!joint.clearance || !joint.clearance->has_profile()) return {};
  const auto& c = *joint.clearance;
  const auto surface = [&](int profile) {
    return profile < 0 ? Roundness() : Roundness(mechanism.profiles[static_cast<std::size_t>(profile)]);
  };
  OutOfRound surfaces(surface(c.bearing_profile), surface(c.journal_profile), c.radial,
                      c.bearing_radius - c.radial);
  if (!surfaces.refusal.empty())
    throw ModelError(
        "joints." + joint.name + (c.bearing_profile >= 0 ? ".bearing_profile" : ".journal_profile"),
        surfaces.refusal);
  return surfaces;
}

}  // namespace freeplay
