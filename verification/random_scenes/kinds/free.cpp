// Random scenes without joints: discs, walls, pegs, piles, springs.
#include <algorithm>
#include <vector>

#include "verification/random_scenes/draft.hpp"

namespace freeplay::verification::random_scenes {
namespace {

/// A disc of radius R (its own scale), with a mass factor; inertia between that of a ring and a
/// third of a disc's.
DraftBody disc(Draw& draw, const char* prefix, int i, double mass, double R) {
  DraftBody b;
  b.name = toml("{}{}", prefix, i);
  b.mass = mass * mass_factor(draw);
  b.inertia = b.mass * R * R * draw.between(0.15, 1);
  b.angle = draw.angle();
  return b;
}

/// Places discs one by one where they do not overlap walls and each other; false: no room.
struct Packed {
  Vec2 at;
  double R;
};
bool place(Draw& draw, std::vector<Packed>& all, double R, Vec2 low, Vec2 high) {
  for (int tries = 0; tries < 200; ++tries) {
    const Vec2 p{draw.between(low.x() + 1.02 * R, high.x() - 1.02 * R),
                 draw.between(low.y() + 1.02 * R, high.y() - 1.02 * R)};
    if (std::ranges::any_of(all, [&](const Packed& o) { return (o.at - p).norm() < 1.02 * (o.R + R); }))
      continue;
    all.push_back({p, R});
    return true;
  }
  return false;
}

void pairs(Draft& out, const std::vector<DraftBody>& bodies, const std::vector<Packed>& where,
           const std::vector<Vec2>& centre) {
  for (std::size_t i = 0; i < bodies.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      out.discs(bodies[j].name, bodies[i].name, where[j].R, where[i].R, centre[j], centre[i]);
}

/// Discs in a region; the centre of some discs is off their centre of mass.
struct Crowd {
  std::vector<DraftBody> bodies;
  std::vector<Packed> where;
  std::vector<Vec2> centre;
};
Crowd crowd(Draw& draw, Draft& out, const Sizes& s, int count, Vec2 low, Vec2 high, double speed) {
  Crowd c;
  for (int i = 0; i < count; ++i) {
    if (!place(draw, c.where, s.length * draw.between(0.05, 0.15), low, high)) break;
    const auto& [p, R] = c.where.back();
    auto b = disc(draw, "b", i, s.mass, R);
    const Vec2 off = draw.chance(0.25) ? draw.along(R * draw.between(0.05, 0.6)) : Vec2{0, 0};
    b.at = p - DraftBody::turned(off, b.angle);
    b.velocity = draw.along(speed * draw());
    b.spin = draw.chance(0.6) ? draw.either_way(2) * speed / R : 0;
    out.body(b);
    c.bodies.push_back(b);
    c.centre.push_back(off);
  }
  pairs(out, c.bodies, c.where, c.centre);
  return c;
}

void walls(Draft& out, const Crowd& c, Vec2 low, Vec2 high, bool lid) {
  for (std::size_t i = 0; i < c.bodies.size(); ++i) {
    const auto one = [&](Vec2 at, Vec2 axis) {
      out.wall("ground", c.bodies[i].name, at, axis, c.where[i].R, c.centre[i]);
    };
    one(low, {1, 0});
    one(low, {0, -1});
    one(high, {0, 1});
    if (lid) one(high, {-1, 0});
  }
}

}  // namespace

void thrown(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const double reach = s.length, R = reach * draw.between(0.05, 0.7), peg = reach - R;
  const double away = reach * draw.decades(0.3, 1.7), turn = draw.angle();
  // Off the line through the peg by a fraction of the reach; a third of them graze it.
  double off = 1.1 * draw.either_way(1);
  if (draw.chance(0.33)) off = draw.sign() * (1 + draw.sign() * draw.decades(-7, -2));
  const Vec2 along{std::cos(turn), std::sin(turn)};
  auto b = disc(draw, "b", 0, s.mass, R);
  const Vec2 centre = draw.chance(0.3) ? draw.along(R * draw.between(0.1, 2)) : Vec2{0, 0};
  b.at = -away * along + off * reach * perp(along);
  b.velocity = s.speed * along;
  b.spin = draw.chance(0.7) ? draw.either_way(3) * s.speed / R : 0;
  const bool free_peg = draw.chance(0.4);
  if (draw.chance(0.3)) out.gravity(draw.along(draw() * s.speed * s.speed / away));
  out.body(b);
  if (free_peg) {
    auto target = disc(draw, "target", 0, s.mass, peg);
    target.spin = draw.chance(0.5) ? draw.either_way(1) * s.speed / peg : 0;
    out.body(target);
    out.discs(target.name, b.name, peg, R, {0, 0}, centre);
  } else {
    out.discs("ground", b.name, peg, R, {0, 0}, centre);
  }
  if (draw.chance(0.5)) {  // a wall behind, nearly perpendicular to the flight
    const double lean = turn + draw.either_way(0.7);
    out.wall("ground", b.name, draw.between(1.5, 4) * reach * along, {-std::sin(lean), std::cos(lean)}, R,
             centre);
  }
  out.ends(s.speed, std::min(away, 4 * reach) / s.speed, draw.between(2, 4) * away / s.speed);
  out.surface(draw, b.mass, s.speed, std::min(R, peg), std::min(R, peg) * draw.decades(-4.5, -2.5));
}

void cluster(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  crowd(draw, out, s, draw.whole(3, 7), {0, 0}, {0.6 * s.length, 0.6 * s.length}, s.speed);
  out.ends(s.speed, 0.2 * s.time(), draw.between(2, 5) * s.time());
  out.surface(draw, s.mass, s.speed, 0.05 * s.length, 0.05 * s.length * draw.decades(-4, -2.5));
}

void box(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const Vec2 low{0, 0}, high{s.length, s.length * draw.between(0.5, 1)};
  const auto c = crowd(draw, out, s, draw.whole(1, 4), low, high, s.speed);
  walls(out, c, low, high, true);
  if (draw.chance(0.4)) out.gravity(draw.along(draw() * s.speed * s.speed / s.length));
  if (draw.chance(0.3) && c.bodies.size() > 1) {
    const double lightest = std::min(c.bodies[0].mass, c.bodies[1].mass);
    const double rate = lightest * std::pow(draw.between(0.3, 5) / s.time(), 2);
    out.fastest = 2 * std::sqrt(rate / lightest);
    out.load("spring-damper", toml("between = ['{}', '{}']\nstiffness = {}\ndamping = {}\nfree_length = {}\n",
                                   c.bodies[0].name, c.bodies[1].name, rate,
                                   draw.chance(0.5) ? lightest / s.time() * draw() : 0, 0.3 * s.length));
  }
  out.ends(s.speed, 0.3 * s.time(), draw.between(2, 6) * s.time());
  out.surface(draw, s.mass, s.speed, 0.1 * s.length, 0.1 * s.length * draw.decades(-4, -2.5));
}

void pile(Draw& draw, Draft& out) {
  auto s = sizes(draw);
  const double g = 9.81;
  s.speed = std::sqrt(2 * g * s.length);
  const Vec2 low{0, 0}, high{s.length * draw.between(0.35, 0.8), s.length};
  const auto c = crowd(draw, out, s, draw.whole(3, 6), low, high, 0.1 * s.speed);
  walls(out, c, low, high, false);
  out.gravity({0, -g});
  out.ends(s.speed, 0.2 * s.time(), draw.between(1.5, 3) * s.time());
  out.surface(draw, s.mass, s.speed, 0.1 * s.length, 0.1 * s.length * draw.decades(-2.5, -1.8));
}

void sliding(Draw& draw, Draft& out) {
  auto s = sizes(draw);
  const double g = s.speed * s.speed / s.length * draw.decades(-1, 0.7), slope = draw.either_way(0.5);
  const Vec2 axis{std::cos(slope), std::sin(slope)}, normal = perp(axis);
  out.gravity({0, -g});
  auto b = disc(draw, "b", 0, s.mass, s.length);
  b.velocity = s.speed * draw.either_way(1) * axis;
  const int feet = draw.whole(1, 2);
  if (feet == 1) {  // a wheel, rolling, slipping or spinning on the spot
    b.at = s.length * normal;
    const double rolling = -dot(b.velocity, axis) / s.length;
    b.spin = draw.chance(0.4) ? rolling : rolling + draw.either_way(2) * s.speed / s.length;
    out.body(b);
    out.wall("ground", b.name, {0, 0}, axis, s.length);
  } else {  // a block on two round feet
    const double up = s.length * draw.between(0.2, 1.2), R = 0.1 * s.length;
    b.angle = slope;
    b.at = up * normal;
    out.body(b);
    for (const double x : {-1.0, draw.between(0.2, 1)})
      out.wall("ground", b.name, {0, 0}, axis, R, {x * s.length, R - up});
  }
  const double stop = s.length * draw.between(1.5, 5);  // a wall in its way
  if (draw.chance(0.7) && feet == 1) out.wall("ground", b.name, stop * axis, normal, s.length);
  out.ends(s.speed, 0.3 * s.time(), draw.between(2, 6) * s.time());
  out.surface(draw, b.mass, s.speed, 0.1 * s.length, 0.1 * s.length * draw.decades(-3.3, -2));
}

void springs(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const int count = draw.whole(1, 3);
  const double R = 0.2 * s.length, pitch = s.length;
  std::vector<DraftBody> bodies;
  for (int i = 0; i < count; ++i) {
    auto b = disc(draw, "b", i, s.mass, R);
    b.at = {pitch * (i + 1), draw.chance(0.3) ? draw.either_way(0.05) * R : 0};
    b.velocity = {s.speed * draw.either_way(1), draw.chance(0.3) ? draw.either_way(0.05) * s.speed : 0};
    out.body(b);
    bodies.push_back(b);
  }
  for (int i = 0; i < count; ++i) {
    const bool first = i == 0;
    const double rate = bodies[i].mass * std::pow(draw.between(0.5, 6) / s.time(), 2);
    const double lightest = first ? bodies[i].mass : std::min(bodies[i].mass, bodies[i - 1].mass);
    out.fastest = std::max(out.fastest, 2 * std::sqrt(rate / lightest));
    out.load("spring-damper",
             toml("between = ['{}', '{}']\nstiffness = {}\ndamping = {}\nfree_length = {}\n",
                  first ? "ground" : bodies[i - 1].name, bodies[i].name, rate,
                  draw.chance(0.5) ? lightest / s.time() * draw() : 0, pitch * draw.between(0.6, 1.1)));
    if (!first) out.discs(bodies[i - 1].name, bodies[i].name, R, R);
    if (draw.chance(0.3))
      out.load(
          "torsional-spring-damper",
          toml("between = ['ground', '{}']\nstiffness = {}\ndamping = {}\nfree_angle = {}\n", bodies[i].name,
               bodies[i].inertia * std::pow(draw.between(0.5, 6) / s.time(), 2), 0.0, draw.either_way(1)));
  }
  out.wall("ground", bodies[0].name, {pitch * draw.between(0.3, 0.75), 0}, {0, -1}, R);
  out.wall("ground", bodies.back().name, {pitch * (count + draw.between(0.25, 0.7)), 0}, {0, 1}, R);
  out.ends(s.speed, 0.2 * s.time(), draw.between(3, 12) * s.time());
  out.surface(draw, s.mass, s.speed, R, R * draw.decades(-3.3, -2));
}

}  // namespace freeplay::verification::random_scenes
