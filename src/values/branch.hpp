// Branches of periodic motions over one key of a scene, and their bifurcations.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "values/enumerators.hpp"
#include "values/orbit.hpp"

namespace freeplay {

/// fold: a multiplier 1, the branch turns back; flip: −1, the period doubles;
/// torus: a complex pair of modulus 1; grazing: the approach speed of an impact
/// comes to 0, or a contact is just missed; liftoff: the force of a lasting
/// contact comes to 0; sequence: the order of contact onsets changes; crossing:
/// a multiplier 1, branches cross; event: an expression of the request comes to
/// 0. Curves over two keys follow those before `sequence`.
enum class BifurcationKind { fold, flip, torus, grazing, liftoff, sequence, crossing, event };
/// Names in bifurcations.csv.
inline constexpr std::array<const char*, enumerators<BifurcationKind>()> bifurcation_names{
    "fold", "flip", "torus", "grazing", "liftoff", "sequence", "crossing", "event"};

/// One periodic motion of a branch.
struct BranchPoint {
  int branch = 1;        ///< number of the branch, from 1
  int number = 0;        ///< within the branch, from 0
  double parameter = 0;  ///< SI, value of the key
  Orbit orbit;           ///< the motion, with its multipliers
};

/// A bifurcation on a branch.
struct Bifurcation {
  BifurcationKind kind = BifurcationKind::fold;  ///< as above
  BranchPoint at;                                ///< the motion at the bifurcation
  std::string joint;                             ///< contact of a grazing, lift-off or sequence
  std::string follows;                           ///< what follows, in words; of an event its expression
  int new_branch = 0;                            ///< number of the branch that begins there; 0: none
  double residual = NAN;                         ///< of the condition that defines it
};

/// BranchEnd::reason at either end of the range.
inline constexpr const char* branch_range_ends = "the range of the key ends";

/// End of a branch.
struct BranchEnd {
  int branch = 1;      ///< number of the branch
  int points = 0;      ///< number of its motions, also of an earlier result
  std::string begins;  ///< "start", or the bifurcation at which it begins
  std::string reason;  ///< why it ends
};

/// A bifurcation on a curve over two keys.
struct CurvePoint {
  int curve = 1;                                 ///< number of the curve, from 1
  BifurcationKind kind = BifurcationKind::fold;  ///< the same along a curve; not sequence
  double parameter = 0, second = 0;              ///< SI, values of both keys
  Orbit orbit;            ///< the motion; at a grazing impact or lift-off a motion beside it
  std::string joint;      ///< contact of a grazing or lift-off
  double residual = NAN;  ///< of the condition; at a grazing or lift-off estimated error of the parameter
};

/// Ends of a curve.
struct CurveEnds {
  int curve = 1;                                 ///< number of the curve
  BifurcationKind kind = BifurcationKind::fold;  ///< of all its points
  int points = 0;                                ///< their number
  double parameter = 0;                          ///< SI, value of the first key at which it begins
  std::string reasons[2];                        ///< why it ends: the first point, the last point
};

/// All branches of a continuation, or the reason why it could not begin.
struct Branches {
  std::vector<BranchPoint> points;        ///< of all branches, in their order
  std::vector<Bifurcation> bifurcations;  ///< in the order of their location
  std::vector<BranchEnd> ends;            ///< one for each branch
  std::vector<CurvePoint> curve_points;   ///< of all curves over two keys, along each curve
  std::vector<CurveEnds> curves;          ///< one for each curve
  std::string failure;                    ///< why there is no first motion; empty if there is one
};

}  // namespace freeplay
