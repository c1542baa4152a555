// Building blocks of random scenes: numbers from a seed, and a scene as TOML that is extended
// element by element together with the reference of its motion; and the kinds of scenes.
#pragma once

#include <fmt/format.h>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "values/vec2.hpp"
#include "verification/random_scenes/numbers.hpp"
#include "verification/random_scenes/scene.hpp"
#include "verification/references/curve_shapes.hpp"

namespace freeplay::verification::random_scenes {

// Random curves: as TOML, as the same shape for references, and the motion that a drive derives
// from them.

using reference::CurvePoint;
using reference::CurveShape;

/// A curve in TOML, and the same curve for references.
struct DrawnCurve {
  std::string lines;
  CurveShape shape;
  double period = 1;  ///< of x: the shortest length of a rise and fall
};

struct CurveWish {
  double period = 1, size = 1;  ///< of x, of y
  bool place = false;           ///< its slope must be continuous
};
DrawnCurve draw_curve(Draw& draw, const CurveWish& wish);

/// s(t) of a drive: a position along a curve, or the integral of a rate.
class DrivenMotion {
 public:
  DrivenMotion(DrawnCurve curve, bool rate, double initial, double until);
  CurvePoint at(double t) const;
  /// The first kink of the curve after t.
  double next_kink(double t) const;
  /// greatest departure from the start, rate and second derivative
  double size = 0, rate = 0, bend = 0;
  double period = 1;

 private:
  DrawnCurve curve_;
  bool integrated_;
  double initial_, grid_ = 1;
  std::vector<double> sums_ = {};
  std::vector<double> kinks_ = {};
};

/// A body of a draft: the content of its table.
struct DraftBody {
  std::string name;
  double mass = 1, inertia = 1;
  Vec2 at{0, 0};
  double angle = 0;
  Vec2 velocity{0, 0};
  double spin = 0;

  /// A point of its frame in the world frame, and the inverse.
  Vec2 world(Vec2 s) const { return at + turned(s, angle); }
  Vec2 velocity_of(Vec2 s) const { return velocity + spin * perp(turned(s, angle)); }
  static Vec2 turned(Vec2 s, double a) {
    return {std::cos(a) * s.x() - std::sin(a) * s.y(), std::sin(a) * s.x() + std::cos(a) * s.y()};
  }
};

/// Scales of a random scene: length (m), speed (m/s), mass (kg).
struct Sizes {
  double length = 1, speed = 1, mass = 1;
  double time() const { return length / speed; }
};
/// Scales over decades: millimetres to ten metres, five decades of speed, grams to a hundred
/// kilograms.
Sizes sizes(Draw& draw);
/// A factor of a mass: mostly moderate, sometimes up to a thousand in either direction, so ratios
/// reach 1e6.
double mass_factor(Draw& draw);

/// A scene in TOML. Numbers have 12 digits, so that the last bits of a machine's sines do not
/// matter.
class Draft {
 public:
  explicit Draft(RandomScene& scene) : scene(scene) {}
  RandomScene& scene;  ///< the reference of the motion, and the times of the scene
  std::string text;
  bool given = true;  ///< positions and velocities as given; else the start determines velocities
  /// An assembled start changes the stated positions and velocities as little as possible.
  bool approximate = false;
  double flight = INFINITY;   ///< s, of a short free flight, or the shortest time between events
  double duration = 1;        ///< s
  double fastest = 0;         ///< rad/s, of springs: a step is a small part of their period
  double speed = 1;           ///< m/s, regularising speed of friction
  double contact = INFINITY;  ///< s, the shortest time of a compliant contact
  double longest = 800;       ///< of these, the greatest duration of a run

  static std::string number(double x) { return text_of(x); }
  static std::string point(Vec2 p) { return fmt::format("[{}, {}]", number(p.x()), number(p.y())); }

