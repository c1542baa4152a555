// Discs against outlines, sampled controllers, and restitution that depends on the approach speed.
#include <algorithm>

#include "verification/random_scenes/draft.hpp"
#include "verification/references/disc_on_outline.hpp"
#include "verification/references/sampled_loop.hpp"

namespace freeplay::verification::random_scenes {
namespace {

using reference::Change;
using reference::DiscOnOutline;
using reference::OneCoordinate;
using reference::SampledLoop;
using std::numbers::pi;

/// Corners on a circle, counterclockwise, which leave the centre inside.
std::vector<Vec2> corners(Draw& draw, double size) {
  const int n = draw.whole(2, 6);
  const double from = draw.angle();
  std::vector<Vec2> list;
  for (int i = 0; i < n; ++i) {
    const double a = from + 2 * pi / n * (i + (n == 2 ? 0 : draw.either_way(0.15)));
    list.push_back({exact(size * std::cos(a)), exact(size * std::sin(a))});
  }
  return list;
}

/// Centres of the corners' arcs: each at a distance r from both edges, inside.
std::vector<Vec2> arc_centres(const std::vector<Vec2>& points, double r) {
  const std::size_t n = points.size();
  if (n == 2) return points;
  std::vector<Vec2> list;
  for (std::size_t k = 0; k < n; ++k) {
    const Vec2 p = points[k], before = p - points[(k + n - 1) % n], after = points[(k + 1) % n] - p;
    const Vec2 u = (1 / before.norm()) * before, w = (1 / after.norm()) * after;
    // The bisector of the interior angle; sin of half this angle is |u + w|/2.
    const Vec2 inward = w - u;
    const double half = 0.5 * (u + w).norm();
    list.push_back(p + r / half / inward.norm() * inward);
  }
  return list;
}

}  // namespace

void outlines(Draw& draw, Draft& out) {
  out.given = true;
  const double L = exact(draw.decades(-3, 0)), V = exact(L * draw.decades(-1, 2)), T = L / V;
  const auto points = corners(draw, L);
  const double round = draw.chance(0.2) ? 0 : exact(L * draw.between(0.02, 0.06));
  const double R = round > 0 && draw.chance(0.2) ? 0 : exact(L * draw.decades(-1.3, -0.3));
  const double m = exact(draw.decades(-2, 1)), e = exact(draw.chance(0.3) ? 1 : draw.between(0.2, 0.97));
  // At rest, or turning at constant speed.
  const bool turns = draw.chance(0.5);
  const double w = turns ? exact(V / L * draw.either_way(1.5)) : 0;
  const Vec2 g{0, draw.chance(0.4) ? -exact(V * V / L * draw.decades(-1, 0)) : 0};
  if (g.y() != 0) out.gravity(g);
  if (turns) {
    const auto rotor = out.body({.name = "rotor", .spin = w});
    out.table("joints.pin", "type = \"revolute\"\nbetween = [\"ground\", \"rotor\"]\n");
    out.table("drives.turn", toml("joint = 'pin'\nspeed = {}\ninitial_angle = 0\n", w));
    out.still(rotor, 0, L);
    out.still(rotor + 1, 0, L);
    out.steady(rotor + 2, 0, w, 1);
  }
  // Towards the outline, past its centre by a part of its size.
  const double from = draw.angle(), away = L * draw.between(1.2, 2) + R + round,
               past = L * draw.either_way(0.7);
  const Vec2 along{-std::cos(from), -std::sin(from)}, start = past * perp(along) - away * along;
  DiscOnOutline one;
  for (const auto& c : arc_centres(points, round)) one.centres.push_back({c.x(), c.y()});
  one.reach = R + round, one.spin = w, one.gravity = {g.x(), g.y()};
  one.restitution = e;
  one.at = {exact(start.x()), exact(start.y())};
  one.velocity = {exact(V * along.x()), exact(V * along.y())};
  const double spin = exact(V / L * draw.either_way(1));
  const auto q = out.body({.name = "disc",
                           .mass = m,
                           .inertia = exact(0.5 * m * std::max(R, 0.1 * L) * std::max(R, 0.1 * L)),
                           .at = {one.at.x, one.at.y},
                           .velocity = {one.velocity.x, one.velocity.y},
                           .spin = spin});
  out.scene.speed = V;
  out.flight = 0.25 * T;
  out.longest = 4000;
  const double fastest = V + 2 * std::abs(w) * L + 2 * std::sqrt(L * g.norm());
  const double ks =
      stop_stiffness(out, m, 1, std::min(out.flight * draw.decades(-2, -1.3), 0.1 * one.reach / fastest));
  std::string list;
  for (const auto& p : points) list += (list.empty() ? "" : ", ") + text_of(p);
  out.table(
      "contacts.hit",
      toml("type = 'outline'\nbetween = ['{}', 'disc']\npoints = [{}]\ncorner_radius = {}\nradius = {}\n"
           "stiffness = {}\nsurface = 's'\n",
           turns ? "rotor" : "ground", list, round, R, ks));
  out.surface(e);
  out.steady(q + 2, 0, spin, 1);
  // Up to the fourth onset, so that a disc does not come to rest.
  one.step = one.step_in_contact = out.flight / 400;
  one.rest = 1e-3 * V;
  double until = T * draw.between(3, 6);
  std::vector<double> instants;
  for (int k = 1; k <= 100; ++k) instants.push_back(0.01 * k * until);
  const auto found = one.rows(instants);
  const auto& onsets = found.onsets;
  if (onsets.size() > 3)
    until = 0.5 * (onsets[2] + onsets[3]);
  else if (found.p.size() < instants.size() && !onsets.empty())
    until = 0.9 * onsets.back();
  out.finish(until);
  one.step = one.step_in_contact = out.scene.shortest / 400;
  auto soft = one;
  soft.stiffness = ks / m, soft.step_in_contact = std::min(out.contact / 200, one.step);
  for (const bool y : {false, true})
    out.scene.derived.push_back(
        {q + (y ? 1 : 0), [one, soft, y](Family family, const std::vector<double>& at, const Change& c) {
           const auto rows = (family == Family::penalty ? soft : one).under(c).rows(at);
           OneCoordinate::Rows list;
           list.known = rows.p.size();
           for (std::size_t k = 0; k < list.known; ++k) {
             list.x.push_back(y ? rows.p[k].y : rows.p[k].x);
             list.v.push_back(y ? rows.v[k].y : rows.v[k].x);
           }
           return list;
         }});
}

void sampled_loops(Draw& draw, Draft& out) {
  out.given = true;
  // Of the loop without sampling: ω = 1/T and damping ratio.
  const double T = 1 / draw.decades(-2, 3), A = draw.decades(-3, 0), ratio = draw.between(0.4, 1.2);
  const bool slides = draw.chance(0.4);
  SampledLoop loop;
  loop.mass = exact(draw.decades(-3, 1));
  loop.proportional = exact(loop.mass / (T * T));
  loop.derivative = exact(2 * ratio * loop.mass / T);
  loop.sampling = exact(T * draw.decades(-2, -1));
  const int delay = draw.whole(0, 2);  // none, whole samples, any
  if (delay > 0) loop.dead = exact(loop.sampling * (delay == 1 ? draw.whole(1, 2) : draw.between(0.05, 1.9)));
  loop.x = exact(A * draw.either_way(1)), loop.v = exact(A / T * draw.either_way(1));
  std::string lines;
  if (draw.chance(0.5)) {
    loop.integral = exact(loop.proportional / T * draw.between(0.05, 0.2));
    lines += toml("integral = {}\n", loop.integral);
  }
  if (draw.chance(0.5)) {
    loop.limit = exact(loop.proportional * A * draw.between(0.3, 1.5));
    lines += toml("{}_limit = {}\n", slides ? "force" : "torque", *loop.limit);
    if (loop.integral > 0 && draw.chance(0.5)) {
      loop.tracking = exact(T * draw.between(0.5, 5));
      lines += toml("tracking_time = {}\n", *loop.tracking);
    }
  }
  // Rounding of a position that a scheme knows up to its tolerance only would differ: without a lag all
  // schemes have exact positions.
  const int more = draw.whole(0, 3);
  if (more == 0) {
    loop.lag = exact(T * draw.between(0.02, 0.2));
    lines += toml("lag = {}\n", *loop.lag);
  } else if (more == 1) {
    loop.resolution = exact(A * draw.decades(-2.5, -1.5));
    lines += toml("resolution = {}\n", *loop.resolution);
  }
  if (draw.chance(0.5)) loop.force = exact(loop.proportional * A * draw.either_way(0.2));
  const std::string name = slides ? "block" : "rotor";
  const auto q =
      out.body(slides ? DraftBody{.name = name, .mass = loop.mass, .at = {loop.x, 0}, .velocity = {loop.v, 0}}
                      : DraftBody{.name = name, .inertia = loop.mass, .angle = loop.x, .spin = loop.v});
  out.table("joints.on",
            toml("type = '{}'\nbetween = ['ground', '{}']\n", slides ? "translational" : "revolute", name));
  out.still(q + 1, 0, A);
  slides ? out.still(q + 2, 0, 1) : out.still(q, 0, A);
  if (loop.force != 0)
    out.table("loads.push", slides ? toml("type = 'force'\nbody = 'block'\nforce = [{}, 0]\n", loop.force)
                                   : toml("type = 'torque'\nbody = 'rotor'\ntorque = {}\n", loop.force));
  const std::string key = slides ? "target_position" : "target_angle";
  if (draw.chance(0.5)) {
    const double target = exact(A * draw.either_way(1));
    loop.target = [target](double) { return target; };
    lines = toml("{} = {}\n", key, target) + lines;
  } else {
    const auto curve = draw_curve(draw, {T * draw.between(5, 15), A, true});
    const auto shape = std::make_shared<CurveShape>(curve.shape);
    out.table("curves.target", curve.lines);
    loop.target = [shape](double t) { return shape->at(t).y; };
    lines = toml("{} = 'target'\n", key) + lines;
  }
  out.table("drives.servo", "joint = \"on\"\n" + lines +
                                toml("proportional = {}\nderivative = {}\nsampling_time = {}\n{}",
                                     loop.proportional, loop.derivative, loop.sampling,
                                     loop.dead > 0 ? toml("dead_time = {}\n", loop.dead) : ""));
  out.scene.speed = A / T;
  out.flight = T;
  out.finish(T * draw.between(5, 40));
  out.scene.derived.push_back(
      {slides ? q : q + 2, [loop](Family, const std::vector<double>& instants, const Change& change) {
         return loop.at(instants, change);
       }});
}

void yielding(Draw& draw, Draft& out) {
  out.given = true;
  const double T = 1 / draw.decades(-2, 3), g = exact(draw.chance(0.7) ? 9.81 : draw.decades(-1, 2));
  const double drop = std::min(0.5 * g * T * T, 10.0), flight = std::sqrt(2 * drop / g), speed = g * flight;
  out.flight = flight;
  out.gravity({0, -g});
  const double until = 100 * flight;
  // On the ground, or on a table that a curve moves.
  const bool moved = draw.chance(0.5);
  std::shared_ptr<DrivenMotion> motion;
  if (moved) {
    const double A = std::min(0.3 * speed * flight, 1.0) * draw.decades(-1, 0);
    motion = out.driven("guide", draw_curve(draw, {flight * draw.decades(0, 1), A, true}), false, 0, until);
    const auto start = motion->at(0);
    const auto q =
        out.body({.name = "table", .at = {0, exact(start.y)}, .velocity = {0, exact(start.slope)}});
    out.table("joints.guide", "type = \"translational\"\nbetween = [\"ground\", \"table\"]\naxis = [0, 1]\n");
    out.still(q, 0, A);
    out.prescribed(q + 1, motion);
    out.still(q + 2, 0, 1);
    out.flight = std::min(flight, motion->period);
  }
  out.scene.speed = moved ? std::max(speed, motion->rate) : speed;
  const double m = exact(draw.decades(-2, 1)), R = exact(draw.decades(-2.5, -1));
  const double K = out.surface(1, m, out.scene.speed, R,
                               std::min(out.flight * draw.decades(-2, -1.3), 0.01 * R / out.scene.speed));
  // The restitution by the approach speed, in place of the one of 1.
  out.text.erase(out.text.rfind("restitution"));
  std::function<double(double)> e;
  if (draw.chance(0.5)) {
    const double slow = exact(draw.between(0.5, 1)), yields = exact(speed * draw.decades(-1.5, 0));
    out.text += toml("restitution = {}\nyield_speed = {}\n", slow, yields);
    e = [=](double v) { return v > yields ? slow * std::pow(yields / v, 0.25) : slow; };
  } else {
    const int n = draw.whole(2, 5);
    std::vector<std::pair<double, double>> table;
    std::string list;
    double at = 0, value = draw.between(0.7, 1);
    for (int i = 0; i < n; ++i) {
      table.emplace_back(exact(at), exact(value));
      list += toml("{}[{}, {}]", i ? ", " : "", at, value);
      at += speed * draw.between(0.1, 0.8), value *= draw.between(0.75, 1);
    }
    out.text += toml("restitution_table = [{}]\n", list);
    e = [table](double v) {
      for (std::size_t i = 1; i < table.size(); ++i)
        if (v < table[i].first) {
          const auto &a = table[i - 1], &b = table[i];
          return a.second + (b.second - a.second) * (v - a.first) / (b.first - a.first);
        }
      return table.back().second;
    };
  }
  const double y = exact((moved ? motion->at(0).y : 0) + R + drop * draw.between(0.3, 1));
  const double v =
      draw.chance(0.5) ? exact((moved ? motion->at(0).slope : 0) + 0.3 * speed * draw.either_way(1)) : 0;
  const auto q = out.body(
      {.name = "ball", .mass = m, .inertia = exact(0.4 * m * R * R), .at = {0, y}, .velocity = {0, v}});
  out.table("contacts.floor", toml("type = 'plane'\nbetween = ['{}', 'ball']\nradius = {}\nsurface = 's'\n",
                                   moved ? "table" : "ground", R));
  out.still(q, 0, R);
  out.still(q + 2, 0, 1);
  OneCoordinate one;
  one.acceleration = [g](double, double, double) { return -g; };
  if (moved) one.next_kink = [motion](double t) { return motion->next_kink(t); };
  one.x = y, one.v = v;
  reference::MovingWall floor;
  floor.place = [=](double t) {
    auto p = moved ? motion->at(t) : CurvePoint{};
    p.y += R;
    return p;
  };
  floor.by_speed = e;
  one.walls = {floor};
  moving(out, q + 1, one, K / m, 1.5);
  finish_moving(out, until * draw.between(0.1, 0.5));
}

}  // namespace freeplay::verification::random_scenes
