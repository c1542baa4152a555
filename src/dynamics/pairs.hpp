// Kinds of contact pair, each with its gap and rates: two circles, a disc and a wall, the stop of an angle, a
// tooth flank, the backlash of a ratio. Pairs of cams are in cam_pairs.hpp.
#pragma once

#include "dynamics/evaluation.hpp"
#include "dynamics/gap_motion.hpp"
#include "dynamics/kinematics.hpp"
#include "dynamics/mesh.hpp"

namespace freeplay {

/// Adds the entries of a body for a unit force along `direction` and the couple `turn` about its
/// centre of mass.
template <class T>
void push(SparseRowOf<T>& row, int body, const Vec2Of<T>& direction, const T& turn) {
  if (body == ground) return;
  row.push(3 * body, direction.x());
  row.push(3 * body + 1, direction.y());
  row.push(3 * body + 2, turn);
}

/// The part of d̈ without accelerations: ω_i² r_i − ω_j² r_j.
template <class T>
Vec2Of<T> centripetal(const Vec2Of<T>& ri, const T& wi, const Vec2Of<T>& rj, const T& wj) {
  return {wi * wi * ri.x() - wj * wj * rj.x(), wi * wi * ri.y() - wj * wj * rj.y()};
}

// Two circles. With e = r_j − r_i, n = e/|e|, t = perp n. A journal inside a bearing has s = +1 and
// touches at |e| = R_i − R_j. Discs outside each other have s = −1 and are described with R_j < 0:
//
//     g = s(R_i − R_j − |e|),    ġ = −s n·ė,         g̈ = −s[n·ë + (t·ė)²/|e|]
//     v_T = t·ė + R_j ω_j − R_i ω_i   (velocity of the second surface relative to the first)
//     v̇_T = t·ë − (t·ė)(n·ė)/|e| + R_j α_j − R_i α_i
//
// and for films
//
//     w_t = t·ė − ½(ω_i + ω_j)|e|
//     ẇ_t = t·ë − (t·ė)(n·ė)/|e| − ½(α_i + α_j)|e| − ½(ω_i + ω_j) n·ė

struct RoundPair {
  Link link;
  double side = 1;                    ///< s: +1 ring, −1 discs
  double rest = 0;                    ///< m, |e| at contact
  double radius_i = 0, radius_j = 0;  ///< m; R_j < 0 for discs

  double gap(const Vec2& d, const Evaluation&) const { return side * (rest - d.norm()); }
  /// Bounds on the gap's second derivative within a step.
  GapMotion motion(const MotionBounds& bounds, const Vec2&) const {
    auto m = relative_motion(link, bounds);
    m.shape = side > 0 ? GapMotion::Shape::inside : GapMotion::Shape::outside;
    m.rest = rest;
    return m;
  }

  /// Motion within a time h as a share of the motion that could pass the contact undetected: twice
  /// the sum of the radii for discs. Zero for a journal, which stays outside its bearing's wall
  /// once it is there.
  double passage(const double* v, double h) const { return side > 0 ? 0 : path(link, v, h) / (2 * rest); }

  template <class T>
  void rows(const ContactFacts& facts, const Arms<T>& a, const T* v, const EvaluationOf<T>&,
            ContactRowOf<T>& row) const {
    using std::sqrt;
    const int i = link.i, j = link.j;
    const T length = sqrt(dot(a.d, a.d));
    row.gap = side * (rest - length);
    // A concentric journal has no normal. A film still resists it, equally in all directions, so
    // any normal is used.
    const bool concentric = !(length > 1e-9 * facts.clearance);
    if (concentric && !facts.lubricant) return;

    Vec2Of<T> n{T(1), T(0)};
    if (!concentric) n = {a.d.x() / length, a.d.y() / length};
    const Vec2Of<T> t = perp(n), rate = relative_velocity(link, a, v);
    const Vec2Of<T> still = centripetal(a.ri, omega(v, i), a.rj, omega(v, j));
    const T swirl = dot(t, rate);
    row.gamma_n = side * dot(n, still);
    if (!concentric) row.gamma_n += side * swirl * swirl / length;
    const Vec2Of<T> outward{side * n.x(), side * n.y()}, inward = -outward;
    push(row.normal, i, outward, cross(a.ri, outward));
    push(row.normal, j, inward, cross(a.rj, inward));
    const Vec2Of<T> back = -t;
    if (facts.lubricant) {
      push(row.film, i, back, T(cross(a.ri, back) - 0.5 * length));
      push(row.film, j, t, T(cross(a.rj, t) - 0.5 * length));
      if (i != ground) row.spin.push(3 * i + 2, -1);
      if (j != ground) row.spin.push(3 * j + 2, 1);
      row.gamma_film = 0.5 * (omega(v, i) + omega(v, j)) * dot(n, rate) - dot(t, still);
      row.turn = concentric ? T(0) : T(swirl / length);
      row.gamma_film += row.turn * dot(n, rate);
    }
    if (!facts.surface.friction) return;
    row.gamma_t = -dot(t, still);
    if (!concentric) row.gamma_t += swirl * dot(n, rate) / length;
    push(row.tangent, i, back, T(cross(a.ri, back) - radius_i));
    push(row.tangent, j, t, T(cross(a.rj, t) + radius_j));
  }
};

// A disc of radius R (0: a corner) of body j and a wall along the axis a of body i. n = s perp a
// points into the free space, d = r_j − r_i, y = n·d − R is the distance of the contact point from
// body i's point along n:
//
//     g = n·d − rest,    ġ = n·ḋ − s ω_i a·d,    g̈ = n·d̈ − s α_i a·d − 2 s ω_i a·ḋ − ω_i² n·d
//     v_T = a·ḋ + s R ω_j + s y ω_i,        v̇_T = a·d̈ + ω_i perp(a)·ḋ + s(ω_i ġ + R α_j + y α_i)

struct LinePair {
  Link link;
  double side = 1;  ///< s, +1: free space on the left of the axis, −1: on the right
  Vec2 axis{1, 0};
  double rest = 0;    ///< m, n·d at contact
  double radius = 0;  ///< m, R

