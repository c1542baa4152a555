// Two coinciding points, two rows. With arms r_i, r_j (perp rotates by +90°):
//
//     Φ = r_j^P − r_i^P,   Φ̇ = v_j + ω_j perp r_j − v_i − ω_i perp r_i,   γ = ω_j² r_j − ω_i² r_i
#pragma once

#include <array>

#include "dynamics/kinematics.hpp"

namespace freeplay {

struct PointRows {
  Link link;
  int row = 0;
  // Entries of G for the bodies' angles; −1: arm zero.
  std::array<int, 2> theta_i{-1, -1}, theta_j{-1, -1};

  template <class T>
  void place(const T&, const T* q, EvaluationOf<T>& e) const {
    const auto a = arms(link, q, e);
    e.phi[row] = a.d.x();
    e.phi[row + 1] = a.d.y();
    if (theta_i[0] >= 0) {
      e.G[theta_i[0]] = a.ri.y();
      e.G[theta_i[1]] = -a.ri.x();
    }
    if (theta_j[0] >= 0) {
      e.G[theta_j[0]] = -a.rj.y();
      e.G[theta_j[1]] = a.rj.x();
    }
  }
  template <class T>
  void rate(const T*, const T* v, EvaluationOf<T>& e) const {
    const T wi = omega(v, link.i), wj = omega(v, link.j);
    const auto rj = turned(link.j, link.sj, e), ri = turned(link.i, link.si, e);
    e.gamma[row] = wj * wj * rj.x() - wi * wi * ri.x();
    e.gamma[row + 1] = wj * wj * rj.y() - wi * wi * ri.y();
  }
};

}  // namespace freeplay
