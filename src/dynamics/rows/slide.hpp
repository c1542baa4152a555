// No offset across an axis a of body i, one row. With n = perp a, d = r_j^P − r_i^P:
//
//     Φ = n·d,   Φ̇ = n·ḋ − ω_i a·d,   γ = ω_i² n·d + 2 ω_i a·ḋ + n·(ω_j² r_j − ω_i² r_i)
#pragma once

#include "dynamics/kinematics.hpp"

namespace freeplay {

struct SlideRow {
  Link link;
  Vec2 axis{1, 0};
  int row = 0;
  bool x = true, y = true;  // which entries of the second body exist
  int first = 0, last = 0;  // its entries of G

  template <class T>
  void place(const T&, const T* q, EvaluationOf<T>& e) const {
    const auto a = arms(link, q, e);
    const Vec2Of<T> along = turned(link.i, axis, e), n = perp(along);
    e.phi[row] = dot(n, a.d);
    T* g = e.G.data() + first;
    if (link.i != ground) {
      *g++ = -n.x();
      *g++ = -n.y();
      *g++ = -dot(along, a.d) - dot(along, a.ri);
    }
    if (link.j != ground) {
      if (x) *g++ = n.x();
      if (y) *g++ = n.y();
      if (g < e.G.data() + last) *g = dot(along, a.rj);
    }
  }
  template <class T>
  void rate(const T* q, const T* v, EvaluationOf<T>& e) const {
    const auto a = arms(link, q, e);
    const Vec2Of<T> along = turned(link.i, axis, e), n = perp(along);
    const T wi = omega(v, link.i), wj = omega(v, link.j);
    e.gamma[row] = wi * wi * dot(n, a.d) + 2 * wi * dot(along, relative_velocity(link, a, v)) +
                   wj * wj * dot(n, a.rj) - wi * wi * dot(n, a.ri);
  }
};

}  // namespace freeplay