  double gap(const Vec2& d, const Evaluation& e) const {
    return side * dot(perp(turned(link.i, axis, e)), d) - rest;
  }
  /// Bounds on the gap's second derivative within a step; d at its end. A turning wall adds
  /// n̈·d + 2ṅ·ḋ with |ṅ| ≤ |ω_i|.
  GapMotion motion(const MotionBounds& bounds, const Vec2& d) const {
    auto m = relative_motion(link, bounds);
    if (link.i == ground) {  // fixed wall: motion along it has no effect
      const int c = planar::first(link.j);
      const double turn = bounds.speed[c + 2];
      m.acceleration = std::abs(axis.y()) * bounds.acceleration[c] +
                       std::abs(axis.x()) * bounds.acceleration[c + 1] +
                       link.sj.norm() * (turn * turn + bounds.acceleration[c + 2]);
      return m;
    }
    const int c = planar::first(link.i) + 2;
    const double turn = bounds.speed[c];
    const double reach = d.norm() + m.speed * bounds.duration;
    m.acceleration += 2 * turn * m.speed + (turn * turn + bounds.acceleration[c]) * reach;
    return m;
  }

  /// Motion within a time h as a share of the motion that could pass the contact undetected: the
  /// arc below the wall of a point on a turning arm, as long as the arm's diameter. A point that
  /// passes through without turning stays below.
  double passage(const double* v, double h) const {
    if (link.j == ground || link.sj.is_zero()) return 0;
    return 0.5 * std::abs(planar::rate(v, link.j)) * h;
  }

  template <class T>
  void rows(const ContactFacts& facts, const Arms<T>& a, const T* v, const EvaluationOf<T>& e,
            ContactRowOf<T>& row) const {
    const int i = link.i, j = link.j;
    const double s = side;
    const Vec2Of<T> wall = turned(i, axis, e), left = perp(wall), n{s * left.x(), s * left.y()};
    const Vec2Of<T> rate = relative_velocity(link, a, v);
    const T wi = omega(v, i), wj = omega(v, j), along = dot(wall, a.d), height = dot(n, a.d);
    const Vec2Of<T> still = centripetal(a.ri, wi, a.rj, wj), back = -n;
    row.gap = height - rest;
    row.gamma_n = 2 * s * wi * dot(wall, rate) + wi * wi * height - dot(n, still);
    push(row.normal, i, back, T(cross(a.ri, back) - s * along));
    push(row.normal, j, n, cross(a.rj, n));
    if (!facts.surface.friction) return;
    const T y = height - radius, closing = dot(n, rate) - s * wi * along;
    row.gamma_t = -(dot(wall, still) + wi * dot(left, rate) + s * wi * closing);
    const Vec2Of<T> behind = -wall;
    push(row.tangent, i, behind, T(cross(a.ri, behind) + s * y));
    push(row.tangent, j, wall, T(cross(a.rj, wall) + s * radius));
  }
};

// Stop of a joint's angle θ = θ_j − θ_i at a radius r. With c the direction from the joint to the
// stop, fixed in body i, n = −s perp c (s = +1 for the greatest angle, −1 for the least),
// d = r_j − r_i:
//
//     g = s r (limit − θ) + n·d,     ġ = −s r (ω_j − ω_i) + n·ḋ + ω_i perp n·d
//     g̈ = −s r (α_j − α_i) + n·d̈ + α_i perp n·d + 2 ω_i perp n·ḋ − ω_i² n·d
//
// The force thus acts through the stop's point. Without a direction n = 0: two opposite stops, a
// couple.

struct AngleStopPair {
  Link link;
  double side = 1;    ///< s
  double limit = 0;   ///< rad
  double radius = 0;  ///< m, r
  Vec2 normal{0, 0};  ///< n in the first body's frame; zero: a couple

