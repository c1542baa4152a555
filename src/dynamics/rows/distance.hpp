// Two points at a fixed distance L > 0. One row, with d = r_j^P − r_i^P, u = ḋ and arms r_i, r_j:
//
//     Φ = (d·d − L²)/(2L),     Φ̇ = d·u/L,     γ = −(u·u + d·(ω_i² r_i − ω_j² r_j))/L
//
// On the constraint d/L has unit length, and the multiplier is the tension (N).
#pragma once

#include <array>

#include "dynamics/kinematics.hpp"

namespace freeplay {

struct DistanceRow {
  Link link;
  double length = 0;  ///< m
  int row = 0;
  std::array<int, 2> first{-1, -1},  ///< first of the entries x, y of i and j in G; −1: ground
      theta{-1, -1};                 ///< their entries θ; −1: ground, or arm zero

  template <class T>
  void place(const T&, const T* q, EvaluationOf<T>& e) const {
    const auto a = arms(link, q, e);
    e.phi[row] = (dot(a.d, a.d) - length * length) / (2 * length);
    const auto put = [&](std::size_t end, const Vec2Of<T>& arm, double sign) {
      if (first[end] < 0) return;
      const Vec2Of<T> along{sign / length * a.d.x(), sign / length * a.d.y()};
      e.G[first[end]] = along.x();
      e.G[first[end] + 1] = along.y();
      if (theta[end] >= 0) e.G[theta[end]] = cross(arm, along);
    };
    put(0, a.ri, -1);
    put(1, a.rj, 1);
  }
  template <class T>
  void rate(const T* q, const T* v, EvaluationOf<T>& e) const {
    const auto a = arms(link, q, e);
    const auto u = relative_velocity(link, a, v);
    const T wi = omega(v, link.i), wj = omega(v, link.j);
    const Vec2Of<T> still{wi * wi * a.ri.x() - wj * wj * a.rj.x(), wi * wi * a.ri.y() - wj * wj * a.rj.y()};
    e.gamma[row] = -(dot(u, u) + dot(a.d, still)) / length;
  }
};

}  // namespace freeplay
