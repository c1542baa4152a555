// Toothed bodies without backlash. One row: the carrying flank stays closed, Φ = g of
// mesh.hpp,
//
//     Φ̇ = u·ḋ + ρ_i ω_i + ρ_j ω_j
//     γ = −u·(ω_i² r_i − ω_j² r_j) − (other terms of Φ̈ without accelerations)
#pragma once

#include <array>

#include "dynamics/mesh.hpp"

namespace freeplay {

template <class Mesh>
struct MeshRow {
  Link link;
  Mesh mesh;
  int row = 0;
  std::array<int, 2> first{-1, -1};  ///< first of the entries x, y, θ of i and j in G; −1: ground

  template <class T>
  void place(const T&, const T* q, EvaluationOf<T>& e) const {
    const auto a = arms(link, q, e);
    const auto f = mesh.at(link, q, a.d, e);
    e.phi[row] = f.gap;
    const auto put = [&](int begin, const Vec2Of<T>& arm, const Vec2Of<T>& along, const T& turn) {
      if (begin < 0) return;
      e.G[begin] = along.x();
      e.G[begin + 1] = along.y();
      e.G[begin + 2] = cross(arm, along) + turn;
    };
    put(first[0], a.ri, -f.along, f.turn_i);
    put(first[1], a.rj, f.along, f.turn_j);
  }
  template <class T>
  void rate(const T* q, const T* v, EvaluationOf<T>& e) const {
    const auto a = arms(link, q, e);
    const auto f = mesh.at(link, q, a.d, e);
    const T wi = omega(v, link.i), wj = omega(v, link.j);
    const Vec2Of<T> still{wi * wi * a.ri.x() - wj * wj * a.rj.x(), wi * wi * a.ri.y() - wj * wj * a.rj.y()};
    e.gamma[row] =
        -(dot(f.along, still) + mesh.velocity_terms(f, a.d, relative_velocity(link, a, v), wi, wj));
  }
};

}  // namespace freeplay
