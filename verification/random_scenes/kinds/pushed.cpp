// Sliders and rotors under forces of curves, one-sided springs and bump stops.
#include <algorithm>

#include "verification/random_scenes/draft.hpp"

namespace freeplay::verification::random_scenes {
namespace {

using std::numbers::pi;

/// A slider or rotor of inertia m with one driven coordinate.
struct Mover {
  bool turns = false;
  double m = 1;
  std::size_t coordinate = 0;
};
Mover mover(Draw& draw, Draft& out, double x, double v, double size) {
  Mover o{draw.chance(0.4), exact(draw.decades(-2, 1)), 0};
  if (o.turns) {
    const auto q = out.body({.name = "rotor", .inertia = o.m, .angle = x, .spin = v});
    out.table("joints.on", "type = \"revolute\"\nbetween = [\"ground\", \"rotor\"]\n");
    out.still(q, 0, size);
    out.still(q + 1, 0, size);
    o.coordinate = q + 2;
  } else {
    const auto q = out.body({.name = "block", .mass = o.m, .at = {x, 0}, .velocity = {v, 0}});
    out.table("joints.on", "type = \"translational\"\nbetween = [\"ground\", \"block\"]\n");
    out.still(q + 1, 0, size);
    out.still(q + 2, 0, 1);
    o.coordinate = q;
  }
  return o;
}

/// A force or torque of a curve on it, by a drive or a load; `of`: the joint of its argument.
void push(Draw& draw, Draft& out, const Mover& o, const std::string& lines, const std::string& against,
          const std::string& of = "") {
  out.table("curves.push", lines);
  const bool drive = draw.chance(0.5);
  const std::string how = toml("against = '{}'\n{}", against, of.empty() ? "" : toml("of = '{}'\n", of));
  if (drive)
    out.table("drives.push", toml("joint = 'on'\n{} = 'push'\n{}", o.turns ? "torque_curve" : "force", how));
  else
    out.table("loads.push", (o.turns ? "type = \"torque\"\nbody = \"rotor\"\ntorque = 1\n"
                                     : "type = \"force\"\nbody = \"block\"\nforce = [1, 0]\n") +
                                toml("factor = 'push'\n{}", how));
}

void known(Draft& out, std::size_t coordinate, reference::OneCoordinate one, double duration) {
  out.given = true;
  out.finish(duration);
  one.step = one.step_in_contact = out.scene.shortest / 400;
  out.scene.moving.push_back({coordinate, one, one});
}

}  // namespace

void pushed(Draw& draw, Draft& out) {
  const double T = 1 / draw.decades(-3, 4), A = draw.decades(-4, 0), x = exact(A * draw.either_way(1));
  const int kind = draw.whole(0, 3);
  const double v = exact(A / T * draw.either_way(3));
  out.scene.speed = A / T;
  const auto o = mover(draw, out, x, v, A);
  reference::OneCoordinate one;
  one.x = x, one.v = v;
  out.flight = T;
  if (kind < 2) {
    const double force = o.m * A / (T * T) * draw.decades(-1, 1.5);
    const auto curve = draw_curve(draw, {T, force, false});
    const auto shape = std::make_shared<CurveShape>(curve.shape);
    push(draw, out, o, curve.lines, "time");
    const double m = o.m;
    one.acceleration = [shape, m](double t, double, double) { return shape->at(t).y / m; };
    const auto kinks = std::make_shared<std::vector<double>>(shape->kinks(0, 200 * T));
    one.next_kink = [kinks](double t) {
      const auto next = std::upper_bound(kinks->begin(), kinks->end(), t * (1 + 1e-14));
      return next == kinks->end() ? INFINITY : *next;
    };
  } else if (kind == 3) {
    // Over the angle of a rotor that turns at constant speed.
    const double turn = 2 * pi / draw.whole(1, 4), start = exact(draw.angle()),
                 w = exact(turn / T * draw.sign());
    const double force = o.m * A / (T * T) * draw.decades(-1, 1.5);
    const auto curve = draw_curve(draw, {turn, force, false});
    const auto shape = std::make_shared<CurveShape>(curve.shape);
    const auto cam = out.body({.name = "cam", .angle = start, .spin = w});
    out.table("joints.shaft", "type = \"revolute\"\nbetween = [\"ground\", \"cam\"]\n");
    out.table("drives.motor", toml("joint = 'shaft'\nspeed = {}\ninitial_angle = {}\n", w, start));
    out.still(cam, 0, 1);
    out.still(cam + 1, 0, 1);
    out.steady(cam + 2, start, w, turn);
    push(draw, out, o, curve.lines, "angle", "shaft");
    const double m = o.m, far = 60 * turn;
    one.acceleration = [=](double t, double, double) { return shape->at(start + w * t).y / m; };
    const auto kinks = std::make_shared<std::vector<double>>();
    for (const double k : shape->kinks(start - far, start + far)) kinks->push_back((k - start) / w);
    std::sort(kinks->begin(), kinks->end());
    one.next_kink = [kinks](double t) {
      const auto next = std::upper_bound(kinks->begin(), kinks->end(), t + 1e-14 * std::abs(t));
      return next == kinks->end() ? INFINITY : *next;
    };
  } else {
    // Over speed: decreasing lines through zero, like a motor or a damper.
    const double fast = A / T * 3, force = exact(o.m * fast / T * draw.decades(-1, 0.5));
    std::string points;
    auto shape = std::make_shared<CurveShape>();
    shape->kind = draw.chance(0.5) ? CurveShape::Kind::lines : CurveShape::Kind::spline;
    const int n = draw.whole(3, 6);
    for (int i = 0; i <= n; ++i) {
      const double at = exact(fast * (2.0 * i / n - 1) * 1.3),
                   y = exact(force * (1 - 2.0 * i / n + draw.either_way(0.8 / n)));
      shape->points.emplace_back(at, y);
      points += toml("{}[{}, {}]", i ? ", " : "", at, y);
    }
    shape->prepare();
    push(draw, out, o,
         toml("shape = 'table'\npoints = [{}]\n{}", points,
              shape->kind == CurveShape::Kind::spline ? "between = \"spline\"\n" : ""),
         "speed");
    const double m = o.m;
    one.acceleration = [shape, m](double, double, double u) { return shape->at(u).y / m; };
    for (const auto& p : shape->points) one.speed_kinks.push_back(p.first);
  }
  known(out, o.coordinate, one, T * draw.between(3, 50));
}

void barrier(Draw& draw, Draft& out) {
  const double f = draw.decades(-3, 4), wide = draw.decades(-4, 0), v = exact(wide * f * draw.sign());
  // Towards a barrier or over wells: f(x) = −dU/dx of a bump U of height H, by straight lines, a
  // spline or a sine.
  const double far = wide * draw.decades(0, 2.5), x = exact(-far * (v > 0 ? 1 : -1));
  out.scene.speed = std::abs(v);
  const auto o = mover(draw, out, x, v, wide);
  const double energy = 0.5 * o.m * v * v, H = energy * draw.decades(-1, 1) * (draw.chance(0.7) ? 1 : -1);
  auto shape = std::make_shared<CurveShape>();
  std::string lines;
  const int kind = draw.whole(0, 2);
  const bool repeats = draw.chance(0.3);
  if (kind == 2) {
    shape->kind = CurveShape::Kind::harmonic;
    shape->amplitude = exact(H * pi / wide);
    shape->period = exact(wide);
    lines = toml("shape = 'harmonic'\namplitude = {}\nperiod = {}\n", shape->amplitude, wide);
  } else {
    // Up, flat and down again, symmetric: no net work.
    const double a = wide * draw.between(0.05, 0.25), c = wide * 0.5, peak = H / (c - a);
    const double at[] = {-c, -c + a, -a, a, c - a, c}, y[] = {0, -peak, -peak, peak, peak, 0};
    std::string points;
    shape->kind = kind == 1 ? CurveShape::Kind::spline : CurveShape::Kind::lines;
    for (int i = 0; i < 6; ++i) {
      shape->points.emplace_back(exact(at[i]), exact(y[i]));
      points += toml("{}[{}, {}]", i ? ", " : "", at[i], y[i]);
    }
    shape->repeats = repeats;
    lines = toml("shape = 'table'\npoints = [{}]\n{}{}", points, kind == 1 ? "between = \"spline\"\n" : "",
                 repeats ? "repeat = true\n" : "");
  }
  shape->prepare();
  push(draw, out, o, lines, o.turns ? "angle" : "position");
  reference::OneCoordinate one;
  const double m = o.m;
  one.acceleration = [shape, m](double, double at, double) { return shape->at(at).y / m; };
  one.kinks = shape->kinks(-3 * far - 30 * wide, 3 * far + 30 * wide);
  one.x = x, one.v = v;
  out.flight = wide / std::abs(v) / std::max(1.0, std::sqrt(std::abs(H) / energy));
  const auto q = o.coordinate;
  // U(x) from Gauss's rule between kinks, from the start on.
  out.scene.energy = [=](Coordinates at, Coordinates u) {
    return 0.5 * m * u[q] * u[q] - shape->integral(x, at[q], wide / 50);
  };
  known(out, o.coordinate, one, std::min(far / std::abs(v) * draw.between(1.2, 2.5), 100 * out.flight));
}

void one_way(Draw& draw, Draft& out) {
  const double f = draw.decades(-3, 4), A = draw.decades(-4, 0), w = 2 * pi * f;
  const double x = exact(A * draw.either_way(1)), v = exact(A * w * draw.either_way(1));
  out.scene.speed = A * w;
  const auto o = mover(draw, out, x, v, A);
  const double k = exact(o.m * w * w), d = exact(draw.chance(0.6) ? o.m * w * draw.decades(-2, 0.3) : 0),
               m = o.m;
  const int kind = draw.whole(0, 1);
  reference::OneCoordinate one;
  one.x = x, one.v = v;
  const std::string between = toml("between = ['ground', '{}']\n", o.turns ? "rotor" : "block");
  const double pull = exact(draw.chance(0.7) ? m * A * w * w * draw.either_way(0.5) : 0);
  if (pull != 0) {
    if (o.turns)
      out.table("loads.pull", toml("type = 'torque'\nbody = 'rotor'\ntorque = {}\n", pull));
    else
      out.table("loads.pull", toml("type = 'force'\nbody = 'block'\nforce = [{}, 0]\n", pull));
  }
  const auto values = [&](const char* key) {
    return toml("{} = {}\n{}", key, k, d > 0 ? toml("damping = {}\n", d) : "");
  };
  double from = 0;
  if (kind == 0) {  // a bump stop on one side or both
    const double lower = exact(-A * draw.between(0.2, 2)), upper = exact(A * draw.between(0.2, 2));
    const bool low = draw.chance(0.8), up = !low || draw.chance(0.8);
    out.table("loads.bump", toml("type = '{}'\n{}{}{}{}", o.turns ? "torsional-bump-stop" : "bump-stop",
                                 between, values("stiffness"), low ? toml("lower = {}\n", lower) : "",
                                 up ? toml("upper = {}\n", upper) : ""));
    one.acceleration = [=](double, double at, double u) {
      double F = pull;
      if (up && at > upper) F -= std::max(k * (at - upper) + d * u, 0.0);
      if (low && at < lower) F += std::max(k * (lower - at) - d * u, 0.0);
      return F / m;
    };
    if (low) one.kinks.push_back(lower);
    if (up) one.kinks.push_back(upper);
    out.scene.energy = [=, q = o.coordinate](Coordinates at, Coordinates u) {
      const double y = up && at[q] > upper ? at[q] - upper : low && at[q] < lower ? lower - at[q] : 0;
      return 0.5 * m * u[q] * u[q] + 0.5 * k * y * y - pull * at[q];
    };
  } else {  // a one-sided spring; for a slider its length matters, from a point far enough behind
    const bool pulls = draw.chance(0.5);
    from = o.turns ? 0 : exact(-20 * A);
    const double rest = o.turns ? exact(A * draw.either_way(1)) : exact(20 * A + A * draw.either_way(1));
    out.table("loads.spring", toml("type = '{}'\n{}{}{}{} = {}\none_way = '{}'\n",
                                   o.turns ? "torsional-spring-damper" : "spring-damper", between,
                                   o.turns ? "" : toml("at = [[{}, 0], [0, 0]]\n", from), values("stiffness"),
                                   o.turns ? "free_angle" : "free_length", rest, pulls ? "pull" : "push"));
    one.acceleration = [=](double, double at, double u) {
      const double y = at - from - rest;
      double F = pull;
      if (pulls && y > 0) F -= std::max(k * y + d * u, 0.0);
      if (!pulls && y < 0) F -= std::min(k * y + d * u, 0.0);
      return F / m;
    };
    one.kinks.push_back(from + rest);
    out.scene.energy = [=, q = o.coordinate](Coordinates at, Coordinates u) {
      const double y = at[q] - from - rest;
      return 0.5 * m * u[q] * u[q] + ((pulls ? y > 0 : y < 0) ? 0.5 * k * y * y : 0) - pull * at[q];
    };
  }
  if (d > 0) out.scene.energy = {};
  out.flight = 1 / f;
  double duration = draw.between(3, 40) / f;
  // A slider must not pass the attachment point of its spring.
  if (kind == 1 && !o.turns && std::abs(pull) + std::abs(v) > 0) {
    const double fast = std::abs(v) + A * w, a = std::abs(pull) / m;
    duration = std::min(duration, 30 * A / (fast + std::sqrt(fast * fast + 30 * A * a)));
  }
  known(out, o.coordinate, one, duration);
}

}  // namespace freeplay::verification::random_scenes
