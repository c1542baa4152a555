// Toothed bodies without play, one row: the flank that carries stays closed, Φ = g of mesh/involute.hpp or mesh/rack.hpp,
//
//     Φ̇ = u·ḋ + ρ_i ω_i + ρ_j ω_j,     γ = −u·(ω_i² r_i − ω_j² r_j) − (what else of Φ̈ no acceleration makes)
#pragma once

#include "model/mesh/involute.hpp"
#include "model/mesh/rack.hpp"

namespace freeplay {

template <class Mesh>
struct MeshRow {
  Link link;
  Mesh mesh;
  int row = 0;
  int first = 0;  ///< its first entry of G: x, y, θ of each body that moves

  template <class T>
  void place(const T&, const T* q, EvaluationOf<T>& e) const {
    const auto a = arms(link, q, e);
    const auto f = mesh.at(link, q, a.d, e);
    e.phi[row] = f.gap;
    T* g = e.G.data() + first;
    const auto put = [&](int body, const Vec2Of<T>& arm, const Vec2Of<T>& along, const T& turn) {
      if (body == ground) return;
      *g++ = along.x();
      *g++ = along.y();
      *g++ = cross(arm, along) + turn;
    };
    put(link.i, a.ri, -f.along, f.turn_i);
    put(link.j, a.rj, f.along, f.turn_j);
  }
  template <class T>
  void rate(const T* q, const T* v, EvaluationOf<T>& e) const {
    const auto a = arms(link, q, e);
    const auto f = mesh.at(link, q, a.d, e);
    const T wi = omega(v, link.i), wj = omega(v, link.j);
    const Vec2Of<T> still{wi * wi * a.ri.x() - wj * wj * a.rj.x(), wi * wi * a.ri.y() - wj * wj * a.rj.y()};
    e.gamma[row] = -(dot(f.along, still) + mesh.bend(f, a.d, relative_velocity(link, a, v), wi, wj));
  }
};

}  // namespace freeplay
