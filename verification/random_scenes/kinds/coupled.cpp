// Rotors and sliders coupled by one element: ratios, freewheels, friction of fixed bound, lossy gears.
#include <algorithm>
#include <array>

#include "verification/random_scenes/draft.hpp"
#include "verification/references/dry_coordinate.hpp"

namespace freeplay::verification::random_scenes {
namespace {

using reference::Change;
using reference::DryCoordinate;
using reference::OneCoordinate;
using std::numbers::pi;

/// A rotor or slider on a joint with the ground, or with a body `on` at the same place.
struct Mover {
  bool slides = false;
  std::size_t coordinate = 0;
};
Mover mover(Draft& out, const std::string& name, bool slides, double inertia, double x, double v, double size,
            const std::string& on = "ground") {
  const auto q = out.body(slides ? DraftBody{.name = name, .mass = inertia, .at = {x, 0}, .velocity = {v, 0}}
                                 : DraftBody{.name = name, .inertia = inertia, .angle = x, .spin = v});
  out.table("joints.on_" + name,
            toml("type = '{}'\nbetween = ['{}', '{}']\n", slides ? "translational" : "revolute", on, name));
  out.still(q + 1, 0, size);
  slides ? out.still(q + 2, 0, 1) : out.still(q, 0, size);
  return {slides, slides ? q : q + 2};
}

/// A constant force or torque on a body.
void push(Draft& out, const std::string& body, bool slides, double effort) {
  if (effort == 0) return;
  out.table("loads.push_" + body, slides
                                      ? toml("type = 'force'\nbody = '{}'\nforce = [{}, 0]\n", body, effort)
                                      : toml("type = 'torque'\nbody = '{}'\ntorque = {}\n", body, effort));
}

/// A force or torque of a curve against time on a body.
struct Effort {
  std::function<double(double)> at = [](double) { return 0.0; };
  std::function<double(double)> next_kink = {};
};
Effort shake(Draw& draw, Draft& out, const std::string& body, bool slides, double period, double size,
             double until) {
  const auto curve = draw_curve(draw, {period, size, false});
  out.table("curves.shake", curve.lines);
  out.table("loads.shake", (slides ? toml("type = 'force'\nbody = '{}'\nforce = [1, 0]\n", body)
                                   : toml("type = 'torque'\nbody = '{}'\ntorque = 1\n", body)) +
                               "factor = \"shake\"\nagainst = \"time\"\n");
  const auto shape = std::make_shared<CurveShape>(curve.shape);
  const auto kinks = std::make_shared<std::vector<double>>(shape->kinks(0, until));
  return {[shape](double t) { return shape->at(t).y; },
          [kinks](double t) {
            const auto next = std::upper_bound(kinks->begin(), kinks->end(), t * (1 + 1e-14));
            return next == kinks->end() ? INFINITY : *next;
          }};
}

/// A coordinate with dry friction; in the penalty formulation, friction is linear up to a speed of slip that
/// an inertia loses within `decay`.
void dry(Draft& out, std::size_t coordinate, const DryCoordinate& rigid, const OneCoordinate& compliant,
         double decay, double duration) {
  out.contact = 4 * decay;  // rk4 takes ten steps within the decay
  out.finish(duration);
  auto sticking = rigid;
  sticking.step = out.scene.shortest / 400;
  auto linear = compliant;
  linear.step = linear.step_in_contact = std::min(decay / 20, sticking.step);
  out.scene.derived.push_back(
      {coordinate, [sticking, linear](Family family, const std::vector<double>& instants, const Change& c) {
         return family == Family::penalty ? linear.under(c).at(instants, 4'000'000)
                                          : sticking.under(c).at(instants);
       }});
}

/// Where the first body `lead` is at θ and the second one at y: z = y − r θ − offset moves as one coordinate
/// with the reduced inertia, and S = J₁ θ + r J₂ y under the loads alone.
struct Pair {
  std::size_t lead = 0, follow = 0;
  double J1 = 1, J2 = 1, r = 1, offset = 0;
  std::array<double, 3> S{};  ///< of 1, t, t²

