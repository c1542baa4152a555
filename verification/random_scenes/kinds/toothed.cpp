// Random scenes with gear teeth and end stops.
#include <algorithm>

#include "verification/random_scenes/draft.hpp"

namespace freeplay::verification::random_scenes {

void toothed(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const int first = draw.whole(12, 60), second = draw.whole(12, 60), kind = draw.whole(0, 2);
  const bool inner = kind == 1, rack = kind == 2;
  // The ring gear of an internal pair is the larger one.
  const int z1 = inner ? first + second : first, z2 = second;
  const double module = 2 * s.length / z1, r1 = s.length, r2 = 0.5 * module * z2;
  const double play = module * draw.decades(-2.5, -0.7), pace = s.speed * draw.decades(-2, 0);
  const double w1 = s.speed / r1 * draw.sign(), alpha = 20 * std::numbers::pi / 180;
  DraftBody one{"one", s.mass, 0.5 * s.mass * r1 * r1, {0, 0}, draw.angle(), {0, 0}, w1};
  DraftBody two{"two", s.mass * mass_factor(draw), 1, {inner ? r1 - r2 : r1 + r2, 0}, draw.angle(), {0, 0},
                0};
  two.inertia = 0.5 * two.mass * r2 * r2;
  const double closing = pace * draw.sign(), phase = draw.whole(-3000, 3000) / 1024.0;
  // in the middle of the gaps
  if (!rack) two.angle = phase - (inner ? -1 : 1) * r1 / r2 * one.angle;
  if (rack) {
    two.at = {0, -r1};
    two.angle = 0;
    two.velocity = {w1 * r1 + closing, 0};
  } else {
    two.spin = (inner ? 1 : -1) * w1 * r1 / r2 + closing / r2;
  }
  out.body(one);
  out.body(two);
  out.joint("revolute", "ground", "one", {0, 0}, {0, 0});
  const auto shaft = out.last_joint();
  const double c = play * draw.between(0.05, 0.3);
  const bool clearance_joint = !rack && draw.chance(0.3);
  if (rack)
    out.joint("translational", "ground", "two", {0, -r1}, {0, 0});
  else
    out.joint(
        "revolute", "ground", "two", two.at, {0, 0},
        clearance_joint ? toml("clearance = {}\nbearing_radius = {}\nsurface = 's'\n", c, 0.2 * r2) : "");
  const auto teeth = toml("backlash = {}\nsurface = 's'\n", play);
  if (rack)
    out.joint(
        "rack", "one", "two", {0, 0}, {0, 0},
        toml("pitch_radius = {}\n{}{}", r1, draw.chance(0.5) ? toml("module = {}\n", module) : "", teeth));
  else
    out.joint("gear", "one", "two", {0, 0}, {0, 0},
              (draw.chance(0.5) ? toml("teeth = [{}, {}]\nmodule = {}\n", z1, z2, module)
                                : toml("pitch_radii = [{}, {}]\n", r1, r2)) +
                  (inner ? "internal = true\n" : "") + toml("phase = {}\n", phase) + teeth);
  const double push = std::min(s.mass, two.mass) * pace * pace / play;
  if (draw.chance(0.4))
    out.load("torque", toml("body = 'one'\ntorque = {}\n", push * r1 * draw.either_way(1)));
  if (draw.chance(0.3))
    out.load("torsional-spring-damper", toml("between = ['ground', 'one']\nstiffness = {}\nfree_angle = {}\n",
                                             push * r1 * r1 / play * 0.1, one.angle));
  if (draw.chance(0.2)) out.drive(shaft, toml("speed = {}\n", w1));
  out.ends(pace, play / pace, draw.between(5, 40) * (play / pace));
  const double R = std::sin(alpha) * (rack ? r1 : r1 * r2 / (inner ? r1 - r2 : r1 + r2));
  out.surface(draw, std::min(s.mass, two.mass), pace, clearance_joint ? std::min(R, 0.04 * r2 * r2 / c) : R,
              (clearance_joint ? c : 0.5 * play) * draw.decades(-2.7, -1.5), true);
}

void stopped(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const int kind = draw.whole(0, 2);
  const double R = s.length * draw.decades(-2, 0);
  DraftBody b{"mover", s.mass, s.mass * s.length * s.length * draw.between(0.1, 1), {0, 0}, 0, {0, 0}, 0};
  const double slope = draw.angle(), width = s.length * draw.between(0.3, 3),
               below = width * draw.between(0.05, 0.95);
  const Vec2 axis{std::cos(slope), std::sin(slope)};
  std::string play;
  double c = R;
  const auto limits = [&](double from, double to) {
    const bool upper = draw.chance(0.85), lower = !upper || draw.chance(0.85);
    return (lower ? toml("lower = {}\n", from) : "") + (upper ? toml("upper = {}\n", to) : "") +
           toml("curvature_radius = {}\nsurface = 's'\n", R);
  };
  if (draw.chance(0.5)) out.gravity(draw.along(s.speed * s.speed / s.length));
  if (kind == 0) {  // a lever
    const Vec2 arm{-s.length, 0};
    b.spin = s.speed / s.length * draw.sign();
    b.velocity = -b.spin * perp(arm);
    b.at = -arm;
    out.body(b);
    out.joint("revolute", "ground", "mover", {0, 0}, arm);
    const double turn = draw.between(0.3, 4);
    out.stop("angle-stop",
             toml("radius = {}\n", s.length * draw.between(0.1, 2)) +
                 (draw.chance(0.6) ? toml("direction = {}\n", draw.whole(-3000, 3000) / 1024.0) : "") +
                 limits(-turn * below / width, turn * (1 - below / width)));
  } else if (kind == 1) {  // a slider
    b.angle = slope;
    b.velocity = s.speed * draw.sign() * axis;
    out.body(b);
    out.joint("translational", "ground", "mover", {0, 0}, {0, 0},
              toml("axis = {}\nangle = {}\n", axis, slope));
    out.stop("travel-stop", limits(-below, width - below));
  } else {  // a pin in a slot
    c = s.length * draw.decades(-3.5, -1.7);
    b.velocity = s.speed * draw.sign() * axis + 0.1 * s.speed * draw.either_way(1) * perp(axis);
    b.spin = draw.either_way(1) * s.speed / s.length;
    out.body(b);
    out.joint("slot", "ground", "mover", {0, 0}, {0, 0},
              toml("axis = {}\nclearance = {}\npin_radius = {}\nsurface = 's'\n", axis, c, R));
    out.stop("travel-stop", limits(-below, width - below));
  }
  if (draw.chance(0.4))
    out.load("force", toml("body = 'mover'\nforce = {}\n",
                           draw.along(s.mass * s.speed * s.speed / s.length * draw())));
  out.speed = s.speed;
  out.flight = kind == 2 ? std::min(c / (0.1 * s.speed), 0.3 * s.time()) : 0.3 * s.time();
  out.duration = std::min(draw.between(5, 40) * out.flight, 15 * s.time());
  out.surface(draw, s.mass, s.speed, R, std::min(c, R) * draw.decades(-3.3, -2));
}

}  // namespace freeplay::verification::random_scenes
