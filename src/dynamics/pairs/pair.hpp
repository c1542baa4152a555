// Common functions of the kinds of contact pair.
#pragma once

#include "dynamics/evaluation.hpp"
#include "dynamics/gap_motion.hpp"
#include "dynamics/kinematics.hpp"

namespace freeplay {

/// Adds the entries of a body for a unit force along `direction` and the couple `turn` about its
/// centre of mass.
template <class T>
void push(SparseRowOf<T>& row, int body, const Vec2Of<T>& direction, const T& turn) {
  if (body == ground) return;
  row.push(3 * body, direction.x());
  row.push(3 * body + 1, direction.y());
  row.push(3 * body + 2, turn);
}

/// The part of d̈ without accelerations: ω_i² r_i − ω_j² r_j.
template <class T>
Vec2Of<T> centripetal(const Vec2Of<T>& ri, const T& wi, const Vec2Of<T>& rj, const T& wj) {
  return {wi * wi * ri.x() - wj * wj * rj.x(), wi * wi * ri.y() - wj * wj * rj.y()};
}

}  // namespace freeplay
