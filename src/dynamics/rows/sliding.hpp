// Sliding row of joint friction along an axis a of body i: u = a·ḋ, u̇ = a·d̈ + ω_i n·ḋ, n = perp
// a.
#pragma once

#include "dynamics/kinematics.hpp"
#include "numerics/sparse.hpp"

namespace freeplay {

struct SlidingRow {
  Link link;
  Vec2 axis{1, 0};

  /// Fills the row of u = row·v and returns γ in u̇ = row·a − γ.
  template <class T>
  T rows(const T* q, const T* v, const EvaluationOf<T>& e, SparseRowOf<T>& row) const {
    const auto a = arms(link, q, e);
    const Vec2Of<T> along = turned(link.i, axis, e);
    row.clear();
    if (link.i != ground) {
      row.push(3 * link.i, -along.x());
      row.push(3 * link.i + 1, -along.y());
      row.push(3 * link.i + 2, -cross(a.ri, along));
    }
    if (link.j != ground) {
      row.push(3 * link.j, along.x());
      row.push(3 * link.j + 1, along.y());
      row.push(3 * link.j + 2, cross(a.rj, along));
    }
    const T wi = omega(v, link.i), wj = omega(v, link.j);
    return -(wi * dot(perp(along), relative_velocity(link, a, v)) + wi * wi * dot(along, a.ri) -
             wj * wj * dot(along, a.rj));
  }
};

}  // namespace freeplay
