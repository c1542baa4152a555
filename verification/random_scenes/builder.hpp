// What random scenes are built with: a scene as TOML and what is known of it, from the same numbers. Every number goes
// through its 12 digits of the text first, so that both have the same.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "verification/random_scenes/random_scenes.hpp"
#include "verification/strangers/draft.hpp"

namespace freeplay::verification::random_scenes {

using reference::CurvePoint;
using reference::CurveShape;
using strangers::Draw;

inline std::string text_of(double x) { return fmt::format("{:.12g}", x); }
/// A number as its text has it.
inline double exact(double x) { return std::strtod(text_of(x).c_str(), nullptr); }

/// A curve in TOML, and the same for references.
struct DrawnCurve {
  std::string lines;
  CurveShape shape;
  double period = 1;                     ///< of x: the shortest length over which it goes up and down
  double size = 0, slope = 0, bend = 0;  ///< greatest |y − y(0)|, |y′|, |y″|, sampled

  void sample(double until);
};

struct CurveWish {
  double period = 1, size = 1;  ///< of x, of y
  bool place = false;           ///< its slope may not jump
  bool closed = false;          ///< the integral over its length vanishes, and it begins and ends at zero
};
DrawnCurve draw_curve(Draw& draw, const CurveWish& wish);

/// s(t) of a drive: a place along a curve, or the integral of a rate.
class DrivenMotion {
 public:
  DrivenMotion(DrawnCurve curve, bool rate, double initial, double until);
  CurvePoint at(double t) const;
  /// The first kink of the curve behind t.
  double next_kink(double t) const;
  double size = 0, rate = 0, bend = 0;  ///< greatest departure from the start, rate and second derivative
  double period = 1;

 private:
  DrawnCurve curve_;
  bool integrated_;
  double initial_, grid_ = 1;
  std::vector<double> sums_ = {};
  std::vector<double> kinks_ = {};
};

class Builder {
 public:
  Builder(Draw& draw, RandomScene& scene) : draw(draw), scene(scene) {}
  Draw& draw;
  RandomScene& scene;
  std::string text;
  bool given = false;         ///< positions and velocities as they stand; else assembled
  double flight = INFINITY;   ///< s, the shortest time between events
  double contact = INFINITY;  ///< s, the shortest time of a compliant contact
  double longest = 800;       ///< of these, that a run takes at most

  struct BodyWish {
    double mass = 1, inertia = 1, x = 0, y = 0, angle = 0, vx = 0, vy = 0, spin = 0;
  };
  /// Returns its first coordinate.
  std::size_t body(const std::string& name, const BodyWish& b);
  void gravity(double down) { text = fmt::format("gravity = [0, {}]\n", text_of(-down)) + text; }
  void table(const std::string& name, const std::string& lines) { text += "[" + name + "]\n" + lines; }
  /// A motion of a joint by a place or a rate; `vertical`: the joint's axis. Adds drive and curve.
  std::shared_ptr<DrivenMotion> driven(const std::string& joint, const DrawnCurve& curve, bool rate,
                                       double initial, double until);
  /// A coordinate that does not move from `at`.
  void still(std::size_t coordinate, double at, double size);
  void prescribed(std::size_t coordinate, std::shared_ptr<DrivenMotion> motion, double offset = 0);
  /// A surface with restitution e; the modulus so that a mass m at speed v of radius R takes `time` in contact. Returns
  /// K of Hertz, N/m^(3/2).
  double surface(double e, double m, double v, double R, double time);
  /// Ends the scene: [run], and steps from the times that were noted.
  void finish(double duration);

 private:
  int curves_ = 0, bodies_ = 0, drives_ = 0;
};

/// Modified Hertz: radius R of two discs.
inline double radius_of(double a, double b) { return a * b / (a + b); }

/// @name Kinds
///@{
void moved_table(Builder& b);    ///< balls on a table that a curve moves
void moved_stop(Builder& b);     ///< a slider on a spring between stops of a moved slide
void moved_lever(Builder& b);    ///< an arm between angle stops of a moved rotor
void follower(Builder& b);       ///< a place that follows a rotor's angle, which turns as it may or as driven
void pushed(Builder& b);         ///< sliders and rotors under forces against time, position, angle and speed
void barrier(Builder& b);        ///< forces against place without net work
void two_scales(Builder& b);     ///< a slow drive beside a fast oscillator on a stop
void one_way(Builder& b);        ///< one-way springs and bump stops
void teeth(Builder& b);          ///< a wheel between the flanks of one that a curve moves
void moved_journal(Builder& b);  ///< a journal in a bearing that a curve moves
void touching_column(Builder& b);  ///< discs on each other, falling on a floor
void touching_row(Builder& b);     ///< discs or blocks in a row, met by one
void touching_grid(Builder& b);    ///< discs in a grid, met by one
///@}

}  // namespace freeplay::verification::random_scenes
