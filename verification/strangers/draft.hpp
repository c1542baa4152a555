// What strangers are drawn with: numbers from a seed, and a scene as TOML that grows element by element.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>

#include "values/vec2.hpp"

namespace freeplay::verification::strangers {

/// Numbers that a seed and an index alone decide. The standard leaves its distributions open, so these are its own.
class Draw {
 public:
  Draw(std::uint64_t seed, std::uint64_t index) : engine_(seed + 0x9e3779b97f4a7c15u * (index + 1)) {
    engine_.discard(8);
  }
  /// Uniform in [0, 1).
  double operator()() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * (*this)(); }
  /// 10 to a uniform power.
  double decades(double low, double high) { return std::pow(10, between(low, high)); }
  double either_way(double size) { return between(-size, size); }
  double sign() { return (*this)() < 0.5 ? -1 : 1; }
  double angle() { return between(-std::numbers::pi, std::numbers::pi); }
  /// From low to high, both included.
  int whole(int low, int high) { return low + static_cast<int>((*this)() * (high - low + 1)); }
  bool chance(double share) { return (*this)() < share; }
  /// Of any direction.
  Vec2 along(double length) {
    const double a = angle();
    return {length * std::cos(a), length * std::sin(a)};
  }

 private:
  std::mt19937_64 engine_;
};

/// A body as it is drawn: what stands in its table.
struct DraftBody {
  std::string name;
  double mass = 1, inertia = 1;
  Vec2 at{0, 0};
  double angle = 0;
  Vec2 velocity{0, 0};
  double spin = 0;

  /// A point of its frame in the world, and back.
  Vec2 world(Vec2 s) const { return at + turned(s, angle); }
  Vec2 velocity_of(Vec2 s) const { return velocity + spin * perp(turned(s, angle)); }
  static Vec2 turned(Vec2 s, double a) {
    return {std::cos(a) * s.x() - std::sin(a) * s.y(), std::sin(a) * s.x() + std::cos(a) * s.y()};
  }
};

/// Sizes that a scene is drawn around: length (m), speed (m/s), mass (kg).
struct Sizes {
  double length = 1, speed = 1, mass = 1;
  double time() const { return length / speed; }
};

/// A scene in TOML. Numbers have 12 digits: what the last bits of a machine's sines are does not stand in them.
class Draft {
 public:
  std::string text;
  /// s, of a short free flight: time steps are shares of it.
  double flight = 1;
  double duration = 1;  ///< s
  double fastest = 0;   ///< rad/s, of springs: a step is a small part of their swing
  bool given = true;    ///< positions and velocities as they stand; else made consistent
  double speed = 1;     ///< m/s, what friction is regularised by

