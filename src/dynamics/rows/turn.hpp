// Row of the friction of a pair of gears: the rotation of wheel i, of radius R, against the line of
// centres. With d from its centre to that of wheel j and t = perp d/|d|², the line turns at t·ḋ,
//
//     u = R (ω_i − t·ḋ),     u̇ = R (α_i − t·d̈) + 2 R (d·ḋ)(t·ḋ)/|d|²
//
// A force f along the row is the couple R f on wheel i and its reaction by forces R f/|d| on both
// centres, across the line.
#pragma once

#include "dynamics/pairs.hpp"

namespace freeplay {

struct TurnRow {
  Link link;
  double radius = 0;  ///< m, R

  /// Fills the row of u = row·v and returns γ in u̇ = row·a − γ.
  template <class T>
  T rows(const T* q, const T* v, const EvaluationOf<T>& e, SparseRowOf<T>& row) const {
    const auto a = arms(link, q, e);
    const T square = dot(a.d, a.d);
    const Vec2Of<T> across{-radius * a.d.y() / square, radius * a.d.x() / square};
    row.clear();
    push(row, link.i, across, T(cross(a.ri, across) + radius));
    push(row, link.j, Vec2Of<T>(-across), T(-cross(a.rj, across)));
    const Vec2Of<T> rate = relative_velocity(link, a, v);
    const Vec2Of<T> still = centripetal(a.ri, omega(v, link.i), a.rj, omega(v, link.j));
    return dot(across, still) - 2 * dot(a.d, rate) * dot(across, rate) / square;
  }
};

}  // namespace freeplay
