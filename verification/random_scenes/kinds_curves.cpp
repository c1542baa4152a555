// Bodies that curves move, with balls, stops, arms, teeth and journals on them.
#include "verification/random_scenes/builder.hpp"

namespace freeplay::verification::random_scenes {
namespace {

using std::numbers::pi;
using Curve = CurveShape;
using reference::MovingWall;

double restitution(Draw& draw, double least = 0.2) {
  return exact(draw.chance(0.3) ? 1 : draw.between(least, 0.97));
}

/// A curve that moves something by `size` over `period`, taken as a place or as a rate.
std::shared_ptr<DrivenMotion> moved_along(Builder& b, const std::string& joint, double period, double size,
                                          double until) {
  const bool rate = b.draw.chance(0.25);
  const double initial = rate ? exact(size * b.draw.either_way(1)) : 0;
  const auto curve = draw_curve(b.draw, {period, rate ? 3 * size / period : size, !rate});
  return b.driven(joint, curve, rate, initial, until);
}

/// Adds what both formulations know of a coordinate between walls; K over the mass and exponent of the compliant ones.
void moving(Builder& b, std::size_t coordinate, reference::OneCoordinate one, double stiffness,
            double exponent) {
  one.rest = 1e-7 * b.scene.speed;
  Moving m{coordinate, one, one};
  for (auto& w : m.compliant.walls) w.stiffness = stiffness, w.exponent = exponent;
  m.compliant.rest = exact(1e-3 * b.scene.speed);
  b.scene.moving.push_back(std::move(m));
}
/// Steps of the references, once the scene's times are known.
void settle(Builder& b) {
  for (auto& m : b.scene.moving) {
    m.rigid.step = m.compliant.step = b.scene.shortest / 400;
    m.compliant.step_in_contact =
        std::min(std::isfinite(b.contact) ? b.contact / 200 : INFINITY, m.rigid.step);
    m.rigid.step_in_contact = m.rigid.step;
  }
}

}  // namespace

void moved_table(Builder& b) {
  auto& draw = b.draw;
  const double T = 1 / draw.decades(-3, 4), g = exact(draw.chance(0.7) ? 9.81 : draw.decades(-1, 2));
  const double w = 2 * pi / T, strength = draw.decades(-0.5, 1);
  const double A = std::min(strength * g / (w * w), 10.0);
  // Flights of the order of the period, and of drops up to a metre.
  const double drop = std::min(0.5 * g * T * T * draw.decades(-2, 0.5), draw.decades(-2, 0));
  const double flight = std::sqrt(2 * drop / g), speed = std::max(g * flight, std::min(A * w, g * T));
  b.scene.speed = speed;
  b.flight = std::min(T, flight);
  b.gravity(g);
  const double until = 100 * b.flight, e = restitution(draw);
  const auto table = b.body("table", {.mass = 1, .inertia = 1});
  b.table("joints.guide", "type = \"translational\"\nbetween = [\"ground\", \"table\"]\naxis = [0, 1]\n");
  const auto motion = moved_along(b, "guide", T, A, until);
  b.still(table, 0, A);
  b.prescribed(table + 1, motion);
  b.still(table + 2, 0, 1);
  b.scene.speed = std::max(b.scene.speed, motion->rate);
  const int balls = draw.chance(0.7) ? 1 : draw.whole(2, 4);
  double K = 0;
  const double m = exact(draw.decades(-2, 1)), R = exact(draw.decades(-2.5, -1));
  // Soft contacts that a ball sinks into by a tenth of its radius are no Hertz contacts.
  K = b.surface(e, m, speed, R, std::min(b.flight * draw.decades(-2, -1.3), 0.01 * R / b.scene.speed));
  for (int i = 0; i < balls; ++i) {
    const double x = exact(3 * R * (i - 0.5 * (balls - 1)));
    const double y = exact(motion->at(0).y + R + drop * draw.between(0.3, 1));
    const double v = draw.chance(0.5) ? exact(motion->at(0).slope + 0.3 * speed * draw.either_way(1)) : 0;
    const auto q = b.body(fmt::format("ball{}", i),
                          {.mass = m, .inertia = exact(0.4 * m * R * R), .x = x, .y = y, .vy = v});
    b.table(fmt::format("contacts.c{}", i),
            fmt::format("type = \"plane\"\nbetween = [\"table\", \"ball{}\"]\nradius = {}\nsurface = \"s\"\n",
                        i, text_of(R)));
    b.still(q, x, R);
    b.still(q + 2, 0, 1);
    reference::OneCoordinate one;
    one.acceleration = [g](double, double, double) { return -g; };
    one.walls = {MovingWall{[motion, R](double t) {
                              auto p = motion->at(t);
                              p.y += R;
                              return p;
                            },
                            1, e}};
    one.next_kink = [motion](double t) { return motion->next_kink(t); };
    one.x = y, one.v = v;
    moving(b, q + 1, one, K / m, 1.5);
  }
  b.finish(until * draw.between(0.2, 1));
  settle(b);
}

void moved_stop(Builder& b) {
  auto& draw = b.draw;
  const double T = 1 / draw.decades(-3, 4), m = exact(draw.decades(-2, 1));
  const double w = 2 * pi / T, own = w * draw.decades(-1, 1), k = exact(m * own * own);
  const double A = std::min(draw.decades(-4, 0), 100 / w);
  const double room = exact(A * draw.decades(-1, 0.5)), speed = std::max(A * w, A * own);
  b.scene.speed = speed;
  b.flight = std::min({T, 2 * pi / own, room / speed * 2});
  const double until = 100 * b.flight, e = restitution(draw);
  const auto slide = b.body("slide", {.mass = 1, .inertia = 1});
  b.table("joints.guide", "type = \"translational\"\nbetween = [\"ground\", \"slide\"]\n");
  const auto motion = moved_along(b, "guide", T, A, until);
  b.prescribed(slide, motion);
  b.still(slide + 1, 0, A);
  b.still(slide + 2, 0, 1);
  const double x = exact(motion->at(0).y + room * draw.between(0.1, 0.9));
  const double v = draw.chance(0.5) ? exact(motion->at(0).slope + 0.5 * speed * draw.either_way(1)) : 0;
  const auto q = b.body("block", {.mass = m, .inertia = 1, .x = x, .vx = v});
  b.table("joints.on", "type = \"translational\"\nbetween = [\"slide\", \"block\"]\n");
  const double time = std::min(b.flight * draw.decades(-2, -1.3), 0.01 * std::min(A, room) / speed);
  const double ks = exact(m * std::pow(pi / time, 2));
  b.contact = pi * std::sqrt(m / ks);
  b.table(
      "contacts.stop",
      fmt::format(
          "type = \"travel-stop\"\njoint = \"on\"\nlower = 0\nupper = {}\nstiffness = {}\nsurface = \"s\"\n",
          text_of(room), text_of(ks)));
  b.table("surfaces.s", fmt::format("young = 2e11\npoisson = 0.3\nrestitution = {}\n", text_of(e)));
  const bool on_slide = draw.chance(0.5);
  const double far = exact(10 * (A + room) + 3 * motion->size + std::abs(motion->at(0).y)),
               free = exact(far * draw.between(0.95, 1.05));
  b.table(
      "loads.spring",
      fmt::format(
          "type = \"spring-damper\"\nbetween = [\"{}\", \"block\"]\nat = [[{}, 0], [0, 0]]\nstiffness = {}\nfree_length = {}\n",
          on_slide ? "slide" : "ground", text_of(-far), text_of(k), text_of(free)));
  b.still(q + 1, 0, room);
  b.still(q + 2, 0, 1);
  reference::OneCoordinate one;
  one.acceleration = [=](double t, double at, double) {
    return -k / m * (at + far - (on_slide ? motion->at(t).y : 0) - free);
  };
  one.walls = {MovingWall{[motion](double t) { return motion->at(t); }, 1, e},
               MovingWall{[motion, room](double t) {
                            auto p = motion->at(t);
                            p.y += room;
                            return p;
                          },
                          -1, e}};
  one.next_kink = [motion](double t) { return motion->next_kink(t); };
  one.x = x, one.v = v;
  moving(b, q, one, ks / m, 1);
  b.finish(until * draw.between(0.2, 1));
  settle(b);
}

void moved_lever(Builder& b) {
  auto& draw = b.draw;
  const double T = 1 / draw.decades(-3, 4), J = exact(draw.decades(-4, 0)), w = 2 * pi / T;
  const double A = draw.decades(-2, 0.5), room = exact(std::min(A * draw.decades(-1, 0.3), 3.0)),
               R = exact(draw.decades(-2, 0));
  b.scene.speed = A * w * R;
  b.flight = std::min(T, 2 * room / (A * w));
  const double until = 100 * b.flight, e = restitution(draw);
  const auto rotor = b.body("rotor", {.mass = 1, .inertia = 1});
  b.table("joints.shaft", "type = \"revolute\"\nbetween = [\"ground\", \"rotor\"]\n");
  const auto motion = moved_along(b, "shaft", T, A, until);
  b.still(rotor, 0, 1);
  b.still(rotor + 1, 0, 1);
  b.prescribed(rotor + 2, motion);
  const double x = exact(motion->at(0).y + room * draw.between(0.1, 0.9)),
               v = exact(motion->at(0).slope + 0.5 * A * w * draw.either_way(1));
  const auto q = b.body("arm", {.mass = 1, .inertia = J, .angle = x, .spin = v});
  b.table("joints.pin", "type = \"revolute\"\nbetween = [\"rotor\", \"arm\"]\n");
  const double time = b.flight * draw.decades(-2, -1.3), ks = exact(J / (R * R) * std::pow(pi / time, 2));
  b.contact = pi * std::sqrt(J / (R * R * ks));
  b.table(
      "contacts.stop",
      fmt::format(
          "type = \"angle-stop\"\njoint = \"pin\"\nradius = {}\nlower = 0\nupper = {}\nstiffness = {}\nsurface = \"s\"\n",
          text_of(R), text_of(room), text_of(ks)));
  b.table("surfaces.s", fmt::format("young = 2e11\npoisson = 0.3\nrestitution = {}\n", text_of(e)));
  const double M = exact(draw.chance(0.5) ? J * A * w * w * draw.either_way(0.3) : 0);
  if (M != 0)
    b.table("loads.push", fmt::format("type = \"torque\"\nbody = \"arm\"\ntorque = {}\n", text_of(M)));
  b.still(q, 0, 1);
  b.still(q + 1, 0, 1);
  reference::OneCoordinate one;
  one.acceleration = [=](double, double, double) { return M / J; };
  one.walls = {MovingWall{[motion](double t) { return motion->at(t); }, 1, e},
               MovingWall{[motion, room](double t) {
                            auto p = motion->at(t);
                            p.y += room;
                            return p;
                          },
                          -1, e}};
  one.next_kink = [motion](double t) { return motion->next_kink(t); };
  one.x = x, one.v = v;
  moving(b, q + 2, one, ks * R * R / J, 1);
  for (auto* o : {&b.scene.moving.back().rigid, &b.scene.moving.back().compliant}) o->rest /= R;
  b.finish(until * draw.between(0.2, 1));
  settle(b);
}

void teeth(Builder& b) {
  auto& draw = b.draw;
  const double T = 1 / draw.decades(-3, 4), w = 2 * pi / T;
  const double r1 = exact(draw.decades(-2, -0.5)), r2 = exact(r1 * draw.decades(-0.5, 0.5));
  const double J = exact(draw.decades(-5, -1)), play = exact(r1 * draw.decades(-3.5, -2)),
               alpha = 20 * pi / 180;
  const double A = play / r1 * draw.decades(0, 2), base = r2 * std::cos(alpha), half = 0.5 * play / base;
  const double pace = A * w * r1;
  b.scene.speed = pace;
  b.flight = std::min(T, play / pace);
  const double until = 100 * b.flight, e = restitution(draw);
  // The centres stand still, or on an arm that turns evenly about the first.
  const bool turns = draw.chance(0.5);
  const double spin = turns ? exact(w * draw.decades(-2, 0) * draw.sign()) : 0;
  const std::string on = turns ? "arm" : "ground";
  if (turns) {
    const auto arm = b.body("arm", {.mass = 1, .inertia = 1, .spin = spin});
    b.table("joints.turn", "type = \"revolute\"\nbetween = [\"ground\", \"arm\"]\n");
    b.table("drives.turn", fmt::format("joint = \"turn\"\nspeed = {}\ninitial_angle = 0\n", text_of(spin)));
    b.still(arm, 0, r1);
    b.still(arm + 1, 0, r1);
    b.scene.prescribed.push_back({arm + 2,
                                  [spin](double t, Coordinates, Coordinates) {
                                    return CurvePoint{spin * t, spin, 0};
                                  },
                                  1, std::abs(spin), 0});
  }
  const auto one_ = b.body("one", {.mass = 1, .inertia = 1});
  b.table("joints.shaft", fmt::format("type = \"revolute\"\nbetween = [\"{}\", \"one\"]\n", on));
  const auto motion = moved_along(b, "shaft", T, A, until);
  b.still(one_, 0, r1);
  b.still(one_ + 1, 0, r1);
  b.scene.prescribed.push_back({one_ + 2,
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
  const auto q = b.body(
      "two", {.mass = 1, .inertia = J, .x = distance, .angle = x, .vy = exact(distance * spin), .spin = v});
  b.table("joints.second",
          fmt::format("type = \"revolute\"\nbetween = [\"{}\", \"two\"]\nat = [[{}, 0], [0, 0]]\n", on,
                      text_of(distance)));
  const double time = b.flight * draw.decades(-2, -1.3),
               ks = exact(J / (base * base) * std::pow(pi / time, 2));
  b.contact = pi * std::sqrt(J / (base * base * ks));
  b.table(
      "joints.mesh",
      fmt::format(
          "type = \"gear\"\nbetween = [\"one\", \"two\"]\npitch_radii = [{}, {}]\nphase = {}\nbacklash = {}\nmesh_stiffness = {}\nsurface = \"s\"\n",
          text_of(r1), text_of(r2), text_of(phase), text_of(play), text_of(ks)));
  b.table("surfaces.s", fmt::format("young = 2e11\npoisson = 0.3\nrestitution = {}\n", text_of(e)));
  const double rate = distance * std::abs(spin), bend = rate * std::abs(spin);
  b.scene.prescribed.push_back(
      {q,
       [=](double t, Coordinates, Coordinates) {
         const double a = spin * t;
         return CurvePoint{distance * std::cos(a), -distance * spin * std::sin(a), 0};
       },
       r2, rate, bend});
  b.scene.prescribed.push_back({q + 1,
                                [=](double t, Coordinates, Coordinates) {
                                  const double a = spin * t;
                                  return CurvePoint{distance * std::sin(a), distance * spin * std::cos(a), 0};
                                },
                                r2, rate, bend});
  reference::OneCoordinate o;
  o.acceleration = [](double, double, double) { return 0.0; };
  for (const double side : {1.0, -1.0})
    o.walls.push_back({[=](double t) {
                         const auto p = motion->at(t);
                         return CurvePoint{spin * t + phase - ratio * p.y - side * half,
                                           spin - ratio * p.slope, -ratio * p.bend};
                       },
                       side, e});
  o.next_kink = [motion](double t) { return motion->next_kink(t); };
  o.x = x, o.v = v;
  moving(b, q + 2, o, ks * base * base / J, 1);
  for (auto* p : {&b.scene.moving.back().rigid, &b.scene.moving.back().compliant}) p->rest /= base;
  b.finish(until * draw.between(0.2, 1));
  settle(b);
}

void moved_journal(Builder& b) {
  auto& draw = b.draw;
  const double T = 1 / draw.decades(-3, 4), w = 2 * pi / T, c = exact(draw.decades(-5, -3)),
               R = exact(draw.decades(-2, -1));
  const double A = c * draw.decades(0, 2), speed = A * w;
  const double g = exact(speed * speed / c * draw.decades(-2, 0));
  b.scene.speed = speed;
  b.flight = std::min(T, c / speed);
  const double until = 60 * b.flight, e = restitution(draw);
  b.gravity(g);
  const auto box = b.body("box", {.mass = 1, .inertia = 1});
  b.table("joints.guide", "type = \"translational\"\nbetween = [\"ground\", \"box\"]\naxis = [0, 1]\n");
  const auto motion = moved_along(b, "guide", T, A, until);
  b.still(box, 0, A);
  b.prescribed(box + 1, motion);
  b.still(box + 2, 0, 1);
  const double m = exact(draw.decades(-2, 1));
  const auto q = b.body("pin", {.mass = m,
                                .inertia = exact(m * R * R),
                                .x = exact(c * draw.either_way(0.5)),
                                .y = exact(motion->at(0).y + c * draw.either_way(0.5)),
                                .vx = exact(0.3 * speed * draw.either_way(1)),
                                .vy = exact(motion->at(0).slope)});
  b.table(
      "joints.loose",
      fmt::format(
          "type = \"revolute\"\nbetween = [\"box\", \"pin\"]\nclearance = {}\nbearing_radius = {}\nsurface = \"s\"\n",
          text_of(c), text_of(R)));
  b.surface(e, m, speed, R * R / c, b.flight * draw.decades(-2, -1.3));
  for (int k = 0; k < 3; ++k) b.scene.others.push_back(q + static_cast<std::size_t>(k));
  b.finish(until * draw.between(0.2, 1));
}

void follower(Builder& b) {
  auto& draw = b.draw;
  const double w = draw.decades(-2, 4) * draw.sign(), lift = draw.decades(-4, -1),
               turn = 2 * pi / draw.whole(1, 4);
  const double J = exact(draw.decades(-4, 1)), m = exact(J / (lift * lift) * draw.decades(-3, 0.5));
  const double start = exact(draw.angle());
  const bool driven = draw.chance(0.4);
  b.flight = turn / std::abs(w);
  b.scene.speed = std::abs(w) * lift;
  const auto rotor = b.body("rotor", {.mass = 1, .inertia = J, .angle = start, .spin = exact(w)});
  b.table("joints.shaft", "type = \"revolute\"\nbetween = [\"ground\", \"rotor\"]\n");
  const auto curve = draw_curve(draw, {turn, lift, true});
  const auto shape = std::make_shared<Curve>(curve.shape);
  b.table("curves.y", curve.lines);
  const auto at = shape->at(start);
  const auto q = b.body("follower", {.mass = m, .inertia = 1, .y = exact(at.y), .vy = exact(at.slope * w)});
  b.table("joints.guide", "type = \"translational\"\nbetween = [\"ground\", \"follower\"]\naxis = [0, 1]\n");
  b.table("drives.lift", "joint = \"guide\"\nposition = \"y\"\nof = \"shaft\"\n");
  if (driven) b.table("drives.motor", fmt::format("joint = \"shaft\"\nspeed = {}\n", text_of(exact(w))));
  b.still(rotor, 0, lift);
  b.still(rotor + 1, 0, lift);
  b.still(q, 0, lift);
  b.still(q + 2, 0, 1);
  const double slope = lift / turn * 6;
  b.scene.prescribed.push_back({q + 1,
                                [shape, rotor](double, Coordinates x, Coordinates v) {
                                  auto p = shape->at(x[rotor + 2]);
                                  p.slope *= v[rotor + 2];
                                  return p;
                                },
                                lift, slope * std::abs(w), 6 * slope * w * w / turn * 6});
  // m y′² is added to the rotor's inertia: (J + m y′²) φ̈ + m y′ y″ φ̇² + k (y − y₀) y′ + m g y′ = 0.
  const double k = exact(draw.chance(0.5) ? J * w * w / (lift * lift) * draw.decades(-2, 0.5) : 0),
               far = exact(20 * lift);
  const double rest = exact(far - lift * draw.between(0, 2)), wx = exact(w);
  if (k > 0)
    b.table(
        "loads.spring",
        fmt::format(
            "type = \"spring-damper\"\nbetween = [\"ground\", \"follower\"]\nat = [[0, {}], [0, 0]]\nstiffness = {}\nfree_length = {}\n",
            text_of(-far), text_of(k), text_of(rest)));
  if (driven) {
    b.scene.prescribed.push_back({rotor + 2,
                                  [=](double t, Coordinates, Coordinates) {
                                    return CurvePoint{start + wx * t, wx, 0};
                                  },
                                  turn, std::abs(w), 0});
  } else {
    reference::OneCoordinate one;
    one.acceleration = [=](double, double x, double v) {
      const auto p = shape->at(x);
      return -(m * p.slope * p.bend * v * v + k * (p.y + far - rest) * p.slope) / (J + m * p.slope * p.slope);
    };
    one.kinks = shape->kinks(start - 700, start + 700);
    one.x = start, one.v = wx;
    b.scene.moving.push_back({rotor + 2, one, one});
    b.scene.energy = [=](Coordinates x, Coordinates v) {
      const double y = x[q + 1] + far - rest;
      return 0.5 * (J * v[rotor + 2] * v[rotor + 2] + m * v[q + 1] * v[q + 1] + k * y * y);
    };
  }
  b.finish(b.flight * draw.between(5, 60));
  settle(b);
}

void two_scales(Builder& b) {
  auto& draw = b.draw;
  // A fast oscillator on a stop beside something slow that is driven.
  const double f = draw.decades(0, 3.5), own = 2 * pi * f, m = exact(draw.decades(-2, 1)),
               k = exact(m * own * own);
  const double slow = f * draw.decades(-6, -1.5), A = exact(draw.decades(-4, -1)), e = restitution(draw, 0.5);
  b.flight = 0.5 / f;
  b.scene.speed = A * own;
  const double until = 50 / f;
  if (draw.chance(0.5)) {
    const auto rotor = b.body("slow", {.mass = 1, .inertia = 1});
    const double w = exact(2 * pi * slow);
    b.table("joints.shaft", "type = \"revolute\"\nbetween = [\"ground\", \"slow\"]\n");
    b.table("drives.motor", fmt::format("joint = \"shaft\"\nspeed = {}\ninitial_angle = 0\n", text_of(w)));
    b.still(rotor, 0, 1);
    b.still(rotor + 1, 0, 1);
    b.scene.prescribed.push_back({rotor + 2,
                                  [=](double t, Coordinates, Coordinates) {
                                    return CurvePoint{w * t, w, 0};
                                  },
                                  w * until, w, 0});
  } else {
    const auto table = b.body("slow", {.mass = 1, .inertia = 1});
    b.table("joints.guide", "type = \"translational\"\nbetween = [\"ground\", \"slow\"]\naxis = [0, 1]\n");
    const auto motion = moved_along(b, "guide", 1 / slow, draw.decades(-2, 0), until);
    b.still(table, 0, 1);
    b.prescribed(table + 1, motion);
    b.still(table + 2, 0, 1);
  }
  const double x = exact(A * draw.between(0.3, 1)), free = exact(10 * A),
               stop = exact(-A * draw.between(0, 0.6));
  const auto q = b.body("block", {.mass = m, .inertia = 1, .x = x});
  b.table("joints.on", "type = \"translational\"\nbetween = [\"ground\", \"block\"]\n");
  const double ks = exact(m * std::pow(pi / (b.flight * draw.decades(-2, -1.3)), 2));
  b.contact = pi * std::sqrt(m / ks);
  b.table("contacts.stop",
          fmt::format("type = \"travel-stop\"\njoint = \"on\"\nlower = {}\nstiffness = {}\nsurface = \"s\"\n",
                      text_of(stop), text_of(ks)));
  b.table("surfaces.s", fmt::format("young = 2e11\npoisson = 0.3\nrestitution = {}\n", text_of(e)));
  b.table(
      "loads.spring",
      fmt::format(
          "type = \"spring-damper\"\nbetween = [\"ground\", \"block\"]\nat = [[{}, 0], [0, 0]]\nstiffness = {}\nfree_length = {}\n",
          text_of(-free), text_of(k), text_of(free)));
  b.still(q + 1, 0, A);
  b.still(q + 2, 0, 1);
  reference::OneCoordinate one;
  one.acceleration = [=](double, double at, double) { return -k / m * at; };
  one.walls = {MovingWall{[stop](double) { return CurvePoint{stop, 0, 0}; }, 1, e}};
  one.x = x;
  moving(b, q, one, ks / m, 1);
  b.finish(until * draw.between(0.2, 1));
  settle(b);
}

}  // namespace freeplay::verification::random_scenes
