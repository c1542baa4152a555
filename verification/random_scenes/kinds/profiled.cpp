// Journals in bearings of which one or both are not round: bounces, sliding and rolling, and rest on both sides of
// a pocket.
#include "verification/random_scenes/draft.hpp"
#include "verification/references/profiled_journal.hpp"

namespace freeplay::verification::random_scenes {
namespace {

using reference::Change;
using reference::OneCoordinate;
using reference::ProfiledJournal;
using reference::SurfaceDeviation;
using std::numbers::pi;

/// A deviation with the keys of its table.
struct DrawnProfile {
  SurfaceDeviation surface;
  std::string lines;
};

using Harmonics = std::vector<std::array<double, 3>>;
DrawnProfile profile_of(Harmonics rows, double scale) {
  std::string list;
  for (auto& [n, cosine, sine] : rows) {
    cosine = exact(scale * cosine), sine = exact(scale * sine);
    list += toml("{}[{}, {}, {}]", list.empty() ? "" : ", ", n, cosine, sine);
  }
  return {SurfaceDeviation(std::move(rows)), toml("harmonics = [{}]\n", list)};
}
using ProfilePoints = std::vector<std::pair<double, double>>;
DrawnProfile profile_of(ProfilePoints points, double scale) {
  std::string list;
  for (auto& [angle, p] : points) {
    p = exact(scale * p);
    list += toml("{}[{}, {}]", list.empty() ? "" : ", ", angle, p);
  }
  return {SurfaceDeviation({}, std::move(points)), toml("points = [{}]\n", list)};
}

Harmonics lobes(int n, double from) { return {{double(n), std::cos(n * from), std::sin(n * from)}}; }
/// cos¹⁶((φ − from)/2) = 2⁻¹⁶ (C(16, 8) + 2 Σ C(16, 8 − k) cos k(φ − from)).
Harmonics pocket(double from) {
  constexpr double binomial[] = {12870, 11440, 8008, 4368, 1820, 560, 120, 16, 1};
  Harmonics rows;
  for (int k = 0; k <= 8; ++k) {
    const double size = (k == 0 ? 1 : 2) * binomial[k] / 65536;
    rows.push_back({double(k), size * std::cos(k * from), size * std::sin(k * from)});
  }
  return rows;
}

/// The factor of a shape by which the radii of curvature of both surfaces differ by c − `share` c or more, and by
/// which it is at most 0.4 c. `side`: −1 for a journal.
double fitting(const SurfaceDeviation& shape, double side, double share, double c) {
  double least = 0, greatest = 0;
  for (int k = 0; k < 3600; ++k) {
    const auto y = shape.at(2 * pi * k / 3600);
    least = std::min(least, side * (y.p + y.bend)), greatest = std::max(greatest, std::abs(y.p));
  }
  return std::min(share * c / -least, 0.4 * c / greatest);
}

/// A profile with which the journal touches in one place.
DrawnProfile draw_smooth(Draw& draw, double side, double share, double c) {
  if (draw.chance(0.3)) {  // a table through irregular points
    const int n = draw.whole(6, 14);
    ProfilePoints points;
    for (int k = 0; k < n; ++k)
      points.emplace_back(exact(2 * pi * (k + draw.either_way(0.2)) / n), draw.either_way(1));
    const SurfaceDeviation shape({}, points);
    return profile_of(points, fitting(shape, side, share, c));
  }
  Harmonics rows;
  if (draw.chance(0.6)) {
    rows = lobes(draw.whole(2, 5), draw.angle());
  } else {
    for (int k = 0; k < 4; ++k) {
      const double n = draw.whole(1, 9), from = draw.angle(),
                   size = draw.between(0.2, 1) / std::max(n * n - 1, 1.0);
      rows.push_back({n, size * std::cos(from), size * std::sin(from)});
    }
  }
  const SurfaceDeviation shape(rows);
  return profile_of(rows, fitting(shape, side, share, c));
}

/// Lobes so deep that the journal touches between them on two sides: a (n² − 1) > c.
double deep(Draw& draw, int n, double c) { return c * draw.between(1.5, n == 2 ? 1.8 : 3) / (n * n - 1); }

/// Coordinates of the reference, as rows of the scene.
void derive(Draft& out, std::size_t first, const std::vector<int>& coordinates, const ProfiledJournal& rigid,
            const ProfiledJournal& soft) {
  for (const int i : coordinates)
    out.scene.derived.push_back(
        {first + static_cast<std::size_t>(i) % 3,
         [rigid, soft, i](Family family, const std::vector<double>& instants, const Change& change) {
           auto scaled = change;
           if (i % 3 == 2) scaled.x *= rigid.clearance, scaled.v *= rigid.clearance;
           const auto found = (family == Family::penalty ? soft : rigid).under(scaled).rows(instants);
           OneCoordinate::Rows list;
           list.known = found.states.size();
           for (const auto& s : found.states) {
             list.x.push_back(s.q[static_cast<std::size_t>(i)]);
             list.v.push_back(s.v[static_cast<std::size_t>(i)]);
           }
           return list;
         }});
}

/// A time between two onsets, at most three of them before it, so that none follows another within 0.02 T. The
/// motion of a reference that ends earlier is compared up to its last onset.
double end_of(const ProfiledJournal::Rows& found, std::size_t instants, double T, double until) {
  const auto& on = found.onsets;
  for (std::size_t k = 1; k < on.size(); ++k)
    if (on[k] - on[k - 1] < 0.02 * T) return k > 1 ? 0.5 * (on[k - 2] + on[k - 1]) : 0.8 * on[0];
  if (on.size() > 3) return 0.5 * (on[2] + on[3]);
  return found.states.size() < instants && !on.empty() ? 0.9 * on.back() : until;
}

/// A journal that is thrown within a bearing: of the ground, on a rotor, driven or not, or free.
void thrown_journal(Draw& draw, Draft& out, bool slides) {
  const double R = exact(draw.decades(-2.5, -0.5)), c = exact(R * draw.decades(-3.5, -1.5));
  const double V = exact(c * draw.decades(0, 4)), T = c / V;
  const double e = slides ? 0 : exact(draw.chance(0.3) ? 1 : draw.between(0.2, 0.97));
  const double mu = draw.chance(0.6) ? exact(draw.between(0.02, 0.4)) : 0;
  ProfiledJournal one;
  one.clearance = c, one.radius = R, one.restitution = e, one.friction = mu, one.rest = 1e-7 * V;

  std::string keys = toml("clearance = {}\nbearing_radius = {}\nsurface = 's'\n", c, R), tables;
  const auto use = [&](bool journal, const DrawnProfile& drawn) {
    (journal ? one.journal : one.bearing) = drawn.surface;
    keys += toml("{}_profile = '{}'\n", journal ? "journal" : "bearing", journal ? "j" : "b");
    tables += toml("[profiles.{}]\n{}", journal ? "j" : "b", drawn.lines);
  };
  const int which = draw.whole(0, slides ? 2 : 4);  // bearing, journal, both; several contacts
  if (which <= 2) {
    const double share = draw.between(0.2, 0.85) * (which == 2 ? 0.5 : 1);
    if (which != 1) use(false, draw_smooth(draw, 1, share, c));
    if (which != 0) use(true, draw_smooth(draw, -1, share, c));
  } else if (which == 3 && draw.chance(0.4)) {
    use(false, profile_of(pocket(draw.angle()), draw.between(0.3, 0.6) * c));
    // The arc around a single pocket is cut: twice the stiffness near the cuts.
    out.scene.penalty = false;
  } else {
    const int n = draw.whole(2, 5);
    use(which == 4, profile_of(lobes(n, draw.angle()), deep(draw, n, c)));
  }

  const int carrier = draw.whole(0, 3);  // ground, driven rotor, rotor, free ring
  const bool falls = carrier < 3 && draw.chance(slides ? 0.7 : 0.4);
  if (falls) {
    const double g = V * V / c * draw.decades(-1, 0), down = draw.angle();
    one.gravity = {exact(g * std::cos(down)), exact(g * std::sin(down))};
    out.gravity({one.gravity.x, one.gravity.y});
  }
  // Centres away from the bodies' centres of mass, by clearances or radii; spins by which a wave passes, or the
  // surface moves, in the time of a flight.
  const bool far = draw.chance(0.3);
  const double arm = far ? R : c;
  const auto spin = [&] { return exact((far || draw.chance(0.5) ? V / R : 1 / T) * draw.either_way(1)); };
  const auto off = [&] {
    const Vec2 a = draw.chance(0.5) ? Vec2{0, 0} : draw.along(arm * draw.between(0.1, 0.4));
    return Vec2{exact(a.x()), exact(a.y())};
  };
  const double m = exact(draw.decades(-2, 1)), M = exact(m * draw.decades(-1, 1));
  DraftBody ring{.name = "ring", .mass = M, .inertia = exact(M * R * R * draw.between(0.5, 1.5))};
  DraftBody pin{.name = "pin", .mass = m, .inertia = exact(m * R * R * draw.between(0.4, 1))};
  const Vec2 of_ring = off(), of_pin = off();
  if (carrier > 0) ring.angle = exact(draw.angle()), ring.spin = spin();
  if (carrier == 3) ring.velocity = {exact(V * draw.either_way(0.3)), exact(V * draw.either_way(0.3))};
  pin.angle = exact(draw.angle()), pin.spin = spin();
  // All surfaces leave a clearance of 0.2 c.
  const Vec2 centre = ring.world(of_ring) + draw.along(0.15 * c), away = DraftBody::turned(of_pin, pin.angle);
  pin.at = {exact(centre.x() - away.x()), exact(centre.y() - away.y())};
  const Vec2 speed = ring.velocity_of(of_ring) + draw.along(V * draw.between(0.5, 1)) - pin.spin * perp(away);
  pin.velocity = {exact(speed.x()), exact(speed.y())};

  std::size_t at = 0;
  if (carrier > 0) {
    at = out.body(ring);
    if (carrier < 3) out.joint("revolute", "ground", "ring", {0, 0}, {0, 0});
    if (carrier == 1)
      out.drive(out.last_joint(), toml("speed = {}\ninitial_angle = {}\n", ring.spin, ring.angle));
  }
  const auto q = out.body(pin);
  out.joint("revolute", carrier > 0 ? "ring" : "ground", "pin", of_ring, of_pin, keys);
  out.text += tables;
  one.arms = {{{of_ring.x(), of_ring.y()}, {of_pin.x(), of_pin.y()}}};
  one.start.q = {0, 0, ring.angle, pin.at.x(), pin.at.y(), pin.angle};
  one.start.v = {ring.velocity.x(), ring.velocity.y(), ring.spin,
                 pin.velocity.x(),  pin.velocity.y(),  pin.spin};
  one.inverse = {0, 0, 0, 1 / m, 1 / m, 1 / pin.inertia};
  if (carrier == 3) one.inverse[0] = one.inverse[1] = 1 / M;
  if (carrier >= 2) one.inverse[2] = 1 / ring.inertia;

  out.scene.speed = V;
  out.flight = 0.25 * T, out.longest = 4000;
  auto soft = one;
  if (slides) {
    out.scene.penalty = false;
    out.surface(e);
  } else {
    soft.stiffness = out.surface(e, m, V, exact(R * (R - c) / c), 0.01 * T * draw.decades(-0.5, 0));
    soft.slow = exact(1e-3 * V), soft.fast = exact(1e-2 * V), soft.rest = exact(1e-3 * V);
  }
  if (mu > 0) out.text += toml("friction = {}\n", mu);

  one.step = out.flight / 40;
  const double until = T * draw.between(3, 6);
  std::vector<double> instants;
  for (int k = 1; k <= 100; ++k) instants.push_back(0.01 * k * until);
  out.finish(end_of(one.rows(instants), instants.size(), T, until));
  one.step = soft.step = out.scene.shortest / 40;
  if (!slides) soft.step_inside = std::min(out.contact / 100, soft.step);
  derive(out, q, {3, 4, 5}, one, soft);
  if (carrier == 3) derive(out, at, {0, 1, 2}, one, soft);
  if (carrier == 2) derive(out, at, {2}, one, soft);
  if (carrier == 1 || carrier == 2) out.still(at, 0, R), out.still(at + 1, 0, R);
  if (carrier == 1) out.steady(at + 2, ring.angle, ring.spin, 1);
}

/// A journal that turns at rest between both sides of a pocket of the ground, and is braked by friction. With the
/// normals at ±α to the weight, S the sum and D the difference of both normal forces, and s the sense of rotation,
///
///     S cos α − μ s D sin α = m g,    D sin α = −μ s S cos α,    J ω̇ = −s μ S R_j
///
/// thus S = m g/((1 + μ²) cos α). No force is negative if tan α ≥ μ. The corner of the pocket p(x), symmetric
/// about the weight, has e cos α = c + p and e sin α = −p′ at x = α.
void resting_journal(Draw& draw, Draft& out) {
  const double R = exact(draw.decades(-2.5, -0.5)), c = exact(R * draw.decades(-3.5, -1.5));
  const double T = 1 / draw.decades(-1, 3), g = c / (T * T) * draw.decades(0, 2), from = draw.angle();
  const int n = draw.whole(1, 5);
  const auto drawn = n == 1 ? profile_of(pocket(from), draw.between(0.3, 0.6) * c)
                            : profile_of(lobes(n, from), deep(draw, n, c));
  double low = 0.02, high = n == 1 ? 1.2 : pi / n;
  reference::bisect(low, high, 60, [&](double x) {
    const auto y = drawn.surface.at(from + x);
    return (c + y.p) * std::sin(x) + y.slope * std::cos(x) < 0;
  });
  const double alpha = low, e = (c + drawn.surface.at(from + alpha).p) / std::cos(alpha);
  const double mu = draw.chance(0.2) ? 0 : exact(std::min(draw.between(0.02, 0.5), 0.8 * std::tan(alpha)));
  const double m = exact(draw.decades(-2, 1)), J = exact(0.5 * m * R * R), s = draw.sign();
  const double brake = mu * m * g * (R - c) / ((1 + mu * mu) * std::cos(alpha) * J);
  const double spin = exact(s * (mu > 0 ? brake * T * draw.between(1, 3) : 1 / T));
  out.gravity({exact(g * std::cos(from)), exact(g * std::sin(from))});
  const double x = exact(e * std::cos(from)), y = exact(e * std::sin(from));
  const auto q = out.body({.name = "pin", .mass = m, .inertia = J, .at = {x, y}, .spin = spin});
  out.joint("revolute", "ground", "pin", {0, 0}, {0, 0},
            toml("clearance = {}\nbearing_radius = {}\nsurface = 's'\nbearing_profile = 'b'\n", c, R));
  out.text += "[profiles.b]\n" + drawn.lines;
  out.surface(exact(draw.chance(0.5) ? 0 : draw.between(0.1, 0.9)));
  if (mu > 0) out.text += toml("friction = {}\n", mu);
  out.scene.speed = g * T;
  out.scene.penalty = false;
  out.flight = T;
  // Rest within a thousandth of the clearance in the event-driven scheme.
  out.still(q, x, 100 * c);
  out.still(q + 1, y, 100 * c);
  out.scene.derived.push_back({q + 2, [=](Family, const std::vector<double>& instants, const Change& change) {
                                 OneCoordinate::Rows list;
                                 const double w = spin + change.v, a = brake * (1 + change.load),
                                              stop = a > 0 ? std::abs(w) / a : INFINITY;
                                 for (const double t : instants) {
                                   const double now = std::min(t, stop);
                                   list.x.push_back(change.x + w * now - 0.5 * s * a * now * now);
                                   list.v.push_back(t < stop ? w - s * a * t : 0);
                                 }
                                 list.known = instants.size();
                                 return list;
                               }});
  out.finish(T * draw.between(1, 5));
}

}  // namespace

void profiled_journals(Draw& draw, Draft& out) {
  out.given = true;
  const double what = draw();
  what < 0.15 ? resting_journal(draw, out) : thrown_journal(draw, out, what < 0.4);
}

}  // namespace freeplay::verification::random_scenes
