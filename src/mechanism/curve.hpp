// A function y(x) as a scene states it. The element that uses the curve defines x and y. With
// s = (x − start)/rise from 0 to 1:
//
//     constant             y = value
//     ramp                 y = from + (to − from) p(s), constant before and after
//     rise-dwell-return    a ramp, a dwell at `to`, a ramp back, a rest at `from`; may repeat
//     harmonic             y = mean + amplitude sin(2π x/period + phase)
//     table                through points: straight lines, or a cubic spline (y″ continuous)
//
// The profile is p = 10 s³ − 15 s⁴ + 6 s⁵ (3-4-5 polynomial) or s − sin(2πs)/(2π) (cycloidal). Both
// have a continuous second derivative (Norton, Cam Design and Manufacturing Handbook, ch. 3).
//
// Curve holds the facts; lay() makes the Piecewise that is evaluated.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "mechanism/keys.hpp"

namespace freeplay {

class Piecewise;

/// A named function y(x) of one variable.
struct Curve {
  /// Kind of function; it determines which members are read.
  enum class Shape { constant, ramp, rise_dwell_return, harmonic, table };
  /// Profile of rise and return.
  enum class Profile { polynomial, cycloidal };
  /// Interpolation between the points of a table.
  enum class Between { linear, spline };
  /// Use of the curve: as y itself, as the rate of a motion, or as its position, whose slope must
  /// be continuous.
  enum class Use { value, rate, place };
  /// Pairs (x, y).
  using Points = std::vector<std::pair<double, double>>;

  /// of the curve in the scene
  std::string name;
  /// kind of function
  Shape shape = Shape::constant;
  /// y of a constant
  double value = 0;
  /// y before and after the rise
  double from = 0, to = 0;
  double start = 0;                      ///< in units of x, as the lengths below
  double rise = 0;                       ///< > 0
  double dwell = 0, fall = 0, rest = 0;  ///< fall > 0
  /// of rise and return
  Profile profile = Profile::polynomial;
  /// of a harmonic function
  double mean = 0, amplitude = 0;
  double period = 0;   ///< > 0
  double phase = 0;    ///< rad
  Points points = {};  ///< x increasing, at least two
  /// interpolation of a table
  Between between = Between::linear;
  /// whether the function is periodic beyond its last point
  bool repeats = false;

  std::string_view what() const;
  static void keys(auto& k, auto& c) {
    const auto is = [&](Shape shape) { return k.when(c.shape == shape); };
    k.choose({"shape", "", "y(x) is "}, c.shape);
    if (is(Shape::constant)) k.need({"value", "of y", "y everywhere"}, c.value, any_number);
    if (k.when(c.shape == Shape::ramp || c.shape == Shape::rise_dwell_return)) {
      k.take({"from", "of y", "initial y"}, c.from);
      k.need({"to", "of y", "y after the rise"}, c.to, any_number);
      k.take({"start", "of x", "beginning of the rise"}, c.start);
      k.need({"rise", "of x", "length of the rise"}, c.rise, positive);
      k.choose({"profile", "", "of rise and return: "}, c.profile);
    }
    if (is(Shape::rise_dwell_return)) {
      k.take({"dwell", "of x", "length of the dwell at `to`"}, c.dwell, non_negative);
      k.need({"return", "of x", "length of the return"}, c.fall, positive);
      k.take({"rest", "of x", "length of the final dwell at `from`, before the curve repeats"}, c.rest,
             non_negative);
    }
    if (is(Shape::harmonic)) {
      k.take({"mean", "of y", "y in the middle"}, c.mean);
      k.need({"amplitude", "of y", "amplitude"}, c.amplitude, any_number);
      k.either(
          {"frequency", "Hz", "of a curve against time; or period"}, positive, [](double f) { return 1 / f; },
          {"period", "of x", "length of one oscillation"}, positive, c.period);
      k.take({"phase", "rad", "of the sine at x = 0"}, c.phase);
    }
    if (is(Shape::table)) {
      k.samples({"points", "x and y", "[[x, y], ...], x increasing; or file"},
                {"file", "", "CSV file with a header and the points, in the scene's folder or below"},
                {"columns", "", "names of its columns for x and y"}, c.points);
      k.choose({"between", "", "between the points: "}, c.between);
    }
    if (k.when(c.shape == Shape::table || c.shape == Shape::rise_dwell_return))
      k.take({"repeat", "", "periodic; otherwise constant before the first point and after the last"},
             c.repeats);
  }

  /// The function; does not throw. A spline has zero slope at its ends if `use` is place, else zero
  /// curvature.
  Piecewise lay(Use use = Use::value) const;
  /// The reason why the curve cannot be used so, or "". y must be continuous, and the slope of a
  /// position as well.
  std::string refusal(Use use) const;
};

inline constexpr auto curve_shapes = complete<Curve::Shape>(
    {{Curve::Shape::constant, "constant"},
     {Curve::Shape::ramp, "ramp", "a smooth rise by its profile; a straight line is a table of two points"},
     {Curve::Shape::rise_dwell_return, "rise-dwell-return"},
     {Curve::Shape::harmonic, "harmonic"},
     {Curve::Shape::table, "table"}});
inline constexpr auto curve_profiles = complete<Curve::Profile>(
    {{Curve::Profile::polynomial, "polynomial", "3-4-5"}, {Curve::Profile::cycloidal, "cycloidal"}});
inline constexpr auto curve_betweens = complete<Curve::Between>(
    {{Curve::Between::linear, "linear", "straight lines"},
     {Curve::Between::spline, "spline",
      "cubic, second derivative continuous; at ends that do not repeat, zero slope of a position, else "
      "zero second derivative"}});
constexpr std::span<const Choice<Curve::Shape>> choices(Curve::Shape) { return curve_shapes; }
constexpr std::span<const Choice<Curve::Profile>> choices(Curve::Profile) { return curve_profiles; }
constexpr std::span<const Choice<Curve::Between>> choices(Curve::Between) { return curve_betweens; }

inline std::string_view Curve::what() const {
  switch (shape) {
    case Shape::constant:
      return "a constant curve";
    case Shape::ramp:
      return "a ramp";
    case Shape::rise_dwell_return:
      return "a rise, dwell and return";
    case Shape::harmonic:
      return "a harmonic curve";
    case Shape::table:
      return "a table";
  }
  return "a curve";
}

/// A constant, or the value of a named curve.
struct CurveOr {
  /// value if there is no curve
  double constant = 0;
  int curve = -1;  ///< index into Mechanism::curves; −1: use the constant

  /// The value as a piecewise function.
  Piecewise lay(const std::vector<Curve>& curves, Curve::Use use = Curve::Use::value) const;
};

}  // namespace freeplay
