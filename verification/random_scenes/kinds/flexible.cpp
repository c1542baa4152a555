// Random mechanisms with one to three beams: trees in flight and on the ground, four-bars and slider-cranks.
//
// A beam of length L, wave speed c and slenderness λ has bending frequencies of about 3c/(λL): speeds are a small
// part of c/λ, so that beams bend by a small part of a radian. A run lasts 150 radians of the highest
// frequency, and gaps are a share of the distance that bodies move in that time.
//
// The kinds of the selection "beams" also draw sections along the length, free ends, damping by a ratio and reduced
// beams. Their parts follow the others, which keep their numbers.
#include <algorithm>
#include <vector>

#include "verification/random_scenes/draft.hpp"

namespace freeplay::verification::random_scenes {
namespace {

/// A size of a section, which grows with this power of its lengths.
struct Size {
  const char* key;
  double value;
  int power;
};

struct Rod {
  std::string name, lines, shape;
  std::vector<Size> sizes;
  double length = 1, height = 1, mass = 1, axial = 1, bending = 1, curvature = 0;
  int elements = 1;
  /// Angle from a tangent to the chord, and the length of the chord.
  double half() const { return 0.5 * curvature * length; }
  double chord() const { return curvature == 0 ? length : length * std::sin(half()) / half(); }
};

class Stage {
 public:
  Stage(Draw& d, Draft& o) : draw(d), out(o) {
    speed = std::sqrt(young / density) / slender * draw.decades(-2.5, -0.6);
  }
  Draw& draw;
  Draft& out;
  double length = draw.decades(-2, 0), young = draw.decades(6, 11.3), density = draw.decades(2.7, 4),
         slender = draw.decades(1.3, 2.3), speed = 1;

  Rod rod(double of, bool straight) {
    Rod r;
    r.name = toml("rod{}", rods_++);
    r.length = of, r.elements = draw.whole(1, 8);
    r.height = of / std::clamp(slender * draw.between(0.8, 1.25), 20.0, 200.0);
    const double h = r.height, w = h * draw.decades(-0.3, 0.7), wall = h * draw.between(0.05, 0.4),
                 pi = std::numbers::pi;
    double area = w * h, moment = area * h * h / 12;
    switch (draw.whole(0, 3)) {
      case 0:
        r.shape = "rectangle", r.sizes = {{"width", w, 1}, {"height", h, 1}};
        break;
      case 1:
        r.shape = "circle", r.sizes = {{"diameter", h, 1}};
        area = pi / 4 * h * h, moment = area * h * h / 16;
        break;
      case 2:
        r.shape = "tube", r.sizes = {{"diameter", h, 1}, {"wall", wall, 1}};
        area = pi * wall * (h - wall), moment = pi / 64 * (std::pow(h, 4) - std::pow(h - 2 * wall, 4));
        break;
      default:
        r.sizes = {{"area", area, 2}, {"second_moment", moment, 4}};
    }
    r.mass = density * area * of, r.axial = young * area, r.bending = young * moment;
    if (!straight && draw.chance(0.3)) r.curvature = draw.either_way(1) / of;
    if (draw.chance(0.4)) r.lines += toml("shear_modulus = {}\n", young / 2.6);
    if (r.curvature != 0) r.lines += toml("curvature = {}\n", r.curvature);
    // Of the wave's time through an element.
    if (draw.chance(0.4))
      r.lines += toml("damping = {}\n", of / r.elements * std::sqrt(density / young) * draw.decades(-2, 0));
    return r;
  }

  /// A rod with one or more of the keys that the first kinds do not have.
  Rod further_rod(double of, bool reduced) {
    Rod r = rod(of, reduced);
    if (reduced) r.lines += toml("modes = {}\n", draw.whole(0, r.elements / 2));
    if (!reduced && draw.chance(0.6)) {  // thinner along the length: at the ends of pieces or within
      std::string rows;
      double from = 0, share = 1;
      for (int left = draw.whole(2, 3); left > 0; --left, share *= draw.between(0.75, 1)) {
        rows += (from == 0 ? "[" : ", [") + text_of(from);
        for (const auto& size : r.sizes) rows += ", " + text_of(size.value * std::pow(share, size.power));
        rows += "]";
        from = draw.chance(0.5) && r.elements > 1
                   ? std::floor(from * r.elements + draw.whole(1, 3) + 1e-6) / r.elements
                   : from + (1 - from) * draw.between(0.1, 0.8);
        if (from >= 1) break;
      }
      r.sizes.clear();
      r.lines += "sections = [" + rows + "]\n";
      thinner = true;
    }
    if (r.lines.find("damping") == std::string::npos && draw.chance(0.6)) {
      const double wave = std::sqrt(density / young), hertz = 0.1 / (of * wave);
      r.lines += toml("damping_ratio = {}\ndamping_frequency = {}\n",
                      std::numbers::pi * hertz * of / r.elements * wave * draw.decades(-2, 0), hertz);
    }
    return r;
  }