  void gravity(Vec2 g) { text = fmt::format("gravity = {}\n", point(g)) + text; }
  void body(const DraftBody& b) {
    table("bodies", b.name);
    text += fmt::format(
        "mass = {}\ninertia = {}\nposition = {}\nangle = {}\nvelocity = {}\nangular_velocity = {}\n",
        number(b.mass), number(b.inertia), point(b.at), number(b.angle), point(b.velocity), number(b.spin));
  }
  /// Between "ground" or bodies, at a point of each; `more`: further lines.
  void joint(const char* type, const std::string& i, const std::string& j, Vec2 si, Vec2 sj,
             const std::string& more = "") {
    table("joints", fmt::format("j{}", joints_++));
    text += fmt::format("type = \"{}\"\nbetween = [\"{}\", \"{}\"]\nat = [{}, {}]\n{}", type, i, j, point(si),
                        point(sj), more);
  }
  void curve(const std::string& name, const std::string& lines) {
    table("curves", name);
    text += lines;
  }
  std::string last_joint() const { return fmt::format("j{}", joints_ - 1); }
  /// A wall through `at` of `i`, free space on the left of `axis`, against a disc of `j`.
  void wall(const std::string& i, const std::string& j, Vec2 at, Vec2 axis, double radius,
            Vec2 centre = {0, 0}) {
    table("contacts", fmt::format("c{}", contacts_++));
    text += fmt::format(
        "type = \"plane\"\nbetween = [\"{}\", \"{}\"]\nat = [{}, {}]\naxis = {}\nradius = {}\nsurface = \"s\"\n",
        i, j, point(at), point(centre), point(axis), number(radius));
  }
  void discs(const std::string& i, const std::string& j, double Ri, double Rj, Vec2 ci = {0, 0},
             Vec2 cj = {0, 0}) {
    table("contacts", fmt::format("c{}", contacts_++));
    text += fmt::format(
        "type = \"discs\"\nbetween = [\"{}\", \"{}\"]\nat = [{}, {}]\nradii = [{}, {}]\nsurface = \"s\"\n", i,
        j, point(ci), point(cj), number(Ri), number(Rj));
  }
  /// An end stop of the last joint.
  void stop(const char* type, const std::string& lines) {
    table("contacts", fmt::format("c{}", contacts_++));
    text += fmt::format("type = \"{}\"\njoint = \"{}\"\n{}", type, last_joint(), lines);
  }
  void load(const char* type, const std::string& lines) {
    table("loads", fmt::format("l{}", loads_++));
    text += fmt::format("type = \"{}\"\n{}", type, lines);
  }
  void drive(const std::string& joint, const std::string& lines) {
    table("drives", fmt::format("d{}", drives_++));
    text += fmt::format("joint = \"{}\"\n{}", joint, lines);
  }
  /// The one surface of a scene. Its modulus is such that a mass m (kg) at a speed v (m/s) goes `depth` (m) deep into
  /// a contact of radius R (m): 5/4 m v² = K depth^(5/2), K = (4/3) E* √R.
  void surface(Draw& draw, double m, double v, double R, double depth, bool smooth = false);
  /// Whether the surface that was drawn is elastic and without friction.
  bool elastic() const { return elastic_; }
  void run(Draw& draw);

  static std::string number(double x) { return fmt::format("{:.12g}", x); }
  static std::string point(Vec2 p) { return fmt::format("[{}, {}]", number(p.x()), number(p.y())); }

 private:
  void table(const char* kind, const std::string& name) { text += fmt::format("[{}.{}]\n", kind, name); }
  int joints_ = 0, contacts_ = 0, loads_ = 0, drives_ = 0;
  bool elastic_ = false;
};

/// Sizes over the decades: millimetres to ten metres, five decades of speed, grams to a hundred kilograms.
Sizes sizes(Draw& draw);
/// A factor for a mass: mostly mild, now and then up to a thousand either way, so ratios reach 1e6.
double mass_factor(Draw& draw);

/// @name The kinds, each the text of one scene
///@{
void thrown(Draw& draw, Draft& out);   ///< bodies past or against discs and walls, grazing among them
void cluster(Draw& draw, Draft& out);  ///< free discs against each other, nothing else in the world
void box(Draw& draw, Draft& out);      ///< discs between four walls
void pile(Draw& draw, Draft& out);     ///< discs that fall into a box
void sliding(Draw& draw, Draft& out);  ///< starts that touch: rolling, sliding, resting on feet
void springs(Draw& draw, Draft& out);  ///< masses on springs and dampers between stops
void bump(Draw& draw, Draft& out);     ///< a spinning rotor's bump against pegs, levers, free discs
void chain(Draw& draw, Draft& out);    ///< one to six links, pinned or floating, joints loose
void loop(Draw& draw, Draft& out);     ///< closed chains, driven, one to three joints loose
void guide(Draw& draw, Draft& out);    ///< sliders loose in guides
void pulse(Draw& draw, Draft& out);    ///< rotors under pulses and tables, a loose link hung on
void motored(Draw& draw,
             Draft& out);  ///< rotors by motors, governors and prescribed starts, a loose link hung on
void film(Draw& draw, Draft& out);  ///< lubricated journals
void toothed(
    Draw& draw,
    Draft& out);  ///< gears outside and inside each other and racks, loose, now and then on loose bearings
void stopped(Draw& draw, Draft& out);    ///< levers, sliders and pins in slots between end stops
void preloaded(Draw& draw, Draft& out);  ///< sliders with friction of fixed bound that run against stops
void compliant(Draw& draw, Draft& out);  ///< masses on springs that are no straight lines, and on bushings
void cams(Draw& draw, Draft& out);       ///< cams, driven or free, under faces and rollers
///@}

}  // namespace freeplay::verification::strangers
