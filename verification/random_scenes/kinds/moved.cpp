// Bodies on prescribed curves, with balls, stops, arms, teeth and journals on them.
#include <algorithm>

#include "verification/random_scenes/draft.hpp"

namespace freeplay::verification::random_scenes {
namespace {

using reference::MovingWall;
using reference::OneCoordinate;
using std::numbers::pi;
using Motion = std::shared_ptr<DrivenMotion>;

double restitution(Draw& draw, double least = 0.2) {
  return exact(draw.chance(0.3) ? 1 : draw.between(least, 0.97));
}

/// A curve with an amplitude of `size` over `period`, used as a position or as a rate.
Motion moved_along(Draw& draw, Draft& out, const std::string& joint, double period, double size,
                   double until) {
  const bool rate = draw.chance(0.25);
  const double initial = rate ? exact(size * draw.either_way(1)) : 0;
  const auto curve = draw_curve(draw, {period, rate ? 3 * size / period : size, !rate});
  return out.driven(joint, curve, rate, initial, until);
}

/// The table of a joint between the ground, or a body `on`, and another: a slide along x (0) or y
/// (1), or a shaft (2).
void joint(Draft& out, const std::string& name, int coordinate, const std::string& body,
           const std::string& on = "ground") {
  out.table("joints." + name,
            toml("type = '{}'\nbetween = ['{}', '{}']\n{}", coordinate == 2 ? "revolute" : "translational",
                 on, body, coordinate == 1 ? "axis = [0, 1]\n" : ""));
}

/// A body on the ground with this coordinate on a curve of `size` over `period`; `room`: the length
/// of its surroundings.
Motion carrier(Draw& draw, Draft& out, const std::string& name, int coordinate, double period, double size,
               double until, double room) {
  const auto q = out.body({.name = name});
  const std::string by = coordinate == 2 ? "shaft" : "guide";
  joint(out, by, coordinate, name);
  auto motion = moved_along(draw, out, by, period, size, until);
  for (int k = 0; k < 3; ++k) {
    const auto at = q + static_cast<std::size_t>(k);
    k == coordinate ? out.prescribed(at, motion) : out.still(at, 0, k == 2 ? 1 : room);
  }
  return motion;
}

/// A wall at a distance from a coordinate on a curve, with free space on the greater (1) or lesser
/// (−1) side.
MovingWall wall(const Motion& motion, double distance, double side, double e) {
  return {[=](double t) {
            auto p = motion->at(t);
            p.y += distance;
            return p;
          },
          side, e};
}

OneCoordinate beside(const Motion& motion, double x, double v) {
  OneCoordinate one;
  one.next_kink = [motion](double t) { return motion->next_kink(t); };
  one.x = x, one.v = v;
  return one;
}

void spring(Draft& out, const std::string& from, const std::string& to, Vec2 at, double stiffness,
            double free) {
  out.table("loads.spring",
            toml("type = 'spring-damper'\nbetween = ['{}', '{}']\nat = [{}, [0, 0]]\nstiffness = {}\n"
                 "free_length = {}\n",
                 from, to, at, stiffness, free));
}

}  // namespace

void moved_table(Draw& draw, Draft& out) {
  const double T = 1 / draw.decades(-3, 4), g = exact(draw.chance(0.7) ? 9.81 : draw.decades(-1, 2));
  const double w = 2 * pi / T, strength = draw.decades(-0.5, 1);
  const double A = std::min(strength * g / (w * w), 10.0);
  // Flights of the order of the period, and drops up to a metre.
  const double drop = std::min(0.5 * g * T * T * draw.decades(-2, 0.5), draw.decades(-2, 0));
  const double flight = std::sqrt(2 * drop / g), speed = std::max(g * flight, std::min(A * w, g * T));
  out.flight = std::min(T, flight);
  out.gravity({0, -g});
  const double until = 100 * out.flight, e = restitution(draw);
  const auto motion = carrier(draw, out, "table", 1, T, A, until, A);
  out.scene.speed = std::max(speed, motion->rate);
  const int balls = draw.chance(0.7) ? 1 : draw.whole(2, 4);
  const double m = exact(draw.decades(-2, 1)), R = exact(draw.decades(-2.5, -1));
  // Soft contacts with a penetration of a tenth of the radius are not Hertzian contacts.
  const double K =
      out.surface(e, m, speed, R, std::min(out.flight * draw.decades(-2, -1.3), 0.01 * R / out.scene.speed));
  for (int i = 0; i < balls; ++i) {
    const double x = exact(3 * R * (i - 0.5 * (balls - 1)));
    const double y = exact(motion->at(0).y + R + drop * draw.between(0.3, 1));
    const double v = draw.chance(0.5) ? exact(motion->at(0).slope + 0.3 * speed * draw.either_way(1)) : 0;
    const auto q = out.body({.name = toml("ball{}", i),
                             .mass = m,
                             .inertia = exact(0.4 * m * R * R),
                             .at = {x, y},
                             .velocity = {0, v}});
    out.table(toml("contacts.c{}", i),
              toml("type = 'plane'\nbetween = ['table', 'ball{}']\nradius = {}\nsurface = 's'\n", i, R));
    out.still(q, x, R);
    out.still(q + 2, 0, 1);
    auto one = beside(motion, y, v);
    one.acceleration = [g](double, double, double) { return -g; };
    one.walls = {wall(motion, R, 1, e)};
    moving(out, q + 1, one, K / m, 1.5);
  }
  finish_moving(out, until * draw.between(0.2, 1));
}

void moved_stop(Draw& draw, Draft& out) {
  const double T = 1 / draw.decades(-3, 4), m = exact(draw.decades(-2, 1));
  const double w = 2 * pi / T, own = w * draw.decades(-1, 1), k = exact(m * own * own);
  const double A = std::min(draw.decades(-4, 0), 100 / w);
  const double room = exact(A * draw.decades(-1, 0.5)), speed = std::max(A * w, A * own);
  out.scene.speed = speed;
  out.flight = std::min({T, 2 * pi / own, room / speed * 2});
  const double until = 100 * out.flight, e = restitution(draw);
  const auto motion = carrier(draw, out, "slide", 0, T, A, until, A);
  const double x = exact(motion->at(0).y + room * draw.between(0.1, 0.9));
  const double v = draw.chance(0.5) ? exact(motion->at(0).slope + 0.5 * speed * draw.either_way(1)) : 0;
  const auto q = out.body({.name = "block", .mass = m, .at = {x, 0}, .velocity = {v, 0}});
  joint(out, "on", 0, "block", "slide");
  const double time = std::min(out.flight * draw.decades(-2, -1.3), 0.01 * std::min(A, room) / speed);
  const double ks = stop_stiffness(out, m, 1, time);
  out.table("contacts.stop",
            toml("type = 'travel-stop'\njoint = 'on'\nlower = 0\nupper = {}\nstiffness = {}\nsurface = 's'\n",
                 room, ks));
  out.surface(e);
  const bool on_slide = draw.chance(0.5);
  const double far = exact(10 * (A + room) + 3 * motion->size + std::abs(motion->at(0).y)),
               free = exact(far * draw.between(0.95, 1.05));
  spring(out, on_slide ? "slide" : "ground", "block", {-far, 0}, k, free);
  out.still(q + 1, 0, room);
  out.still(q + 2, 0, 1);
  auto one = beside(motion, x, v);
  one.acceleration = [=](double t, double at, double) {
    return -k / m * (at + far - (on_slide ? motion->at(t).y : 0) - free);
  };
  one.walls = {wall(motion, 0, 1, e), wall(motion, room, -1, e)};
  moving(out, q, one, ks / m, 1);
  finish_moving(out, until * draw.between(0.2, 1));
}

void moved_lever(Draw& draw, Draft& out) {
  const double T = 1 / draw.decades(-3, 4), J = exact(draw.decades(-4, 0)), w = 2 * pi / T;
  const double A = draw.decades(-2, 0.5), room = exact(std::min(A * draw.decades(-1, 0.3), 3.0)),
               R = exact(draw.decades(-2, 0));
  out.scene.speed = A * w * R;
  out.flight = std::min(T, 2 * room / (A * w));
  const double until = 100 * out.flight, e = restitution(draw);
  const auto motion = carrier(draw, out, "rotor", 2, T, A, until, 1);
  const double x = exact(motion->at(0).y + room * draw.between(0.1, 0.9)),
               v = exact(motion->at(0).slope + 0.5 * A * w * draw.either_way(1));
  const auto q = out.body({.name = "arm", .inertia = J, .angle = x, .spin = v});
  joint(out, "pin", 2, "arm", "rotor");
  const double ks = stop_stiffness(out, J, R * R, out.flight * draw.decades(-2, -1.3));
  out.table("contacts.stop",
            toml("type = 'angle-stop'\njoint = 'pin'\nradius = {}\nlower = 0\nupper = {}\nstiffness = {}\n"
                 "surface = 's'\n",
                 R, room, ks));
  out.surface(e);
  const double M = exact(draw.chance(0.5) ? J * A * w * w * draw.either_way(0.3) : 0);
  if (M != 0) out.table("loads.push", toml("type = 'torque'\nbody = 'arm'\ntorque = {}\n", M));
  out.still(q, 0, 1);
  out.still(q + 1, 0, 1);
  auto one = beside(motion, x, v);
  one.acceleration = [=](double, double, double) { return M / J; };
  one.walls = {wall(motion, 0, 1, e), wall(motion, room, -1, e)};
  moving(out, q + 2, one, ks * R * R / J, 1, R);
  finish_moving(out, until * draw.between(0.2, 1));
}

void teeth(Draw& draw, Draft& out) {
  const double T = 1 / draw.decades(-3, 4), w = 2 * pi / T;
  const double r1 = exact(draw.decades(-2, -0.5)), r2 = exact(r1 * draw.decades(-0.5, 0.5));
  const double J = exact(draw.decades(-5, -1)), play = exact(r1 * draw.decades(-3.5, -2)),
               alpha = 20 * pi / 180;
  const double A = play / r1 * draw.decades(0, 2), base = r2 * std::cos(alpha), half = 0.5 * play / base;
  const double pace = A * w * r1;
  out.scene.speed = pace;
  out.flight = std::min(T, play / pace);
  const double until = 100 * out.flight, e = restitution(draw);
  // The centres are at rest, or on an arm that turns at constant speed about the first.
  const bool turns = draw.chance(0.5);
  const double spin = turns ? exact(w * draw.decades(-2, 0) * draw.sign()) : 0;
  const std::string on = turns ? "arm" : "ground";
  if (turns) {
    const auto arm = out.body({.name = "arm", .spin = spin});
    joint(out, "turn", 2, "arm");
    out.table("drives.turn", toml("joint = 'turn'\nspeed = {}\ninitial_angle = 0\n", spin));
    out.still(arm, 0, r1);
    out.still(arm + 1, 0, r1);
    out.steady(arm + 2, 0, spin, 1);
  }
  const auto first = out.body({.name = "one"});
  joint(out, "shaft", 2, "one", on);
  const auto motion = moved_along(draw, out, "shaft", T, A, until);
  out.still(first, 0, r1);
  out.still(first + 1, 0, r1);
  out.scene.prescribed.push_back({first + 2,
                                  [motion, spin](double t, Coordinates, Coordinates) {
                                    auto p = motion->at(t);
                                    p.y += spin * t, p.slope += spin;
                                    return p;
                                  },
                                  motion->size, motion->rate + std::abs(spin), motion->bend});
  const double phase = exact(draw.angle()), ratio = r1 / r2;
  const double x = exact(phase - ratio * motion->at(0).y + half * draw.either_way(0.9));
  const double v = exact(spin - ratio * motion->at(0).slope + pace / r2 * draw.either_way(0.5));
  const double distance = exact(r1 + r2);
  const auto q = out.body({.name = "two",
                           .inertia = J,
                           .at = {distance, 0},
                           .angle = x,
                           .velocity = {0, exact(distance * spin)},
                           .spin = v});
  out.table("joints.second",
            toml("type = 'revolute'\nbetween = ['{}', 'two']\nat = [[{}, 0], [0, 0]]\n", on, distance));
  const double ks = stop_stiffness(out, J, base * base, out.flight * draw.decades(-2, -1.3));
  out.table(
      "joints.mesh",
      toml("type = 'gear'\nbetween = ['one', 'two']\npitch_radii = [{}, {}]\nphase = {}\nbacklash = {}\n"
           "mesh_stiffness = {}\nsurface = 's'\n",
           r1, r2, phase, play, ks));
  out.surface(e);
  const double rate = distance * std::abs(spin), bend = rate * std::abs(spin);
  for (const std::size_t k : {0U, 1U})
    out.scene.prescribed.push_back(
        {q + k,
         [=](double t, Coordinates, Coordinates) {
           const double c = std::cos(spin * t), s = std::sin(spin * t);
           return CurvePoint{distance * (k ? s : c), distance * spin * (k ? c : -s), 0};
         },
         r2, rate, bend});
  auto one = beside(motion, x, v);
  one.acceleration = [](double, double, double) { return 0.0; };
  for (const double side : {1.0, -1.0})
    one.walls.push_back({[=](double t) {
                           const auto p = motion->at(t);
                           return CurvePoint{spin * t + phase - ratio * p.y - side * half,
                                             spin - ratio * p.slope, -ratio * p.bend};
                         },
                         side, e});
  moving(out, q + 2, one, ks * base * base / J, 1, base);
  finish_moving(out, until * draw.between(0.2, 1));
}

void moved_journal(Draw& draw, Draft& out) {
  const double T = 1 / draw.decades(-3, 4), w = 2 * pi / T, c = exact(draw.decades(-5, -3)),
               R = exact(draw.decades(-2, -1));
  const double A = c * draw.decades(0, 2), speed = A * w;
  const double g = exact(speed * speed / c * draw.decades(-2, 0));
  out.scene.speed = speed;
  out.flight = std::min(T, c / speed);
  const double until = 60 * out.flight, e = restitution(draw);
  out.gravity({0, -g});
  const auto motion = carrier(draw, out, "box", 1, T, A, until, A);
  DraftBody pin{.name = "pin", .mass = exact(draw.decades(-2, 1))};
  pin.inertia = exact(pin.mass * R * R);
  const double across = exact(c * draw.either_way(0.5)),
               along = exact(motion->at(0).y + c * draw.either_way(0.5));
  pin.at = {across, along};
  pin.velocity = {exact(0.3 * speed * draw.either_way(1)), exact(motion->at(0).slope)};
  const auto q = out.body(pin);
  out.table(
      "joints.loose",
      toml(
          "type = 'revolute'\nbetween = ['box', 'pin']\nclearance = {}\nbearing_radius = {}\nsurface = 's'\n",
          c, R));
  out.surface(e, pin.mass, speed, R * R / c, out.flight * draw.decades(-2, -1.3));
  out.scene.others = {q, q + 1, q + 2};
  out.finish(until * draw.between(0.2, 1));
}

void follower(Draw& draw, Draft& out) {
  const double w = draw.decades(-2, 4) * draw.sign(), lift = draw.decades(-4, -1),
               turn = 2 * pi / draw.whole(1, 4);
  const double J = exact(draw.decades(-4, 1)), m = exact(J / (lift * lift) * draw.decades(-3, 0.5));
  const double start = exact(draw.angle()), wx = exact(w);
  const bool driven = draw.chance(0.4);
  out.flight = turn / std::abs(w);
  out.scene.speed = std::abs(w) * lift;
  const auto rotor = out.body({.name = "rotor", .inertia = J, .angle = start, .spin = wx});
  joint(out, "shaft", 2, "rotor");
  const auto curve = draw_curve(draw, {turn, lift, true});
  const auto shape = std::make_shared<CurveShape>(curve.shape);
  out.table("curves.y", curve.lines);
  const auto at = shape->at(start);
  const auto q =
      out.body({.name = "follower", .mass = m, .at = {0, exact(at.y)}, .velocity = {0, exact(at.slope * w)}});
  joint(out, "guide", 1, "follower");
  out.table("drives.lift", "joint = \"guide\"\nposition = \"y\"\nof = \"shaft\"\n");
  if (driven) out.table("drives.motor", toml("joint = 'shaft'\nspeed = {}\n", wx));
  out.still(rotor, 0, lift);
  out.still(rotor + 1, 0, lift);
  out.still(q, 0, lift);
  out.still(q + 2, 0, 1);
  const double slope = lift / turn * 6;
  out.scene.prescribed.push_back({q + 1,
                                  [shape, rotor](double, Coordinates x, Coordinates v) {
                                    auto p = shape->at(x[rotor + 2]);
                                    p.slope *= v[rotor + 2];
                                    return p;
                                  },
                                  lift, slope * std::abs(w), 6 * slope * w * w / turn * 6});
  // m y′² is added to the rotor's inertia: (J + m y′²) φ̈ + m y′ y″ φ̇² + k (y − y₀) y′ + m g y′ =
  // 0.
  const double k = exact(draw.chance(0.5) ? J * w * w / (lift * lift) * draw.decades(-2, 0.5) : 0),
               far = exact(20 * lift);
  const double rest = exact(far - lift * draw.between(0, 2));
  if (k > 0) spring(out, "ground", "follower", {0, -far}, k, rest);
  if (driven) {
    out.steady(rotor + 2, start, wx, turn);
  } else {
    OneCoordinate one;
    one.acceleration = [=](double, double x, double v) {
      const auto p = shape->at(x);
      return -(m * p.slope * p.bend * v * v + k * (p.y + far - rest) * p.slope) / (J + m * p.slope * p.slope);
    };
    one.kinks = shape->kinks(start - 700, start + 700);
    one.x = start, one.v = wx;
    out.scene.moving.push_back({rotor + 2, one, one});
    out.scene.energy = [=](Coordinates x, Coordinates v) {
      const double y = x[q + 1] + far - rest;
      return 0.5 * (J * v[rotor + 2] * v[rotor + 2] + m * v[q + 1] * v[q + 1] + k * y * y);
    };
  }
  finish_moving(out, out.flight * draw.between(5, 60));
}

void two_scales(Draw& draw, Draft& out) {
  // A fast oscillator on a stop beside a slow driven body.
  const double f = draw.decades(0, 3.5), own = 2 * pi * f, m = exact(draw.decades(-2, 1)),
               k = exact(m * own * own);
  const double slow = f * draw.decades(-6, -1.5), A = exact(draw.decades(-4, -1)), e = restitution(draw, 0.5);
  out.flight = 0.5 / f;
  out.scene.speed = A * own;
  const double until = 50 / f;
  if (draw.chance(0.5)) {
    const auto rotor = out.body({.name = "slow"});
    const double w = exact(2 * pi * slow);
    joint(out, "shaft", 2, "slow");
    out.table("drives.motor", toml("joint = 'shaft'\nspeed = {}\ninitial_angle = 0\n", w));
    out.still(rotor, 0, 1);
    out.still(rotor + 1, 0, 1);
    out.steady(rotor + 2, 0, w, w * until);
  } else {
    carrier(draw, out, "slow", 1, 1 / slow, draw.decades(-2, 0), until, 1);
  }
  const double x = exact(A * draw.between(0.3, 1)), free = exact(10 * A),
               stop = exact(-A * draw.between(0, 0.6));
  const auto q = out.body({.name = "block", .mass = m, .at = {x, 0}});
  joint(out, "on", 0, "block");
  const double ks = stop_stiffness(out, m, 1, out.flight * draw.decades(-2, -1.3));
  out.table(
      "contacts.stop",
      toml("type = 'travel-stop'\njoint = 'on'\nlower = {}\nstiffness = {}\nsurface = 's'\n", stop, ks));
  out.surface(e);
  spring(out, "ground", "block", {-free, 0}, k, free);
  out.still(q + 1, 0, A);
  out.still(q + 2, 0, 1);
  OneCoordinate one;
  one.acceleration = [=](double, double at, double) { return -k / m * at; };
  one.walls = {MovingWall{[stop](double) { return CurvePoint{stop, 0, 0}; }, 1, e}};
  one.x = x;
  moving(out, q, one, ks / m, 1);
  finish_moving(out, until * draw.between(0.2, 1));
}

}  // namespace freeplay::verification::random_scenes
