// Sliding row of joint friction along an axis a of body i: u = a·ḋ, u̇ = a·d̈ + ω_i n·ḋ, n = perp
// a.
#pragma once

#include "dynamics/pairs.hpp"

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
    push(row, link.i, Vec2Of<T>(-along), T(-cross(a.ri, along)));
    push(row, link.j, along, T(cross(a.rj, along)));
    const T wi = omega(v, link.i), wj = omega(v, link.j);
    return -(wi * dot(perp(along), relative_velocity(link, a, v)) + wi * wi * dot(along, a.ri) -
             wj * wj * dot(along, a.rj));
  }
};

}  // namespace freeplay
