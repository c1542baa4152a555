// Contact pair of a disc and a convex outline (mechanism/elements/outline_contact.hpp).
//
// Let C be the convex polygon through the centres c_k of the corners' arcs, R the radius of the disc, r that
// of the corners, and x the disc's centre in the axes of body i, from its point. With unit vectors u_k from
// c_k to c_{k+1}, edges of length L_k, s_k = u_k·(x − c_k) and heights h_k = −perp u_k·(x − c_k),
//
//     g = D(x) − (r + R),     D = max h_k            inside C
//                             D = h_k                outside, beside an edge: h_k ≥ 0, 0 ≤ s_k ≤ L_k
//                             D = |x − c_k|          outside, nearest to a corner
//
// An edge is a wall (LinePair), a corner a circle of radius r (RoundPair). Both have the same tangent
// t = u_k, counterclockwise around the outline. g and ġ are continuous; g̈ jumps between an edge and a corner
// by (t·w)²/(r + R), with the velocity w of the disc's centre in the axes of body i. Therefore s_k = 0 and
// s_k = L_k are kinks (dynamics/phase.hpp): steps of adaptive integrators end there, and within a step the
// disc keeps its feature. On corners the sliding rate is that of the disc's surface,
//
//     v_T = t·ė − R ω_j − (r + g) ω_i
//
// as on edges, so that it is continuous, too.
//
// Bounds. D is convex and |∇D| ≤ 1, and outside C its second derivatives are between 0 and 1/D. With bounds
// of |w| and of the acceleration A of x in the axes of body i, D therefore has the bounds of a distance |d|
// with |ḋ| ≤ |w| and |d̈| ≤ A (GapMotion::Shape::outside), whichever features come near within the step.
#pragma once

#include <cmath>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "dynamics/pairs.hpp"
#include "dynamics/phase.hpp"

namespace freeplay {

struct OutlinePair {
  struct Edge {
    Vec2 from;          ///< m, c_k
    Vec2 along;         ///< u_k
    double length = 0;  ///< m, L_k
    int phase = -1;     ///< of s_k in System::phases; of L_k − s_k on the back of a thin face
  };
  Link link;
  double radius = 0, corner_radius = 0;  ///< m, R and r
  double reach = 0;                      ///< m, greatest |c_k|
  double width = 0;                      ///< m, least thickness of the outline
  std::vector<Edge> edges = {};

  double rest() const { return radius + corner_radius; }
  /// The coordinate s_k, whose kinks are the ends of the edge.
  static Phase phase(Link link, const Edge& edge) {
    link.si += edge.from;
    return {link, {0, edge.length}, 0, Phase::Of::travel, edge.along, false, false, true};
  }

  double gap(const Vec2& d, const Evaluation& e) const {
    const auto [k, on_edge] = feature(d, e, nullptr);
    const Vec2 from_corner = d - turned(link.i, edges[k].from, e);
    return on_edge ? wall(k).gap(from_corner, e) : arc().gap(from_corner, e);
  }
  /// Bounds on the gap's second derivative within a step; d at its end.
  GapMotion motion(const MotionBounds& bounds, const Vec2& d) const {
    auto m = relative_motion(link, bounds);
    const double turn = omega(bounds.speed.data(), link.i), twist = omega(bounds.acceleration.data(), link.i);
    const double far = d.norm() + m.speed * bounds.duration, w = m.speed + turn * far;
    m.acceleration += twist * far + 2 * turn * w + turn * turn * far;
    m.shape = GapMotion::Shape::outside;
    m.speed = w;
    m.rest = rest();
    return m;
  }
  /// Motion within a time h as a share of the motion that could pass the contact undetected: the
  /// diameter of the disc and the thickness of the outline.
  double passage(const double* v, double h) const {
    const double turning = (reach + rest()) * std::abs(omega(v, link.i)) * h;
    return (path(link, v, h) + turning) / (2 * rest() + width);
  }

  template <class T>
  void rows(const ContactFacts& facts, const Arms<T>& a, const T* v, const EvaluationOf<T>& e,
            ContactRowOf<T>& row) const {
    const auto [k, on_edge] = feature(a.d, e, e.pieces);
    const Vec2Of<T> corner = turned(link.i, edges[k].from, e);
    const Arms<T> arms{a.ri + corner, a.rj, a.d - corner};
    if (on_edge) return wall(k).rows(facts, arms, v, e, row);
    arc().rows(facts, arms, v, e, row);
    if (link.i == ground || row.tangent.size == 0) return;
    // From the corner's surface to that of the disc; body i's angle is the third entry.
    row.tangent.value[2] -= row.gap;
    row.gamma_t += row.normal.dot(v) * omega(v, link.i);
  }

 private:
  struct Feature {
    std::size_t edge;
    bool on_edge;  ///< else its first corner
  };
  LinePair wall(std::size_t k) const { return {link, -1, edges[k].along, rest(), radius}; }
  RoundPair arc() const { return {link, -1, rest(), corner_radius, -radius}; }

  /// Whether the disc is beside edge k: 0 ≤ s ≤ L; with pieces, as on the piece of its phase.
  template <class T>
  static bool is_beside(const Edge& edge, const T& s, const PieceOf<T>* pieces) {
    if (!pieces) return !(s < T(0)) && !(T(edge.length) < s);
    const auto& piece = pieces[edge.phase];
    return T(-0.5 * edge.length) < piece.low && piece.high < T(1.5 * edge.length);
  }
  /// The nearest feature. Comparisons of traced numbers are guards of the trace.
  template <class T>
  Feature feature(const Vec2Of<T>& d, const EvaluationOf<T>& e,
                  std::type_identity_t<const PieceOf<T>*> pieces) const {
    if constexpr (is_traced<T>) only_differentiated("its place changes between edges and corners");
    const Vec2Of<T> x = in_first(d, e);
    std::size_t highest = 0, nearest = 0;
    T most(0), least(0);
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const auto& edge = edges[k];
      const Vec2Of<T> from{x.x() - edge.from.x(), x.y() - edge.from.y()};
      const T s = edge.along.x() * from.x() + edge.along.y() * from.y();
      const T height = edge.along.y() * from.x() - edge.along.x() * from.y();
      if (!(height < T(0)) && is_beside(edge, s, pieces)) return {k, true};
      const T square = from.squared_norm();
      if (k == 0 || most < height) highest = k, most = height;
      if (k == 0 || square < least) nearest = k, least = square;
    }
    return most < T(0) ? Feature{highest, true} : Feature{nearest, false};
  }
  template <class T>
  Vec2Of<T> in_first(const Vec2Of<T>& d, const EvaluationOf<T>& e) const {
    if (link.i == ground) return d;
    const T &c = e.cosine[link.i], &s = e.sine[link.i];
    return {c * d.x() + s * d.y(), c * d.y() - s * d.x()};
  }
};

}  // namespace freeplay