  void known(Draft& out, const OneCoordinate& rigid, const OneCoordinate& compliant) const {
    for (const bool second : {false, true})
      out.scene.derived.push_back(
          {second ? follow : lead, [p = *this, rigid, compliant, second](
                                       Family family, const std::vector<double>& instants, const Change& c) {
             auto rows = (family == Family::penalty ? compliant : rigid).under(c).at(instants);
             for (std::size_t k = 0; k < rows.known; ++k) {
               const double t = instants[k], z = rows.x[k] + p.offset, u = rows.v[k];
               const double J = p.J1 + p.r * p.r * p.J2;
               const double turn = (p.S[0] + t * (p.S[1] + t * p.S[2]) - p.r * p.J2 * z) / J,
                            rate = (p.S[1] + 2 * t * p.S[2] - p.r * p.J2 * u) / J;
               rows.x[k] = second ? z + p.r * turn : turn;
               rows.v[k] = second ? u + p.r * rate : rate;
             }
             return rows;
           }});
  }
};

/// The reference of a ratio with backlash b, whose stops at the radius R have this stiffness.
void backlash(Draft& out, const Pair& pair, OneCoordinate one, double b, double e, double stiffness, double R,
              double inertia) {
  for (const double side : {1.0, -1.0})
    one.walls.push_back({[=](double) { return reference::CurvePoint{-0.5 * side * b, 0, 0}; }, side, e});
  auto soft = one;
  one.rest = 1e-7 * out.scene.speed / R;
  soft.rest = exact(1e-3 * out.scene.speed) / R;
  for (auto& w : soft.walls) w.stiffness = stiffness * R * R / inertia, w.exponent = 1;
  one.step = one.step_in_contact = soft.step = out.scene.shortest / 400;
  soft.step_in_contact = std::min(out.contact / 200, soft.step);
  pair.known(out, one, soft);
}

}  // namespace

void ratio_trains(Draw& draw, Draft& out) {
  out.given = true;
  const double T = 1 / draw.decades(-2, 3), A = draw.decades(-2, 0.5);
  const bool slides = draw.chance(0.4);
  const double r = exact((slides ? draw.decades(-2, 0) : draw.decades(-0.7, 0.7)) * draw.sign());
  Pair p{.J1 = exact(draw.decades(-4, 0)), .r = r};
  p.J2 = exact(p.J1 / (r * r) * draw.decades(-1, 1));
  p.offset = exact(std::abs(r) * A * draw.either_way(3));
  const double reduced = 1 / (1 / p.J2 + r * r / p.J1);
  const int kind = draw.whole(0, 2);
  const double b = kind == 1 ? exact(std::abs(r) * A * draw.decades(-2, -0.3)) : 0;
  const double turn = exact(A * draw.either_way(1)), rate = exact(A / T * draw.either_way(1));
  // z and its rate at the start: none, within the backlash, or of an oscillation.
  const double size = kind == 1 ? 0.5 * b : std::abs(r) * A;
  const double z0 = kind == 0 ? 0 : size * draw.either_way(0.9),
               u0 = kind == 0 ? 0 : size / T * draw.between(0.5, 2) * draw.sign();
  const double y = exact(r * turn + p.offset + z0), v = exact(r * rate + u0);
  p.lead = mover(out, "lead", false, p.J1, turn, rate, A).coordinate;
  p.follow = mover(out, "follow", slides, p.J2, y, v, A).coordinate;
  const std::string lines =
      toml("joint = 'on_follow'\nof = 'on_lead'\nratio = {}\noffset = {}\n", r, p.offset);
  out.flight = T;
  if (kind == 0) {
    out.table("joints.belt", "type = \"ratio\"\n" + lines);
    const double J = p.J1 + r * r * p.J2, M = J * A / (T * T) * draw.decades(-0.5, 1);
    const double F = exact(draw.chance(0.5) ? M / r * draw.either_way(0.5) : 0);
    push(out, "follow", slides, F);
    const auto effort = shake(draw, out, "lead", false, T, M, 110 * T);
    out.scene.speed = A / T;
    OneCoordinate one;
    one.acceleration = [=](double t, double, double) { return (effort.at(t) + r * F) / J; };
    one.next_kink = effort.next_kink;
    one.x = turn, one.v = rate;
    out.scene.prescribed.push_back({p.follow,
                                    [p](double, Coordinates q, Coordinates u) {
                                      return CurvePoint{p.r * q[p.lead] + p.offset, p.r * u[p.lead], 0};
                                    },
                                    std::abs(r) * A, 10 * std::abs(r) * A / T,
                                    std::abs(r) * (M + std::abs(r * F)) / J});
    out.finish(T * draw.between(3, 50));
    one.step = one.step_in_contact = out.scene.shortest / 400;
    out.scene.moving.push_back({p.lead, one, one});
    return;
  }
  // Constant loads, which often balance each other.
  const double M = exact(draw.chance(0.5) ? p.J1 * size / (T * T * r) * draw.either_way(1) : 0);
  const double F = exact(draw.chance(0.5) ? -M / r : 0), a = F / p.J2 - r * M / p.J1;
  push(out, "lead", false, M);
  push(out, "follow", slides, F);
  p.S = {p.J1 * turn + r * p.J2 * y, p.J1 * rate + r * p.J2 * v, 0.5 * (M + r * F)};
  OneCoordinate one;
  one.x = y - r * turn - p.offset, one.v = v - r * rate;
  if (kind == 1) {
    const double R = slides ? 1 : exact(draw.decades(-2, -0.5)), e = exact(draw.between(0.2, 0.97));
    out.scene.speed = b / T * R;
    const double ks = stop_stiffness(out, reduced, R * R, T * draw.decades(-2, -1.3));
    out.table("joints.belt", "type = \"ratio\"\n" + lines +
                                 toml("backlash = {}\n{}mesh_stiffness = {}\nsurface = 's'\n", b,
                                      slides ? "" : toml("radius = {}\n", R), ks));
    out.surface(e);
    one.acceleration = [a](double, double, double) { return a; };
    out.finish(T * draw.between(10, 60));
    backlash(out, p, one, b, e, ks, R, reduced);
    return;
  }
  const double w = 2 * pi / T, k = exact(reduced * w * w);
  const double d = exact(draw.chance(0.6) ? 2 * draw.decades(-2, -0.5) * reduced * w : 0);
  out.table("loads.belt",
            "type = \"elastic-ratio\"\n" + lines + toml("stiffness = {}\ndamping = {}\n", k, d));
  out.scene.speed = size * w;
  one.acceleration = [=](double, double z, double u) { return a - (k * z + d * u) / reduced; };
  out.finish(T * draw.between(3, 40));
  one.step = one.step_in_contact = out.scene.shortest / 400;
  p.known(out, one, one);
}

void freewheels(Draw& draw, Draft& out) {
  out.given = true;
  const double T = 1 / draw.decades(-2, 3), J = exact(draw.decades(-4, 1)), A = draw.decades(-2, 1);
  const double peak = J * A / (T * T) * 10,
               capacity = exact(peak * (draw.chance(0.6) ? draw.between(2, 5) : draw.between(0.3, 1)));
  // Against the ground, or a drum that turns at constant speed.
  const bool turns = draw.chance(0.5);
  const double w = turns ? exact(A / T * draw.either_way(2)) : 0;
  const std::string other = turns ? "drum" : "ground";
  if (turns) {
    const auto drum = mover(out, "drum", false, J, 0, w, 1);
    out.table("drives.turn", toml("joint = 'on_drum'\nspeed = {}\ninitial_angle = 0\n", w));
    out.steady(drum.coordinate, 0, w, 1);
  }
  const double v = draw.chance(0.4) ? w : exact(w + A / T * draw.either_way(3));
  const double x = exact(draw.angle());
  const auto rotor = mover(out, "rotor", false, J, x, v, 1);
  // The side on which the rotor overruns.
  const bool forward = draw.chance(0.5), first = draw.chance(0.3);
  const int free = forward != first ? 1 : -1;
  const double decay = T * draw.between(0.02, 0.1), slow = exact(decay * capacity / J);
  out.table("loads.clutch", toml("type = 'freewheel'\nbetween = ['{}', '{}']\ntorque_limit = {}\n"
                                 "direction = '{}'\nregularisation = {}\n",
                                 first ? "rotor" : other, first ? other : "rotor", capacity,
                                 forward ? "forward" : "backward", slow));
  const double drag = exact(draw.chance(0.7) ? -free * peak * draw.between(0, 0.5) : 0);
  push(out, "rotor", false, drag);
  const auto effort = shake(draw, out, "rotor", false, T, peak, 110 * T);
  out.scene.speed = A / T;
  out.flight = T;
  DryCoordinate one;
  one.acceleration = [=](int side, double t, double, double) {
    return (effort.at(t) + drag + (side == free ? 0 : free * capacity)) / J;
  };
  one.support = w, one.next_kink = effort.next_kink, one.x = x, one.v = v;
  OneCoordinate linear;
  linear.acceleration = [=](double t, double, double u) {
    return (effort.at(t) + drag + free * capacity * std::clamp(free * (w - u) / slow, 0.0, 1.0)) / J;
  };
  linear.speed_kinks = {w, w - free * slow};
  linear.next_kink = effort.next_kink, linear.x = x, linear.v = v;
  dry(out, rotor.coordinate, one, linear, decay, T * draw.between(3, 40));
}

namespace {

/// Friction F of sliding that rises to `peak` at rest, with exp(−(|u|/fall)ⁿ).
struct Peak {
  double F, peak, fall, n;
};

/// A body that touches the floor in its centre, with a weight and a surface of this friction. Its forces
/// become those of the stated numbers.
Mover on_floor(Draw& draw, Draft& out, double m, double x, double v, double size, Peak& p) {
  const double mu = exact(draw.between(0.05, 1)), g = exact(p.F / (mu * m)),
               most = exact(std::max(mu, p.peak / (m * g)));
  p.F = mu * m * g, p.peak = most * m * g;
  out.gravity({0, -g});
  const auto q = out.body({.name = "body", .mass = m, .inertia = m, .at = {x, 0}, .velocity = {v, 0}});
  out.table("contacts.floor", "type = 'plane'\nbetween = ['ground', 'body']\nsurface = 's'\n");
  out.table("surfaces.s",
            toml("restitution = 0.5\nfriction = {}\nstatic_friction = {}\nstribeck_speed = {}\n", mu, most,
                 p.fall) +
                (p.n == 2 ? "" : toml("stribeck_exponent = {}\n", p.n)));
  out.still(q + 1, 0, size);
  out.still(q + 2, 0, 1);
  return {true, q};
}

/// An oscillator with friction of a static value: on a surface, or in a joint on the ground or a drum.
void dry_oscillator(Draw& draw, Draft& out, bool surface) {
  out.given = true;
  const double T = 1 / draw.decades(-2, 3), m = exact(draw.decades(-2, 1)), A = draw.decades(-3, 0);
  const double own = 2 * pi / T, k = exact(m * own * own);
  double F = exact(k * A * draw.decades(-1.5, -0.3)), peak = exact(F * (1 + draw.decades(-1, 0.5)));
  const double fall = exact(std::max(A * own * draw.decades(-1, 0.3), (peak - F) * T / (10 * m)));
  const double n = draw.chance(0.5) ? 2 : exact(draw.between(1, 3));
  // On a drum that turns at constant speed, or on the ground.
  const bool belt = !surface && draw.chance(0.4), slides = surface || (!belt && draw.chance(0.6));
  const double w = belt ? exact(A * own * draw.decades(-1, 0.3) * draw.sign()) : 0;
  if (belt) {
    const auto drum = mover(out, "drum", false, m, 0, w, 1);
    out.table("drives.turn", toml("joint = 'on_drum'\nspeed = {}\ninitial_angle = 0\n", w));
    out.steady(drum.coordinate, 0, w, 1);
  }
  const double x = exact(A * draw.either_way(1)),
               v = draw.chance(0.4) ? w : exact(w + A * own * draw.either_way(1));
  Peak p{F, peak, fall, n};
  const auto body = surface ? on_floor(draw, out, m, x, v, A, p)
                            : mover(out, "body", slides, m, x, v, A, belt ? "drum" : "ground");
  F = p.F, peak = p.peak;
  const double decay = T * draw.between(0.02, 0.05), slow = exact(decay * peak / m);
  if (surface)
    out.scene.penalty = false;  // a contact without compliance
  else
    out.table("loads.rub", toml("type = 'joint-friction'\njoint = 'on_body'\n{0} = {1}\nstatic_{0} = {2}\n"
                                "stribeck_speed = {3}\nregularisation = {4}\n",
                                slides ? "force" : "torque", F, peak, fall, slow) +
                               (n == 2 ? "" : toml("stribeck_exponent = {}\n", n)));
  const double far = exact(20 * A);
  if (slides)
    out.table("loads.spring", toml("type = 'spring-damper'\nbetween = ['ground', 'body']\n"
                                   "at = [[{}, 0], [0, 0]]\nstiffness = {}\nfree_length = {}\n",
                                   -far, k, far));
  else
    out.table("loads.spring",
              toml("type = 'torsional-spring-damper'\nbetween = ['ground', 'body']\nstiffness = {}\n", k));
  const auto effort = belt && draw.chance(0.7) ? Effort{}
                                               : shake(draw, out, "body", slides, T * draw.decades(-0.3, 0.7),
                                                       k * A * draw.decades(-1, 0), 110 * T);
  out.scene.speed = A * own;
  out.flight = std::min(T, 2 * m * fall / (peak - F));
  // Continued beyond zero speed, for the stages of a step.
  const auto bound = [=](double u) {
    const double s = std::max(u / fall, -0.5);
    return F + (peak - F) * std::exp(-std::copysign(std::pow(std::abs(s), n), s));
  };
  DryCoordinate one;
  one.acceleration = [=](int side, double t, double at, double u) {
    return (effort.at(t) - k * at - side * bound(side * (u - w))) / m;
  };
  one.support = w, one.next_kink = effort.next_kink, one.x = x, one.v = v;
  OneCoordinate linear;
  linear.acceleration = [=](double t, double at, double u) {
    return (effort.at(t) - k * at - std::clamp((u - w) / slow, -1.0, 1.0) * bound(std::abs(u - w))) / m;
  };
  linear.speed_kinks = {w - slow, w, w + slow};
  linear.next_kink = effort.next_kink, linear.x = x, linear.v = v;
  dry(out, body.coordinate, one, linear, decay, T * draw.between(3, 30));
}

}  // namespace

void stribeck(Draw& draw, Draft& out) { dry_oscillator(draw, out, false); }
void gripping(Draw& draw, Draft& out) { dry_oscillator(draw, out, true); }

void mesh_losses(Draw& draw, Draft& out) {
  out.given = true;
  const double T = 1 / draw.decades(-2, 3), A = draw.decades(-1, 1), J1 = exact(draw.decades(-4, 0));
  const bool internal = draw.chance(0.3);
  const double r2 = exact(draw.decades(-2, -0.5)),
               r1 = exact(r2 * (internal ? draw.between(1.5, 4) : draw.decades(-0.5, 0.5)));
  // Of the first gear's angle, the second one's turn, and its reduced inertia.
  const double rho = internal ? r1 / r2 : -r1 / r2;
  const double J2 = exact(J1 / (rho * rho) * draw.decades(-0.5, 0.5)), reduced = rho * rho * J2,
               share = J1 / reduced;
  // Losses where the first gear drives (c₁) and where it is driven (c₂), which leave the acceleration
  // unique: c₂ < 1 + J₁/(ρ² J₂).
  double c1 = 0, c2 = 0;
  std::string lines;
  if (draw.chance(0.3)) {
    const double lead = exact(draw.between(0.1, 0.45)),
                 mu = exact(std::tan(lead) * draw.between(0.05, 1 + 0.5 * std::min(1.0, share)));
    const double angle = std::atan(mu);
    c1 = std::tan(lead + angle) / std::tan(lead) - 1, c2 = 1 - std::tan(lead - angle) / std::tan(lead);
    lines = toml("lead_angle = {}\nmesh_friction = {}\n", lead, mu);
  } else {
    const double forth = exact(draw.between(0.3, 0.98));
    const double back = draw.chance(0.3) ? forth : exact(draw.between(-0.5 * std::min(1.0, share), 0.95));
    c1 = 1 / forth - 1, c2 = 1 - back;
    lines = toml("efficiency = {}\n{}", forth, back == forth ? "" : toml("back_efficiency = {}\n", back));
  }
  const double distance = exact(internal ? r1 - r2 : r1 + r2), x = exact(draw.angle());
  const double J = J1 + reduced, torque = J * A / (T * T) * 10;
  const double v = draw.chance(0.3) ? 0 : exact(A / T * draw.either_way(3));
  const auto one_gear = mover(out, "one", false, J1, x, v, r1);
  const auto q = out.body({.name = "two", .inertia = J2, .at = {distance, 0}, .spin = exact(rho * v)});
  out.table("joints.on_two",
            toml("type = 'revolute'\nbetween = ['ground', 'two']\nat = [[{}, 0], [0, 0]]\n", distance));
  out.still(q, distance, r1);
  out.still(q + 1, 0, r1);
  const double decay = T * draw.between(0.03, 0.1), F = exact(torque / rho * draw.either_way(1));
  const double slow = exact(decay * (torque + std::abs(rho * F)) / J);
  out.table(
      "joints.mesh",
      toml("type = 'gear'\nbetween = ['one', 'two']\npitch_radii = [{}, {}]\n{}{}{}regularisation = {}\n", r1,
           r2, internal ? "internal = true\n" : "", draw.chance(0.5) ? "flank = \"backward\"\n" : "", lines,
           slow));
  push(out, "two", false, F);
  const auto effort = shake(draw, out, "one", false, T, torque, 110 * T);
  out.scene.speed = A / T;
  out.flight = T;
  out.scene.prescribed.push_back(
      {q + 2,
       [rho, x, lead = one_gear.coordinate](double, Coordinates at, Coordinates u) {
         return CurvePoint{rho * (at[lead] - x), rho * u[lead], 0};
       },
       std::abs(rho) * A, 10 * std::abs(rho) * A / T, std::abs(rho) * 20 * A / (T * T)});
  // With the torque M of the mesh on the first gear, J₁ θ̈ = T + (1 + c) M and M = ρ F − ρ² J₂ θ̈, where
  // c = c₁ s against the rotation, −c₂ s along it, and s = 1, or the share of regularised friction.
  const auto accelerated = [=](double side, double s, double t) {
    const double without = share * rho * F - effort.at(t), along = side * without;
    const double M = without / (1 + (along < 0 ? c1 : -c2) * s + share);
    return (rho * F - M) / reduced;
  };
  DryCoordinate one;
  one.acceleration = [=](int side, double t, double, double) { return accelerated(side, 1, t); };
  one.next_kink = effort.next_kink, one.x = x, one.v = v;
  OneCoordinate linear;
  linear.acceleration = [=](double t, double, double u) {
    return accelerated(u < 0 ? -1 : 1, std::min(std::abs(u) / slow, 1.0), t);
  };
  linear.speed_kinks = {-slow, 0, slow};
  linear.next_kink = effort.next_kink, linear.x = x, linear.v = v;
  dry(out, one_gear.coordinate, one, linear, decay, T * draw.between(3, 30));
}

}  // namespace freeplay::verification::random_scenes