  DraftBody body(const std::string& name, const Rod& r, Vec2 at, double angle) {
    DraftBody b{name, r.mass * draw.decades(-0.5, 0.7), 1, at, angle, {0, 0}, 0};
    b.inertia = b.mass * std::pow(r.length * draw.between(0.1, 0.3), 2);
    return b;
  }

  /// A rod between two bodies (nullptr: the ground), at a point and an angle of each.
  /// Its second end is free if `j` is a nullptr.
  void connect(const Rod& r, const DraftBody* i, const DraftBody* j, Vec2 si, Vec2 sj, double ai, double aj) {
    auto section = r.shape.empty() ? "" : toml("section = '{}'\n", r.shape);
    for (const auto& size : r.sizes) section += toml("{} = {}\n", size.key, size.value);
    out.table("beams." + r.name,
              toml("between = ['{}', '{}']\nat = [{}, {}]\nangles = {}\nlength = {}\nelements = {}\n"
                   "young = {}\ndensity = {}\n",
                   i ? i->name : "ground", j ? j->name : "free", si, sj, Vec2{ai, aj}, r.length, r.elements,
                   young, density) +
                  section + r.lines);
    // Each half element by itself: the trace of M⁻¹K bounds the squares of its frequencies.
    const double l = r.length / r.elements, m = r.mass / r.elements, J = m * l * l / 12,
                 along = 2 * r.axial / l, across = 96 * r.bending / (l * l * l), turn = 8 * r.bending / l;
    fastest = std::max(fastest, std::sqrt(4 * r.axial / (l * m)));
    for (const auto& [b, s] : {std::pair{i, si}, {j, sj}}) {
      const double soft = b ? 1 / b->mass + dot(s, s) / b->inertia : 0, spin = b ? 1 / b->inertia : 0;
      fastest = std::max(fastest, std::sqrt((along + across) * (soft + 1 / m) + turn * (spin + 1 / J)));
    }
  }

  /// s, of a run; m, a distance that bodies with the scene's speed move in a share of it.
  double time() const { return std::min(150 / fastest, 4 * length / speed); }
  double gap() { return speed * time() * draw.between(0.03, 0.3); }

  /// A disc, wall or peg that a body of radius R (m) meets; `moving`: a free disc only.
  void opponent(const std::string& name, Vec2 at, Vec2 velocity, double R, double mass, bool moving) {
    const double far = gap(), own = R * draw.decades(-0.3, 0.7), pace = velocity.norm();
    const int type = moving || pace < 0.1 * speed ? 0 : draw.whole(0, 2);
    const Vec2 n = type == 0 ? draw.along(1) : (1 / pace) * velocity;
    flight = std::min(flight, far / (2 * speed)), radius = std::min({radius, R, own}),
    gaps = std::min(gaps, far);
    if (type == 1) return out.wall("ground", name, at + (R + far) * n, perp(n), R);
    const Vec2 centre = at + (R + own + far) * n;
    if (type == 2) return out.discs("ground", name, own, R, centre);
    DraftBody disc{toml("disc{}", discs_++), mass * mass_factor(draw), 1, centre, 0, {0, 0}, 0};
    disc.inertia = 0.5 * disc.mass * own * own;
    disc.velocity = velocity - speed * draw.between(0.5, 1.5) * n;
    disc.spin = draw.chance(0.5) ? draw.either_way(1) * speed / own : 0;
    out.body(disc);
    out.discs(name, disc.name, R, own);
  }

  /// Lines of a revolute joint with clearance.
  std::string play(double c) {
    const double bearing = c * draw.decades(0.7, 2);
    flight = std::min(flight, c / speed), radius = std::min(radius, bearing * (bearing - c) / c);
    gaps = std::min(gaps, c);
    return toml("clearance = {}\nbearing_radius = {}\nsurface = 's'\n", c, bearing);
  }

  void end(double contact_speed, double mass) {
    // Neighbouring sections may raise it by the root of 2/(1 + 0.75⁴).
    if (thinner) fastest *= 1.25;
    out.fastest = fastest;
    const double shortest = std::isfinite(flight) ? flight : 0.1 * time();
    out.ends(contact_speed, shortest, time());
    if (std::isfinite(gaps)) out.surface(draw, mass, contact_speed, radius, gaps * draw.decades(-2.7, -1.5));
  }

  double fastest = 0, flight = INFINITY, radius = INFINITY, gaps = INFINITY;
  bool thinner = false;  ///< some rods have sections along the length

