// Random curves: as TOML, as the same shape for references, and the motion that a drive derives
// from them.
#pragma once

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "verification/random_scenes/numbers.hpp"
#include "verification/references/curve_shapes.hpp"

namespace freeplay::verification::random_scenes {

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

}  // namespace freeplay::verification::random_scenes