  /// @name Elements
  ///@{
  void table(const std::string& name, const std::string& lines) { text += "[" + name + "]\n" + lines; }
  void gravity(Vec2 g) { text = fmt::format("gravity = {}\n", point(g)) + text; }
  /// Returns its first coordinate.
  std::size_t body(const DraftBody& b);
  /// Between "ground" or bodies, at a point of each; `more`: further lines.
  void joint(const char* type, const std::string& i, const std::string& j, Vec2 si, Vec2 sj,
             const std::string& more = "") {
    table(fmt::format("joints.j{}", joints_++),
          fmt::format("type = \"{}\"\nbetween = [\"{}\", \"{}\"]\nat = [{}, {}]\n{}", type, i, j, point(si),
                      point(sj), more));
  }
  std::string last_joint() const { return fmt::format("j{}", joints_ - 1); }
  /// A wall through `at` of `i`, free space on the left of `axis`, against a disc of `j`.
  void wall(const std::string& i, const std::string& j, Vec2 at, Vec2 axis, double radius,
            Vec2 centre = {0, 0}) {
    add("contacts.c", contacts_,
        fmt::format("type = \"plane\"\nbetween = [\"{}\", \"{}\"]\nat = [{}, {}]\naxis = {}\nradius = {}\n"
                    "surface = \"s\"\n",
                    i, j, point(at), point(centre), point(axis), number(radius)));
  }
  void discs(const std::string& i, const std::string& j, double Ri, double Rj, Vec2 ci = {0, 0},
             Vec2 cj = {0, 0}) {
    add("contacts.c", contacts_,
        fmt::format("type = \"discs\"\nbetween = [\"{}\", \"{}\"]\nat = [{}, {}]\nradii = [{}, {}]\n"
                    "surface = \"s\"\n",
                    i, j, point(ci), point(cj), number(Ri), number(Rj)));
  }
  /// An end stop of the last joint.
  void stop(const char* type, const std::string& lines) {
    add("contacts.c", contacts_, fmt::format("type = \"{}\"\njoint = \"{}\"\n{}", type, last_joint(), lines));
  }
  void load(const char* type, const std::string& lines) {
    add("loads.l", loads_, fmt::format("type = \"{}\"\n{}", type, lines));
  }
  void drive(const std::string& joint, const std::string& lines) {
    add("drives.d", drives_, fmt::format("joint = \"{}\"\n{}", joint, lines));
  }
  /// The one surface of a scene, with a modulus such that a mass m (kg) at a speed v (m/s) goes
  /// `depth` (m) deep into a contact of radius R (m), and a drawn restitution and friction.
  void surface(Draw& draw, double m, double v, double R, double depth, bool smooth = false);
  /// The same with restitution e, and a contact duration of `time` (s). Returns K of Hertz,
  /// N/m^(3/2).
  double surface(double e, double m, double v, double R, double time);
  /// The same for stops, which have a separate stiffness.
  void surface(double e);
  ///@}

  /// @name Reference of the motion
  ///@{
  /// Prescribes the motion of a joint by a position or a rate. Adds drive and curve.
  std::shared_ptr<DrivenMotion> driven(const std::string& joint, const DrawnCurve& curve, bool rate,
                                       double initial, double until);
  /// A coordinate at rest at `at`.
  void still(std::size_t coordinate, double at, double size) { steady(coordinate, at, 0, size); }
  /// A coordinate with constant velocity.
  void steady(std::size_t coordinate, double at, double rate, double size);
  void prescribed(std::size_t coordinate, std::shared_ptr<DrivenMotion> motion);
  ///@}

  /// @name Ends of a scene
  ///@{
  /// The speed of its contacts (m/s), a short free flight and its duration (s).
  void ends(double contact_speed, double free_flight, double lasts) {
    speed = contact_speed, flight = free_flight, duration = lasts;
  }
  /// For checks that need no reference: [run], steps, and speeds that friction is regularised by.
  void run(Draw& draw);
  /// For scenes with a reference for every row: [run], and steps from the recorded times.
  void finish(double until);
  ///@}

