// A tooth flank as a contact, with gap and direction from mesh/involute.hpp or mesh/rack.hpp,
//
//     ġ = u·ḋ + ρ_i ω_i + ρ_j ω_j
//
// Teeth have no friction: their sliding depends on which pair of teeth carries, which no state
// stores.
#pragma once

#include "dynamics/mesh/involute.hpp"
#include "dynamics/mesh/rack.hpp"
#include "dynamics/pairs/pair.hpp"

namespace freeplay {

template <class Mesh>
struct FlankPair {
  Link link;
  Mesh mesh;

  double gap(const double* q, const Vec2& d, const Evaluation& e) const { return mesh.at(link, q, d, e).gap; }
  GapMotion motion(const MotionBounds& bounds, const Vec2& d) const { return mesh.motion(link, bounds, d); }
  /// Zero: overlapping flanks stay so over half a tooth pitch.
  double passage(const double*, double) const { return 0; }

  template <class T>
  void rows(const Arms<T>& a, const T* q, const T* v, const EvaluationOf<T>& e, ContactRowOf<T>& row) const {
    const int i = link.i, j = link.j;
    const T wi = omega(v, i), wj = omega(v, j);
    const auto f = mesh.at(link, q, a.d, e);
    const Vec2Of<T> rate = relative_velocity(link, a, v), back = -f.along;
    row.gap = f.gap;
    row.gamma_n = -(dot(f.along, centripetal(a.ri, wi, a.rj, wj)) + mesh.bend(f, a.d, rate, wi, wj));
    push(row.normal, i, back, T(cross(a.ri, back) + f.turn_i));
    push(row.normal, j, f.along, T(cross(a.rj, f.along) + f.turn_j));
  }
};

}  // namespace freeplay
