// Pieces of a reduced beam (beam_reduction.hpp) on its shape over the chord (beam_chord.hpp). With the share ξ_k of a
// piece in the length, y without the static deflection and its rotation ϑ, the 3n − N rows are
//
//     x_k − ξ_k s = 0,      Cᵀ (y − S_y φ) = 0,      ϑ_k − S_k φ − Ψ_k P (y − S_y φ) = 0.
//
// γ contains minus the terms of their second derivatives without accelerations: with c = d/dt² of a point at the end of
// an arm a, −ω² a, and c_d = c_j − c_i,
//
//     s̈: e·c_d + s β̇²,   β̈: (n·c_d − 2 β̇ ṡ)/s,   ẍ: −e·c_i + β̈ y + 2 β̇ n·ṙ − β̇² x,   ÿ: −n·c_i − β̈ x − 2 β̇ e·ṙ − β̇² y.
#pragma once

#include <vector>

#include "dynamics/beam_chord.hpp"

namespace freeplay {

struct ReducedBeamRows {
  BeamChord beam;
  int row = 0, first = 0;  ///< of the rows, and of their entries in G
  int modes = 0;
  /// Combinations (beam_chord.hpp) of the n − N transverse rows, and of the n rows of rotations but for ϑ_k.
  std::vector<double> weights = {};

  int transverse() const { return beam.pieces - modes; }
  /// ξ_k
  double share(int k) const { return (k + 0.5) / beam.pieces; }

  template <class T>
  void place(const T&, const T* q, EvaluationOf<T>& e) const {
    const auto arm = arms(beam.link, q, e);
    const ChordShape<T> s(beam, q, arm, e);
    T* value = e.G.data() + first;
    int r = row;
    for (int k = 0; k < beam.pieces; ++k, ++r) {
      const double xi = share(k);
      e.phi[r] = s.x[k] - xi * s.length;
      const T turn = s.y[k] / s.length;
      const Vec2Of<T> on_j{turn * s.left.x() - xi * s.along.x(), turn * s.left.y() - xi * s.along.y()};
      value = s.ends(arm, -on_j - s.along, on_j, 0, 0, value);
      *value++ = s.along.x();
      *value++ = s.along.y();
    }
    const double* w = weights.data();
    for (int k = 0; k < transverse(); ++k, ++r, w += beam.weights()) {
      e.phi[r] = s.combination(w);
      value = s.row(arm, w, 0, value);
    }
    for (int k = 0; k < beam.pieces; ++k, ++r, w += beam.weights()) {
      e.phi[r] = s.piece_angle(k, e) + s.combination(w);
      value = s.row(arm, w, 1, value);
      *value++ = 1;
    }
  }

  template <class T>
  void rate(const T* q, const T* v, EvaluationOf<T>& e) const {
    const auto arm = arms(beam.link, q, e);
    const ChordShape<T> s(beam, q, arm, e);
    const ChordRates<T> rates(s, arm, v);
    const auto inwards = [&](int body, const Vec2Of<T>& r) -> Vec2Of<T> {
      const T w = omega(v, body), square = -w * w;
      return {square * r.x(), square * r.y()};
    };
    const auto c_i = inwards(beam.link.i, arm.ri), c_d = inwards(beam.link.j, arm.rj) - c_i;
    const T &spin = rates.spin, square = spin * spin;
    const T length = dot(s.along, c_d) + s.length * square,
            turn = (dot(s.left, c_d) - 2 * spin * rates.stretch) / s.length;
    std::array<T, most_reduced> y;
    int r = row;
    for (int k = 0; k < beam.pieces; ++k, ++r) {
      const auto u = rates.relative(k);
      e.gamma[r] =
          dot(s.along, c_i) - turn * s.y[k] - 2 * spin * dot(s.left, u) + square * s.x[k] + share(k) * length;
      y[k] = -dot(s.left, c_i) - turn * s.x[k] - 2 * spin * dot(s.along, u) - square * s.y[k];
    }
    const double* w = weights.data();
    for (const int rotation : {0, 1})
      for (int k = 0; k < (rotation == 1 ? beam.pieces : transverse()); ++k, ++r, w += beam.weights()) {
        T sum = (rotation + w[0] + w[1]) * turn;
        for (int p = 0; p < beam.pieces; ++p) sum -= w[p + 2] * y[p];
        e.gamma[r] = sum;
      }
  }
};

}  // namespace freeplay