 private:
  void add(const char* prefix, int& count, const std::string& lines) {
    table(fmt::format("{}{}", prefix, count++), lines);
  }
  int bodies_ = 0, joints_ = 0, contacts_ = 0, loads_ = 0, drives_ = 0, curves_ = 0;
};

// References of coordinates between walls, by references/one_coordinate.hpp.

/// Stiffness (N/m) of a stop at which an inertia on an arm of that square stays in contact for
/// `time`, which is recorded.
double stop_stiffness(Draft& out, double inertia, double arm_squared, double time);
/// Adds the reference of a coordinate between walls for both formulations: stiffness over inertia
/// and exponent of the compliant ones. An angle moves contacts on an arm.
void moving(Draft& out, std::size_t coordinate, reference::OneCoordinate one, double stiffness,
            double exponent, double arm = 1);
/// Ends the scene, whose times set the steps of the references.
void finish_moving(Draft& out, double duration);

// The kinds of random scenes: each draws one scene.

/// @name Without a reference: free bodies (free.cpp)
///@{
/// Bodies past or against discs and walls, grazing among them.
void thrown(Draw& draw, Draft& out);
/// Free discs against each other, nothing else in the world.
void cluster(Draw& draw, Draft& out);
/// Discs between four walls.
void box(Draw& draw, Draft& out);
/// Discs that fall into a box.
void pile(Draw& draw, Draft& out);
/// Starts in contact: rolling, sliding, resting on feet.
void sliding(Draw& draw, Draft& out);
/// Masses on springs and dampers between stops.
void springs(Draw& draw, Draft& out);
///@}
/// @name Without a reference: jointed bodies (jointed.cpp)
///@{
/// Contacts of a spinning rotor's bump with pegs, levers and free discs.
void bump(Draw& draw, Draft& out);
/// One to six links, pinned or floating, joints with clearance.
void chain(Draw& draw, Draft& out);
/// Closed chains, driven, clearance in one to three joints.
void loop(Draw& draw, Draft& out);
/// Sliders with clearance in guides.
void guide(Draw& draw, Draft& out);
/// Rotors under pulses and tables, with a link attached by a joint with clearance.
void pulse(Draw& draw, Draft& out);
/// Rotors with motors, governors and prescribed starts, with a link attached by a joint with
/// clearance.
void motored(Draw& draw, Draft& out);
/// Lubricated journals.
void film(Draw& draw, Draft& out);
/// Sliders with friction of fixed bound that reach stops.
void preloaded(Draw& draw, Draft& out);
///@}
/// @name Without a reference: teeth and end stops (toothed.cpp)
///@{
/// External and internal gears and racks, sometimes on bearings with clearance.
void toothed(Draw& draw, Draft& out);
/// Levers, sliders and pins in slots between end stops.
void stopped(Draw& draw, Draft& out);
///@}
/// @name Without a reference: springs and cams (compliant.cpp)
///@{
/// Masses on nonlinear springs, and on bushings.
void compliant(Draw& draw, Draft& out);
/// Cams, driven or free, under faces and rollers.
void cams(Draw& draw, Draft& out);
///@}
/// @name Without a reference: beams (flexible.cpp)
///@{
/// Chains of bodies and beams in flight, hit by discs.
void flying_beams(Draw& draw, Draft& out);
/// The same on the ground, against walls, pegs and discs.
void cantilevers(Draw& draw, Draft& out);
/// Four-bars and slider-cranks with a beam as coupler, and sometimes as crank and rocker.
void beam_loops(Draw& draw, Draft& out);
/// Trees whose beams have sections along the length, free ends and damping by a ratio.
void sectioned_beams(Draw& draw, Draft& out);
/// Trees and loops with beams reduced to some of their modes.
void reduced_beams(Draw& draw, Draft& out);
///@}
/// @name With a reference for every row: bodies on curves (moved.cpp)
///@{
/// Balls on a table on a curve.
void moved_table(Draw& draw, Draft& out);
/// A slider on a spring between stops of a slide on a curve.
void moved_stop(Draw& draw, Draft& out);
/// An arm between angle stops of a rotor on a curve.
void moved_lever(Draw& draw, Draft& out);
/// A wheel between the flanks of one on a curve.
void teeth(Draw& draw, Draft& out);
/// A journal in a bearing on a curve.
void moved_journal(Draw& draw, Draft& out);
/// A position prescribed over the angle of a rotor, free or driven.
void follower(Draw& draw, Draft& out);
/// A slow drive beside a fast oscillator on a stop.
void two_scales(Draw& draw, Draft& out);
///@}
/// @name With a reference for every row: forces (pushed.cpp)
///@{
/// Sliders and rotors under forces against time, position, angle and speed.
void pushed(Draw& draw, Draft& out);
/// Forces over position without net work.
void barrier(Draw& draw, Draft& out);
/// One-sided springs and bump stops.
void one_way(Draw& draw, Draft& out);
///@}
/// @name With a reference for every row: single elements (coupled.cpp, shaped.cpp, profiled.cpp)
///@{
/// Two joints in a ratio: ideal, with backlash, elastic.
void ratio_trains(Draw& draw, Draft& out);
/// A rotor on a freewheel, against the ground or a turning drum.
void freewheels(Draw& draw, Draft& out);
/// Oscillators with friction of fixed bound and a static peak.
void stribeck(Draw& draw, Draft& out);
/// Oscillators on a surface with a static value of friction.
void gripping(Draw& draw, Draft& out);
/// Two gears with losses.
void mesh_losses(Draw& draw, Draft& out);
/// A disc against an outline, at rest or turning.
void outlines(Draw& draw, Draft& out);
/// A rotor or slider under a sampled controller.
void sampled_loops(Draw& draw, Draft& out);
/// Balls whose restitution depends on the approach speed, on a floor or a moved table.
void yielding(Draw& draw, Draft& out);
/// A journal and a bearing of which one or both are not round (profiled.cpp): bounces, sliding and rolling, rest
/// on both sides of a pocket.
void profiled_journals(Draw& draw, Draft& out);
///@}
/// @name With a reference for every row: touching bodies (touching.cpp)
///@{
/// Discs on each other, falling on a floor.
void touching_column(Draw& draw, Draft& out);
/// Discs or blocks in a row, hit by one.
void touching_row(Draw& draw, Draft& out);
/// Discs in a grid, hit by one.
void touching_grid(Draw& draw, Draft& out);
///@}

}  // namespace freeplay::verification::random_scenes
