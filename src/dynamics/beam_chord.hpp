// Displacements of the pieces of a beam over its chord, for reduced beams (beam_reduction.hpp). With the ends P_i, P_j,
// d = P_j − P_i of length s and direction e, n = perp e, and r = p − P_i from the first end to a piece,
//
//     x = e·r,   y = n·r,   φ = ψ − β,      β̇ = n·ḋ/s,   ṡ = e·ḋ,   ẋ = e·ṙ + β̇ y,   ẏ = n·ṙ − β̇ x,
//
// β being the angle of d and ψ the angles of tangents at the ends and of the pieces. A combination
// w_i φ_i + w_j φ_j + Σ w_k y_k has the weights w in this order.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "dynamics/kinematics.hpp"
#include "mechanism/beam.hpp"

namespace freeplay {

struct BeamChord {
  Link link;                      ///< the bodies at the ends and the ends on them
  std::array<Vec2, 2> tangent{};  ///< in the frames of these bodies
  int first = 0, pieces = 0;      ///< bodies

  BeamChord() = default;
  explicit BeamChord(const Beam& beam)
      : link{beam.between[0], beam.between[1], beam.at[0], beam.at[1]},
        tangent{Vec2{std::cos(beam.angles.x()), std::sin(beam.angles.x())},
                Vec2{std::cos(beam.angles.y()), std::sin(beam.angles.y())}},
        first(beam.first),
        pieces(beam.elements) {}

  std::size_t weights() const { return static_cast<std::size_t>(pieces) + 2; }
};

/// A beam at one state.
template <class T>
struct ChordShape {
  /// From the ends and the tangents there.
  ChordShape(const BeamChord& b, const T* q, const Vec2Of<T>& from, const Vec2Of<T>& d, const Vec2Of<T>& ti,
             const Vec2Of<T>& tj)
      : beam(b) {
    using std::sqrt;
    length = sqrt(dot(d, d));
    along = {d.x() / length, d.y() / length};
    left = perp(along);
    phi_i = over_chord(ti), phi_j = over_chord(tj);
    for (int k = 0; k < b.pieces; ++k) {
      const int c = 3 * (b.first + k);
      const Vec2Of<T> r{q[c] - from.x(), q[c + 1] - from.y()};
      x[k] = dot(along, r), y[k] = dot(left, r);
    }
  }
  ChordShape(const BeamChord& b, const T* q, const Arms<T>& arm, const EvaluationOf<T>& e)
      : ChordShape(b, q, end(b, q, arm), arm.d, turned(b.link.i, b.tangent[0], e),
                   turned(b.link.j, b.tangent[1], e)) {}

  /// Angle of a tangent relative to the chord.
  T over_chord(const Vec2Of<T>& t) const {
    using std::atan2;
    return atan2(cross(along, t), dot(along, t));
  }
  T piece_angle(int k, const EvaluationOf<T>& e) const {
    return over_chord({e.cosine[beam.first + k], e.sine[beam.first + k]});
  }
  T combination(const double* w) const {
    T sum = w[0] * phi_i + w[1] * phi_j;
    for (int k = 0; k < beam.pieces; ++k) sum += w[k + 2] * y[k];
    return sum;
  }
  /// Row of its rate, plus `turn` times −β̇: entries of the bodies at the ends, and x, y of each piece. Returns the end
  /// of the values.
  T* row(const Arms<T>& arm, const double* w, double turn, T* value) const {
    T spin = -w[0] - w[1] - turn;
    double sum = 0;
    for (int k = 0; k < beam.pieces; ++k) spin -= w[k + 2] * x[k], sum += w[k + 2];
    const T across = spin / length, on_i = -across - sum;
    value = ends(arm, {on_i * left.x(), on_i * left.y()}, {across * left.x(), across * left.y()}, w[0], w[1],
                 value);
    for (int k = 0; k < beam.pieces; ++k) {
      *value++ = w[k + 2] * left.x();
      *value++ = w[k + 2] * left.y();
    }
    return value;
  }
  /// Entries of the bodies at the ends, from a row on the velocities of the ends and on the rates of both bodies.
  T* ends(const Arms<T>& arm, const Vec2Of<T>& on_i, const Vec2Of<T>& on_j, double turn_i, double turn_j,
          T* value) const {
    const auto put = [&](int body, const Vec2Of<T>& r, const Vec2Of<T>& on, double turn) {
      if (body == ground) return;
      *value++ = on.x();
      *value++ = on.y();
      *value++ = cross(r, on) + turn;
    };
    put(beam.link.i, arm.ri, on_i, turn_i);
    put(beam.link.j, arm.rj, on_j, turn_j);
    return value;
  }

  const BeamChord& beam;
  T length, phi_i, phi_j;
  Vec2Of<T> along, left;
  std::array<T, most_reduced> x, y;

 private:
  static Vec2Of<T> end(const BeamChord& b, const T* q, const Arms<T>& arm) {
    if (b.link.i == ground) return arm.ri;
    return {q[3 * b.link.i] + arm.ri.x(), q[3 * b.link.i + 1] + arm.ri.y()};
  }
};

/// Rates of a beam at one state.
template <class T>
struct ChordRates {
  ChordRates(const ChordShape<T>& s, const Arms<T>& arm, const T* v) : shape(s), v_(v) {
    const auto& link = s.beam.link;
    const auto u = relative_velocity(link, arm, v);
    spin = dot(s.left, u) / s.length;
    stretch = dot(s.along, u);
    const T w = omega(v, link.i);
    start_ = {-w * arm.ri.y(), w * arm.ri.x()};
    if (link.i != ground) start_ += Vec2Of<T>{v[3 * link.i], v[3 * link.i + 1]};
  }
  /// ṙ of a piece.
  Vec2Of<T> relative(int k) const {
    const int c = 3 * (shape.beam.first + k);
    return {v_[c] - start_.x(), v_[c + 1] - start_.y()};
  }
  T combination(const double* w) const {
    const auto& link = shape.beam.link;
    T sum = w[0] * (omega(v_, link.i) - spin) + w[1] * (omega(v_, link.j) - spin);
    for (int k = 0; k < shape.beam.pieces; ++k)
      sum += w[k + 2] * (dot(shape.left, relative(k)) - spin * shape.x[k]);
    return sum;
  }

  const ChordShape<T>& shape;
  T spin, stretch;  ///< β̇ and ṡ

 private:
  const T* v_;
  Vec2Of<T> start_;
};

}  // namespace freeplay