  double gap(const double* q, const Vec2& d, const Evaluation& e) const {
    return side * radius * (limit - (theta(q, link.j) - theta(q, link.i))) +
           dot(turned(link.i, normal, e), d);
  }
  /// Bounds on the gap's second derivative within a step; d at its end.
  GapMotion motion(const MotionBounds& bounds, const Vec2& d) const {
    auto m = relative_motion(link, bounds);
    if (normal.is_zero()) m.acceleration = 0;
    for (const int body : {link.i, link.j})
      if (body != ground) m.acceleration += radius * bounds.acceleration[planar::first(body) + 2];
    if (link.i == ground || normal.is_zero()) return m;
    const int c = planar::first(link.i) + 2;
    const double turn = bounds.speed[c], reach = d.norm() + m.speed * bounds.duration;
    m.acceleration += 2 * turn * m.speed + (turn * turn + bounds.acceleration[c]) * reach;
    return m;
  }
  /// Zero: a closed stop cannot be passed through.
  double passage(const double*, double) const { return 0; }

  template <class T>
  void rows(const Arms<T>& a, const T* q, const T* v, const EvaluationOf<T>& e, ContactRowOf<T>& row) const {
    const int i = link.i, j = link.j;
    const T wi = omega(v, i), turn = T(side * radius);
    const Vec2Of<T> n = turned(i, normal, e), back = -n, left = perp(n);
    const T height = dot(n, a.d);
    row.gap = side * radius * (limit - (theta(q, j) - theta(q, i))) + height;
    row.gamma_n = -(dot(n, centripetal(a.ri, wi, a.rj, omega(v, j))) +
                    2 * wi * dot(left, relative_velocity(link, a, v)) - wi * wi * height);
    push(row.normal, i, back, T(cross(a.ri, back) + dot(left, a.d) + turn));
    push(row.normal, j, n, T(cross(a.rj, n) - turn));
  }
};

// A tooth flank as a contact, with gap and direction from mesh.hpp,
//
//     ġ = u·ḋ + ρ_i ω_i + ρ_j ω_j
//
// Teeth with backlash have no friction: their sliding depends on which pair of teeth carries, which no
// state stores.

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
    row.gamma_n =
        -(dot(f.along, centripetal(a.ri, wi, a.rj, wj)) + mesh.velocity_terms(f, a.d, rate, wi, wj));
    push(row.normal, i, back, T(cross(a.ri, back) + f.turn_i));
    push(row.normal, j, f.along, T(cross(a.rj, f.along) + f.turn_j));
  }
};

// Backlash of a ratio between two joints whose other bodies are the ground: linear in the angles of
// both moving bodies, or in the angle of the first and the place of the second's point P along a fixed
// direction A,
//
//     g = rest + ρ_i θ_i + ρ_j θ_j + A·P,    ġ = ρ_i ω_i + ρ_j ω_j + A·Ṗ
//     P̈ = ẍ_j + α_j perp r_j − ω_j² r_j

struct RatioPair {
  Link link;                      ///< si is zero
  double rest = 0;                ///< m
  double turn_i = 0, turn_j = 0;  ///< m, ρ
  Vec2 along{0, 0};               ///< A; zero: the second joint turns

  double gap(const double* q, const Vec2&, const Evaluation& e) const {
    return gap_at(q, turned(link.j, link.sj, e));
  }
  /// Bounds on the gap's second derivative within a step.
  GapMotion motion(const MotionBounds& bounds, const Vec2&) const {
    const int i = planar::first(link.i), j = planar::first(link.j);
    const auto& a = bounds.acceleration;
    const double turn = bounds.speed[j + 2];
    GapMotion m;
    m.acceleration = std::abs(turn_i) * a[i + 2] + std::abs(turn_j) * a[j + 2] + std::abs(along.x()) * a[j] +
                     std::abs(along.y()) * a[j + 1] + link.sj.norm() * (turn * turn + a[j + 2]);
    return m;
  }
  /// Zero: a closed contact cannot be passed through.
  double passage(const double*, double) const { return 0; }

  template <class T>
  void rows(const Arms<T>& a, const T* q, const T* v, const EvaluationOf<T>&, ContactRowOf<T>& row) const {
    const Vec2Of<T> direction{T(along.x()), T(along.y())};
    const T turn = omega(v, link.j);
    row.gap = gap_at(q, a.rj);
    row.gamma_n = turn * turn * dot(direction, a.rj);
    push(row.normal, link.i, {T(0), T(0)}, T(turn_i));
    push(row.normal, link.j, direction, T(cross(a.rj, direction) + turn_j));
  }

 private:
  template <class T>
  T gap_at(const T* q, const Vec2Of<T>& arm) const {
    const int j = planar::first(link.j);
    return rest + turn_i * theta(q, link.i) + turn_j * theta(q, link.j) + along.x() * (q[j] + arm.x()) +
           along.y() * (q[j + 1] + arm.y());
  }
};

}  // namespace freeplay