 private:
  int rods_ = 0, discs_ = 0;
};

/// The middle of piece n (from 1) of a rod from a place in a direction.
Vec2 middle(const Rod& r, Vec2 place, double direction, Vec2 end, int n) {
  const double x = (n - 0.5) / r.elements, turn = direction + 2 * r.half();
  return (1 - x * x * (3 - 2 * x)) * place + x * x * (3 - 2 * x) * end +
         r.length * x * (1 - x) *
             ((1 - x) * Vec2{std::cos(direction), std::sin(direction)} -
              x * Vec2{std::cos(turn), std::sin(turn)});
}

/// The same of a rod with a free end, on its unloaded arc.
Vec2 middle_of_arc(const Rod& r, Vec2 place, double direction, int n) {
  const double s = r.length * (n - 0.5) / r.elements, half = 0.5 * r.curvature * s,
               chord = half == 0 ? s : s * std::sin(half) / half;
  return place + chord * Vec2{std::cos(direction + half), std::sin(direction + half)};
}

/// Beams of the first kinds, with sections along the length and free ends, or reduced.
enum class Beams { first, sectioned, reduced };

/// A chain of bodies and rods, the first rod on the ground or on a body in flight.
void tree(Draw& draw, Draft& out, bool flies, Beams beams = Beams::first) {
  Stage stage(draw, out);
  const int count = draw.whole(1, 3);
  const double L = stage.length, v = stage.speed, spin = flies ? draw.either_way(1) * v / L : 0;
  const Vec2 drift = flies ? draw.along(v * draw()) : Vec2{0, 0};
  if (draw.chance(0.4)) out.gravity(draw.along(draw() * v * v / L));
  const auto move = [&](DraftBody& b) {
    b.velocity = drift + spin * perp(b.at) + draw.along(0.5 * v * draw());
    b.spin = spin + draw.either_way(0.5) * v / L;
    out.body(b);
  };
  std::vector<DraftBody> bodies;
  struct Grown {
    Rod rod;
    Vec2 place, end;
    double direction;
  };
  std::vector<Grown> grown;
  for (int n = 0; n < count; ++n) {
    const double of = L * draw.between(0.5, 1);
    const auto r =
        beams == Beams::first ? stage.rod(of, false) : stage.further_rod(of, beams == Beams::reduced);
    if (bodies.empty() && flies) move(bodies.emplace_back(stage.body("b", r, {0, 0}, draw.angle())));
    const auto* from = bodies.empty() ? nullptr : &bodies.back();
    const Vec2 si = from ? draw.along(0.1 * L * draw()) : Vec2{0, 0}, sj = draw.along(0.1 * L * draw());
    const double ai = draw.angle(), direction = ai + (from ? from->angle : 0), chord = direction + r.half();
    const Vec2 place = from ? from->world(si) : si,
               end = place + r.chord() * Vec2{std::cos(chord), std::sin(chord)};
    if (beams == Beams::sectioned && from && n == count - 1 && draw.chance(0.6)) {
      stage.connect(r, from, nullptr, si, {0, 0}, ai, 0);
      stage.opponent(toml("{}-{}", r.name, r.elements), middle_of_arc(r, place, direction, r.elements),
                     from->velocity, 0.5 * r.height, r.mass, true);
      break;
    }
    auto b = stage.body(toml("b{}", n), r, {0, 0}, draw.angle());
    b.at = end - DraftBody::turned(sj, b.angle);
    move(b);
    stage.connect(r, from, &b, si, sj, ai, direction + 2 * r.half() - b.angle);
    grown.push_back({r, place, end, direction});
    bodies.push_back(b);
  }
  const auto& last = bodies.back();
  if (grown.empty()) return stage.end(v, last.mass);  // one rod with a free end
  const auto& tip = grown.back();
  if (draw.chance(0.6)) stage.opponent(last.name, last.at, last.velocity, 0.1 * L, last.mass, flies);
  if (draw.chance(0.5)) {
    const int n = draw.whole(1, tip.rod.elements);
    stage.opponent(toml("{}-{}", tip.rod.name, n), middle(tip.rod, tip.place, tip.direction, tip.end, n),
                   last.velocity, 0.5 * tip.rod.height, tip.rod.mass, true);
  }
  if (draw.chance(0.4)) {  // a pendulum on the last body
    const bool loose = draw.chance(0.7);
    const double c = stage.gap(), half = 0.3 * L;
    auto b = stage.body("arm", tip.rod, {0, 0}, draw.angle());
    const Vec2 on = draw.along(0.1 * L), arm = DraftBody::turned({-half, 0}, b.angle);
    b.at = last.world(on) + (loose ? draw.along(c * draw.between(0, 0.9)) : Vec2{0, 0}) - arm;
    b.spin = last.spin + draw.either_way(1) * v / L;
    b.velocity = last.velocity_of(on) - b.spin * perp(arm) + (loose ? draw.along(v * draw()) : Vec2{0, 0});
    out.body(b);
    out.joint("revolute", last.name, "arm", on, {-half, 0}, loose ? stage.play(c) : "");
  }
  stage.end(v, last.mass);
}

/// A four-bar or slider-crank with a beam as coupler.
void loop_of(Draw& draw, Draft& out, bool reduced) {
  Stage stage(draw, out);
  const auto coupler = reduced ? stage.further_rod(stage.length, true) : stage.rod(stage.length, false);
  const double d = coupler.chord(), r = d * draw.between(0.25, 0.4), v = stage.speed,
               omega = v / r * draw.sign(), angle = draw.angle();
  const Vec2 pin{r * std::cos(angle), r * std::sin(angle)}, foot{r * draw.between(2, 3), 0};
  const bool slides = draw.chance(0.5), soft_crank = draw.chance(0.3),
             soft_rocker = !slides && draw.chance(0.4);
  Vec2 end{pin.x() + std::sqrt(d * d - pin.y() * pin.y()), 0};
  if (!slides) {  // a crank-rocker by Grashof, whose rocker is as long as the coupler
    const Vec2 span = foot - pin;
    const double base = span.norm();
    end = pin + 0.5 * span + (std::sqrt(d * d - 0.25 * base * base) / base) * perp(span);
  }
  out.given = false;
  const auto direction = [](Vec2 a) { return std::atan2(a.y(), a.x()); };
  /// A link between two points: rigid, or two bodies and a rod. Returns the bodies at its ends.
  const auto link = [&](const std::string& name, Vec2 a, Vec2 b, bool soft) {
    struct Ends {
      std::string first, second;
      Vec2 at, other;
    };
    if (!soft) {
      auto one = stage.body(name, coupler, 0.5 * (a + b), direction(b - a));
      out.body(one);
      const double half = 0.5 * (b - a).norm();
      return Ends{name, name, {-half, 0}, {half, 0}};
    }
    const auto rod = stage.rod((b - a).norm(), true);
    const auto one = stage.body(name, rod, a, direction(b - a)),
               two = stage.body(name + "_tip", rod, b, one.angle);
    out.body(one), out.body(two);
    stage.connect(rod, &one, &two, {0, 0}, {0, 0}, 0, 0);
    return Ends{one.name, two.name, {0, 0}, {0, 0}};
  };
  const auto crank = link("crank", {0, 0}, pin, soft_crank);
  const double chord = direction(end - pin);
  const auto eye = stage.body("eye", coupler, pin, chord - coupler.half()),
             head = stage.body("head", coupler, end, chord + coupler.half());
  out.body(eye), out.body(head);
  stage.connect(coupler, &eye, &head, {0, 0}, {0, 0}, 0, 0);
  // Journals start in the centres of their bearings and cross clearances by the accelerations of the mechanism.
  const double a = v * v / r, share = 0.3 * stage.time();
  const auto lines = [&] {
    return draw.chance(0.5) ? stage.play(0.5 * a * std::pow(share * draw.between(0.1, 1), 2)) : "";
  };
  out.joint("revolute", "ground", crank.first, {0, 0}, crank.at);
  const auto driven = out.last_joint();
  out.joint("revolute", crank.second, "eye", crank.other, {0, 0}, lines());
  if (slides) {
    out.body(stage.body("slider", coupler, end, 0));
    out.joint("revolute", "head", "slider", {0, 0}, {0, 0}, lines());
    out.joint("translational", "ground", "slider", {0, 0}, {0, 0});
  } else {
    const auto rocker = link("rocker", foot, end, soft_rocker);
    out.joint("revolute", "head", rocker.second, {0, 0}, rocker.other, lines());
    out.joint("revolute", "ground", rocker.first, foot, rocker.at, lines());
  }
  if (draw.chance(0.4)) out.gravity(draw.along(draw() * a));
  if (draw.chance(0.7))
    out.drive(driven, toml("speed = {}\n", omega));
  else
    out.drive(driven, toml("torque = {}\n", coupler.mass * v * v * draw.sign()));
  stage.flight = std::isfinite(stage.gaps) ? std::sqrt(2 * stage.gaps / a) : INFINITY;
  stage.end(std::isfinite(stage.gaps) ? std::sqrt(2 * stage.gaps * a) : v, coupler.mass);
}

}  // namespace

void flying_beams(Draw& draw, Draft& out) { tree(draw, out, true); }
void cantilevers(Draw& draw, Draft& out) { tree(draw, out, false); }
void beam_loops(Draw& draw, Draft& out) { loop_of(draw, out, false); }
void sectioned_beams(Draw& draw, Draft& out) { tree(draw, out, draw.chance(0.5), Beams::sectioned); }
void reduced_beams(Draw& draw, Draft& out) {
  if (draw.chance(0.4)) return loop_of(draw, out, true);
  tree(draw, out, draw.chance(0.5), Beams::reduced);
}

}  // namespace freeplay::verification::random_scenes
