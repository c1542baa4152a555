// Random scenes with joints: bumps on rotors, chains, loops, guides, pulses, films, preloaded
// sliders.
#include <algorithm>
#include <vector>

#include "verification/random_scenes/draft.hpp"

namespace freeplay::verification::random_scenes {
namespace {

/// A bar with its ends at ±half of its length.
struct Bar {
  DraftBody body;
  double half = 1;
  Vec2 front() const { return {half, 0}; }
  Vec2 rear() const { return {-half, 0}; }
};

Bar bar(Draw& draw, const std::string& name, double mass, double length) {
  Bar b;
  b.half = 0.5 * length;
  b.body.name = name;
  b.body.mass = mass;
  b.body.inertia = mass * length * length / 12 * draw.between(0.7, 1.5);
  return b;
}

/// Lines of a revolute joint with clearance.
std::string play(double clearance, double bearing, const std::string& more = "") {
  return toml("clearance = {}\nbearing_radius = {}\nsurface = 's'\n{}", clearance, bearing, more);
}

/// Radius of the contact of a journal in its bearing.
double conformal(double clearance, double bearing) { return bearing * (bearing - clearance) / clearance; }

/// A torque table with one pulse or a few random points, over `width` of its axis.
std::string table(Draw& draw, double greatest, double width, bool against_angle) {
  std::string points;
  if (draw.chance(0.5)) {  // a short pulse
    const double at = draw.between(0.1, 0.8) * width, half = width * draw.decades(-3.5, -1.3);
    points = toml("[{}, 0.0], [{}, {}], [{}, 0.0]", at, at + half,
                  greatest * std::min(0.2 * width / half, 100.0), at + 2 * half);
  } else {
    const int count = draw.whole(2, 6);
    for (int i = 0; i < count; ++i)
      points += toml("{}[{}, {}]", i ? ", " : "", width * (i + 0.8 * draw()) / count,
                     greatest * draw.either_way(1));
  }
  return toml("torque_table = [{}]\nagainst = '{}'\n", points, against_angle ? "angle" : "time");
}

/// Attaches a bar to a point that moves at `velocity`: its journal (or pin) there, off by
/// `eccentricity`.
void hang(Draw& draw, Bar& b, Vec2 point, Vec2 velocity, Vec2 eccentricity, Vec2 slip, double spin) {
  b.body.angle = draw.angle();
  b.body.spin = spin;
  const Vec2 arm = DraftBody::turned(b.rear(), b.body.angle);
  b.body.at = point + eccentricity - arm;
  b.body.velocity = velocity + slip - spin * perp(arm);
}

}  // namespace

void chain(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const bool floating = draw.chance(0.25);
  const int links = draw.whole(1, 6) + floating;
  const double c = s.length * draw.decades(-4, -1.5), bearing = c * draw.decades(0.7, 2),
               g = floating && draw.chance(0.7) ? 0 : s.speed * s.speed / s.length;
  if (g > 0) out.gravity({0, -g});
  // Journals cross their clearance within c over this speed.
  const double slip =
      std::max(draw() * s.speed * std::sqrt(c / s.length), 1e-3 * s.speed * std::sqrt(c / s.length));
  std::vector<Bar> bars;
  int clearance_joint = 0;
  for (int i = 0; i < links; ++i) {
    auto b = bar(draw, toml("b{}", i), s.mass * mass_factor(draw), s.length * draw.between(0.5, 1.5));
    const double spin = draw.chance(0.5) ? draw.either_way(1) * s.speed / s.length : 0;
    if (i == 0 && floating) {
      b.body.spin = spin;
      b.body.angle = draw.angle();
    } else {
      const bool has_play = draw.chance(0.7) || (i + 1 == links && clearance_joint == 0);
      clearance_joint += has_play;
      const Vec2 eccentricity = has_play ? draw.along(c * draw.between(0, 0.95)) : Vec2{0, 0},
                 relative = has_play ? draw.along(slip) : Vec2{0, 0};
      const bool on_ground = i == 0;
      const Vec2 point = on_ground ? Vec2{0, 0} : bars.back().body.world(bars.back().front());
      const Vec2 velocity = on_ground ? Vec2{0, 0} : bars.back().body.velocity_of(bars.back().front());
      hang(draw, b, point, velocity, eccentricity, relative, spin);
      out.joint("revolute", on_ground ? "ground" : bars.back().body.name, b.body.name,
                on_ground ? Vec2{0, 0} : bars.back().front(), b.rear(), has_play ? play(c, bearing) : "");
    }
    out.body(b.body);
    bars.push_back(b);
  }
  if (draw.chance(0.2))
    out.load("torsional-spring-damper",
             toml("between = ['{}', '{}']\nstiffness = {}\ndamping = {}\n",
                  links > 1 ? bars[links - 2].body.name : "ground", bars.back().body.name,
                  bars.back().body.inertia * std::pow(draw.between(0.2, 3) * s.speed / s.length, 2),
                  draw.chance(0.5) ? bars.back().body.inertia * s.speed / s.length * draw() : 0));
  const double pace = std::max({slip, std::sqrt(g * c), 0.1 * s.speed * std::sqrt(c / s.length)});
  out.ends(pace, c / pace, std::min(draw.between(5, 40) * (c / pace), 3 * s.time()));
  out.surface(draw, s.mass, pace, conformal(c, bearing), c * draw.decades(-2.7, -1.5));
}

void loop(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const double r = s.length, coupler = r * draw.between(2.5, 4), omega = s.speed / r * draw.sign();
  const double c = r * draw.decades(-4, -1.7), bearing = c * draw.decades(0.7, 2);
  const bool slider = draw.chance(0.5);
  const double angle = draw.angle();
  auto crank = bar(draw, "crank", s.mass, r), rod = bar(draw, "rod", s.mass * mass_factor(draw), coupler);
  crank.body.angle = angle;
  const Vec2 pin{r * std::cos(angle), r * std::sin(angle)};
  crank.body.at = 0.5 * pin;
  std::vector<bool> clearance_joint(3);
  for (auto&& l : clearance_joint) l = draw.chance(0.4);
  if (std::ranges::none_of(clearance_joint, [](bool l) { return l; })) clearance_joint[2] = true;
  const auto lines = [&](int i) { return clearance_joint[i] ? play(c, bearing) : std::string(); };
  if (draw.chance(0.6)) out.gravity({0, -9.81 * std::min(1.0, s.speed * s.speed / r / 9.81)});
  Vec2 end;
  Bar third;
  if (slider) {
    end = {pin.x() + std::sqrt(coupler * coupler - pin.y() * pin.y()), 0};
    third = bar(draw, "slider", s.mass * mass_factor(draw), 0.5 * r);
    third.body.at = end;
    // a crank-rocker by Grashof: r is the shortest link, and shortest + longest < the others
  } else {
    const double rocker = coupler, base = r * draw.between(2, 3);
    const Vec2 far{base, 0}, d = far - pin;
    const double distance = d.norm(), along = 0.5 * distance,
                 up = std::sqrt(std::max(coupler * coupler - along * along, 0.0));
    end = pin + (along / distance) * d + (up / distance) * perp(d);
    third = bar(draw, "rocker", s.mass * mass_factor(draw), rocker);
    const Vec2 span = end - far;
    third.body.at = 0.5 * (far + end);
    third.body.angle = std::atan2(span.y(), span.x());
  }
  rod.body.angle = std::atan2((end - pin).y(), (end - pin).x());
  rod.body.at = 0.5 * (pin + end);
  out.given = false;
  for (const auto* b : {&crank, &rod, &third}) out.body(b->body);
  out.joint("revolute", "ground", "crank", {0, 0}, crank.rear());
  const auto driven = out.last_joint();
  out.joint("revolute", "crank", "rod", crank.front(), rod.rear(), lines(0));
  if (slider) {
    out.joint("revolute", "rod", "slider", rod.front(), {0, 0}, lines(1));
    out.joint("translational", "ground", "slider", {0, 0}, {0, 0},
              clearance_joint[2]
                  ? toml("clearance = {}\nslider_length = {}\nslider_height = {}\ncorner_radius = {}\n"
                         "surface = 's'\n",
                         c, 0.5 * r, 0.3 * r, 0.02 * r)
                  : "");
  } else {
    out.joint("revolute", "rod", "rocker", rod.front(), third.front(), lines(1));
    out.joint("revolute", "ground", "rocker", {third.body.world(third.rear()).x(), 0}, third.rear(),
              lines(2));
  }
  const double a = s.speed * s.speed / r, T = 2 * std::numbers::pi / std::abs(omega);
  out.flight = std::sqrt(2 * c / a);
  out.duration = std::min(draw.between(5, 40) * out.flight, T);
  if (draw.chance(0.65))
    out.drive(driven, toml("speed = {}\n", omega));
  else if (draw.chance(0.5))
    out.drive(driven, table(draw, s.mass * r * r * omega * omega, 2 * std::numbers::pi * 0.99, true));
  else
    out.drive(driven, table(draw, s.mass * r * r * omega * omega, out.duration, false) +
                          (draw.chance(0.3) ? toml("lag = {}\n", T * draw.decades(-2, -0.5)) : ""));
  out.speed = a * out.flight;
  out.surface(draw, s.mass, out.speed, clearance_joint[2] && slider ? 0.02 * r : conformal(c, bearing),
              c * draw.decades(-2.7, -1.5));
}

void guide(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const double play = s.length * draw.decades(-3.5, -1.7), slope = draw.angle();
  const Vec2 axis{std::cos(slope), std::sin(slope)};
  const double length = s.length, height = s.length * draw.between(0.2, 1);
  auto b = bar(draw, "slider", s.mass, length);
  const double tilt = 0.3 * play / length * draw.either_way(1), across = 0.3 * play * draw.either_way(1);
  b.body.angle = slope + tilt;
  b.body.at = across * perp(axis);
  const double rattle = s.speed * std::sqrt(play / length);
  b.body.velocity = s.speed * draw.either_way(1) * axis + rattle * draw.either_way(1) * perp(axis);
  b.body.spin = draw.either_way(1) * rattle / length;
  if (draw.chance(0.5)) out.gravity(draw.along(s.speed * s.speed / s.length));
  const bool moving = draw.chance(0.3);
  out.body(b.body);
  if (moving) {  // the guide itself is a floating body
    DraftBody frame{"frame", s.mass * mass_factor(draw), 1, {0, 0}, slope, {0, 0}, 0};
    frame.inertia = frame.mass * length * length;
    out.body(frame);
  }
  out.joint("translational", moving ? "frame" : "ground", "slider", {0, 0}, {0, 0},
            toml("axis = {}\n{}clearance = {}\nslider_length = {}\nslider_height = {}\ncorner_radius = {}\n"
                 "surface = 's'\n",
                 moving ? Vec2{1, 0} : axis, moving ? "" : toml("angle = {}\n", slope), play, length, height,
                 0.05 * length));
  if (draw.chance(0.6))
    out.load("force", toml("body = 'slider'\nat = {}\nforce = {}\n",
                           Vec2{draw.either_way(length), draw.either_way(height)},
                           draw.along(s.mass * s.speed * s.speed / s.length * draw())));
  if (draw.chance(0.3))
    out.load("spring-damper",
             toml("between = ['ground', 'slider']\nat = [{}, [0.0, 0.0]]\nstiffness = {}\nfree_length = {}\n",
                  2 * s.length * axis + 0.5 * s.length * perp(axis),
                  s.mass * std::pow(draw.between(0.5, 4) / s.time(), 2), s.length));
  out.ends(rattle, play / rattle, std::min(draw.between(5, 40) * (play / rattle), 5 * s.time()));
  out.surface(draw, s.mass, rattle, 0.05 * length, play * draw.decades(-2.7, -1.5));
}

void bump(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const double arm = s.length, R = arm * draw.decades(-2, -0.5), omega = s.speed / arm * draw.sign();
  DraftBody rotor{"rotor", s.mass, s.mass * arm * arm * draw.between(0.3, 1), {0, 0}, draw.angle(),
                  {0, 0},  omega};
  out.body(rotor);
  out.joint("revolute", "ground", "rotor", {0, 0}, {0, 0});
  const auto shaft = out.last_joint();
  const Vec2 bump_at{arm, 0};
  const double target_R = arm * draw.decades(-1.5, -0.3), sum = R + target_R;
  // Position of the target: the contact with the bump is full or grazing by up to a part in ten
  // million.
  const double off = draw.chance(0.3) ? 1 + draw.sign() * draw.decades(-7, -2) : draw.either_way(0.95);
  const double ahead = rotor.angle + (omega > 0 ? 1 : -1) * draw.between(0.7, 5);
  const double reach = arm + off * sum;
  const Vec2 place{reach * std::cos(ahead), reach * std::sin(ahead)};
  const int against = draw.whole(0, 2);
  if (against == 0) {
    out.discs("ground", "rotor", target_R, R, place, bump_at);
  } else {
    DraftBody target{"target", s.mass * mass_factor(draw), 1, place, 0, {0, 0}, 0};
    target.inertia = 0.5 * target.mass * target_R * target_R;
    const double lever = 3 * target_R;
    if (against == 2) target.inertia = target.mass * lever * lever;
    out.body(target);
    out.discs("rotor", "target", R, target_R, bump_at, {0, 0});
    if (against == 2) {  // a lever on a separate pin, held by a spring
      out.joint("revolute", "ground", "target", place + Vec2{lever, 0}, {lever, 0}, "");
      out.load("torsional-spring-damper",
               toml("between = ['ground', 'target']\nstiffness = {}\ndamping = {}\n",
                    target.mass * lever * lever * omega * omega * draw.between(0.1, 10),
                    draw.chance(0.5) ? target.mass * lever * lever * std::abs(omega) * draw() : 0));
    }
  }
  // A prescribed motion against a fixed body, or in a locked mechanism, has no solution.
  if (against == 1 && draw.chance(0.5)) out.drive(shaft, toml("speed = {}\n", omega));
  out.ends(s.speed, 1 / std::abs(omega), draw.between(3, 30) / std::abs(omega));
  out.surface(draw, s.mass, s.speed, std::min(R, target_R), std::min(R, target_R) * draw.decades(-4, -2.5));
}

void motored(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const double arm = s.length, omega = s.speed / arm * draw.sign(), c = arm * draw.decades(-4, -1.5),
               bearing = c * draw.decades(0.7, 2);
  // At first the rotor turns at half its speed, or is accelerated from it to the full speed.
  DraftBody rotor{"rotor", s.mass,     s.mass * arm * arm * draw.between(0.3, 1), {0, 0}, draw.angle(),
                  {0, 0},  0.5 * omega};
  auto link = bar(draw, "link", s.mass * mass_factor(draw), arm * draw.between(0.5, 1.5));
  const Vec2 at{arm, 0};
  const double pace = s.speed * std::sqrt(c / arm), torque = s.mass * arm * arm * omega * omega;
  hang(draw, link, rotor.world(at), rotor.velocity_of(at), draw.along(0.9 * c * draw()),
       draw.along(pace * draw()), rotor.spin);
  out.body(rotor);
  out.body(link.body);
  out.joint("revolute", "ground", "rotor", {0, 0}, {0, 0});
  const auto shaft = out.last_joint();
  out.joint("revolute", "rotor", "link", at, link.rear(), play(c, bearing));
  out.flight = std::sqrt(c / arm) / std::abs(omega);
  out.duration = std::min(draw.between(5, 40) * out.flight, 20 / std::abs(omega));
  const double fast = std::abs(omega);
  switch (draw.whole(0, 3)) {
    case 0:
      out.table("curves.start",
                toml("shape = 'ramp'\nfrom = {}\nto = {}\nrise = {}\nprofile = '{}'\n", rotor.spin, omega,
                     out.duration * draw.between(0.1, 2), draw.chance(0.5) ? "polynomial" : "cycloidal"));
      out.drive(shaft, toml("velocity = 'start'\ninitial = {}\n", rotor.angle));
      break;
    case 1: {  // stall torque and no-load speed of the rotor's scale
      const double k = torque / fast * draw.decades(-0.5, 0.5);
      out.drive(
          shaft,
          toml("voltage = {}\nresistance = {}\ntorque_constant = {}\n{}", omega * k, k * k / (torque / fast),
               k, draw.chance(0.5) ? toml("inductance = {}\n", k * k / torque * draw.decades(-1, 0)) : ""));
      break;
    }
    case 2:
      out.drive(shaft, toml("breakdown_torque = {}\nbreakdown_slip = {}\nsynchronous_speed = {}\n", torque,
                            draw.between(0.1, 0.8), omega));
      break;
    default:
      out.drive(shaft, toml("target_speed = {}\nproportional = {}\nintegral = {}\n", omega, torque / fast,
                            torque * draw.decades(-1, 0.5)));
  }
  if (draw.chance(0.4)) {
    out.table("curves.swell", toml("shape = 'harmonic'\namplitude = 1.0\nperiod = {}\n",
                                   out.duration * draw.between(0.2, 2)));
    out.load("torque", toml("body = 'link'\ntorque = {}\nfactor = 'swell'\n", torque * draw.either_way(1)));
  }
  out.speed = pace;
  out.surface(draw, s.mass, pace, conformal(c, bearing), c * draw.decades(-2.7, -1.5));
}

void pulse(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const double arm = s.length, omega = s.speed / arm * draw.sign(), c = arm * draw.decades(-4, -1.5),
               bearing = c * draw.decades(0.7, 2);
  DraftBody rotor{"rotor", s.mass, s.mass * arm * arm * draw.between(0.3, 1), {0, 0}, draw.angle(),
                  {0, 0},  omega};
  auto link = bar(draw, "link", s.mass * mass_factor(draw), arm * draw.between(0.5, 1.5));
  const Vec2 at{arm, 0};
  const double pace = s.speed * std::sqrt(c / arm);
  hang(draw, link, rotor.world(at), rotor.velocity_of(at), draw.along(0.9 * c * draw()),
       draw.along(pace * draw()), omega);
  out.body(rotor);
  out.body(link.body);
  out.joint("revolute", "ground", "rotor", {0, 0}, {0, 0});
  const auto shaft = out.last_joint();
  out.joint("revolute", "rotor", "link", at, link.rear(), play(c, bearing));
  out.flight = std::sqrt(c / arm) / std::abs(omega);
  out.duration = std::min(draw.between(5, 40) * out.flight, 20 / std::abs(omega));
  const bool by_angle = draw.chance(0.5);
  out.drive(shaft, table(draw, s.mass * arm * arm * omega * omega,
                         by_angle ? 2 * std::numbers::pi * 0.99 : out.duration, by_angle) +
                       (draw.chance(0.2) ? toml("lag = {}\n", draw.decades(-2, 0) / std::abs(omega)) : ""));
  if (draw.chance(0.4))
    out.load("torque",
             toml("body = 'link'\ntorque = {}\n", s.mass * arm * arm * omega * omega * draw.either_way(1)));
  out.speed = pace;
  out.surface(draw, s.mass, pace, conformal(c, bearing), c * draw.decades(-2.7, -1.5));
}

void film(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const double R = s.length, c = R * draw.decades(-3, -2), width = R * draw.between(0.3, 2),
               omega = s.speed / R * draw.sign();
  DraftBody rotor{"rotor", s.mass, 0.5 * s.mass * R * R, {0, 0}, 0, {0, 0}, omega};
  rotor.at = draw.along(c * draw.between(0, 0.9));
  rotor.velocity = draw.along(c * std::abs(omega) * draw());
  // Weight and film force of one scale: W ~ µ ω R L³/(4c²), and weight ~ m c ω² so that the journal
  // moves within revolutions.
  const double g = c * omega * omega * draw.decades(-1, 1);
  const double viscosity =
      s.mass * g * 4 * c * c / (std::abs(omega) * R * width * width * width) * draw.decades(-1, 1);
  out.gravity({0, -g});
  out.text += toml("[lubricants.oil]\nviscosity = {}\nfilm = '{}'\ncavitation = '{}'\n", viscosity,
                   draw.chance(0.6) ? "short" : "long", draw.chance(0.7) ? "half-sommerfeld" : "none");
  out.body(rotor);
  out.joint("revolute", "ground", "rotor", {0, 0}, {0, 0},
            play(c, R, toml("bearing_length = {}\nlubricant = 'oil'\n", width)));
  out.ends(c * std::abs(omega), 1 / std::abs(omega), draw.between(3, 30) / std::abs(omega));
  out.surface(draw, s.mass, out.speed, conformal(c, R), c * draw.decades(-2.7, -1.5));
}

void preloaded(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  DraftBody b{"slider", s.mass, s.mass * s.length * s.length * 0.1, {0, 0}, 0, {s.speed * draw.sign(), 0}, 0};
  const double slope = draw.angle(), R = 0.2 * s.length, stop = s.length * draw.between(0.3, 3);
  const Vec2 axis{std::cos(slope), std::sin(slope)};
  b.angle = slope;
  b.velocity = b.velocity.x() * axis;
  out.gravity(draw.along(draw.chance(0.6) ? s.speed * s.speed / s.length : 0));
  out.body(b);
  out.joint("translational", "ground", "slider", {0, 0}, {0, 0},
            toml("axis = {}\nangle = {}\n", axis, slope));
  out.load("joint-friction",
           toml("joint = '{}'\nforce = {}\nregularisation = {}\n", out.last_joint(),
                s.mass * s.speed * s.speed / s.length * draw.between(0, 0.6), 1e-3 * s.speed));
  if (draw.chance(0.6))
    out.load("spring-damper",
             toml("between = ['ground', 'slider']\nat = [{}, [0.0, 0.0]]\nstiffness = {}\nfree_length = {}\n",
                  3 * s.length * axis + s.length * perp(axis),
                  s.mass * std::pow(draw.between(0.5, 4) / s.time(), 2), 2 * s.length));
  out.wall("ground", "slider", (stop + R) * axis, perp(axis), R);
  out.wall("ground", "slider", -(draw.between(0.3, 3) * s.length + R) * axis, -perp(axis), R);
  out.ends(s.speed, 0.3 * s.time(), draw.between(3, 15) * s.time());
  out.surface(draw, s.mass, s.speed, R, R * draw.decades(-3.3, -2));
}

}  // namespace freeplay::verification::random_scenes
