// Kinematics of a mechanism at one instant, for elements: angles, arms and relative velocities.
// Only src/dynamics knows that a body has the coordinates x, y, θ.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "mechanism/body.hpp"
#include "numerics/choice.hpp"
#include "values/vec2.hpp"

namespace freeplay {

/// Powers (W) of drives and loads into the mechanism.
template <class T>
struct LoadPower {
  T drive = 0;    ///< torque drives
  T load = 0;     ///< constant forces and torques
  T damping = 0;  ///< dampers, ≤ 0
};

template <class P>
struct PieceOf;

/// Quantities that a System computes at one state.
template <class T>
struct EvaluationOf {
  std::vector<T> cosine, sine;       ///< of each body's angle
  std::vector<T> phi, phi_t, gamma;  ///< one per constraint row
  std::vector<T> bend;               ///< y″ of each prescribed motion, see rows/motion.hpp
  std::vector<T> G;                  ///< values in the order of System::pattern()
  std::vector<T> force;              ///< generalised forces, n entries
  LoadPower<T> power;
  const PieceOf<T>* pieces = nullptr;  ///< pieces of System::phases that the last place() used
};
using Evaluation = EvaluationOf<double>;

/// Two bodies and the points of an element in their frames.
struct Link {
  int i = ground, j = ground;
  Vec2 si{0, 0}, sj{0, 0};
};

/// World arms of the two points, and d = r_j^P − r_i^P.
template <class T>
struct Arms {
  Vec2Of<T> ri, rj, d;
};

template <class T>
T omega(const T* v, int body) {
  return body == ground ? T(0) : v[3 * body + 2];
}
template <class T>
T theta(const T* q, int body) {
  return body == ground ? T(0) : q[3 * body + 2];
}

/// Position or velocity of a body's centre of mass in the world.
inline Vec2 centre(const double* x, int body) {
  return body == ground ? Vec2{0, 0} : Vec2{x[3 * body], x[3 * body + 1]};
}

/// A vector of a body's frame, in world axes. Always inlined: rows call it a dozen times a step.
template <class T>
[[gnu::always_inline]] inline Vec2Of<T> turned(int body, const Vec2& s, const EvaluationOf<T>& e) {
  if (body == ground) return {T(s.x()), T(s.y())};
  const T &c = e.cosine[body], &sn = e.sine[body];
  return {c * s.x() - sn * s.y(), sn * s.x() + c * s.y()};
}

template <class T>
Arms<T> arms(const Link& link, const T* q, const EvaluationOf<T>& e) {
  Arms<T> a;
  a.ri = turned(link.i, link.si, e);
  a.rj = turned(link.j, link.sj, e);
  a.d = {a.rj.x() - a.ri.x(), a.rj.y() - a.ri.y()};
  if (link.i != ground) a.d -= Vec2Of<T>{q[3 * link.i], q[3 * link.i + 1]};
  if (link.j != ground) a.d += Vec2Of<T>{q[3 * link.j], q[3 * link.j + 1]};
  return a;
}

template <class T>
Vec2Of<T> relative_velocity(const Link& link, const Arms<T>& a, const T* v) {
  Vec2Of<T> u{T(0), T(0)};
  const auto add = [&](int body, const Vec2Of<T>& arm, double sign) {
    if (body == ground) return;
    const T& w = v[3 * body + 2];
    u.x() += sign * (v[3 * body] - w * arm.y());
    u.y() += sign * (v[3 * body + 1] + w * arm.x());
  };
  add(link.i, a.ri, -1);
  add(link.j, a.rj, 1);
  return u;
}

/// Data of a whole time step, for functions that must not be sampled at its midpoint alone.
template <class P>
struct SweepOf {
  P h = 0;  ///< s
  /// Rates at its start, from which the positions at its midpoint were computed.
  const P* start = nullptr;
  const P* mean = nullptr;  ///< mean rates of the step, as far as they are known
};
using Sweep = SweepOf<double>;

/// The interval between two kinks of a table of an angle (rad, full turns included) or of a force
/// of a distance (m). An end without a further kink is infinite.
template <class P>
struct PieceOf {
  P low = 0, high = 0;
  /// A place within the interval.
  P inside() const {
    const auto from = is_below(-INFINITY, low), to = is_below(high, INFINITY);
    return choose(
        from,
        [&] {
          return choose(
              to, [&]() -> P { return 0.5 * (low + high); }, [&]() -> P { return low + 1; });
        },
        [&] {
          return choose(
              to, [&]() -> P { return high - 1; }, [&]() -> P { return 0; });
        });
  }
  template <class M>
  void serialize(M& m) {
    m(low, high);
  }
};
using Piece = PieceOf<double>;

/// How tables are evaluated: at a point, by their mean over a time step (sweep), or on fixed pieces
/// (one for each of System::phases), so that they are smooth however far a stage of the integrator
/// reaches.
template <class P>
struct ReadingOf {
  const SweepOf<P>* sweep = nullptr;
  const PieceOf<P>* pieces = nullptr;
};
using Reading = ReadingOf<double>;

/// A state as drives and loads see it.
template <class T>
struct Motion {
  T t;
  const T* q;
  const T* v;  ///< nullptr if velocities are not known
  const EvaluationOf<T>& e;
  ReadingOf<T> reading = {};
  /// Piece of the element being evaluated, if it is restricted to one.
  const PieceOf<T>* piece = nullptr;

  Arms<T> arms(const Link& link) const { return freeplay::arms(link, q, e); }
  Vec2Of<T> relative_velocity(const Link& link, const Arms<T>& a) const {
    return freeplay::relative_velocity(link, a, v);
  }
  /// θ_j − θ_i and ω_j − ω_i.
  T angle(const Link& link) const { return theta(q, link.j) - theta(q, link.i); }
  T spin(const Link& link) const { return omega(v, link.j) - omega(v, link.i); }
  /// The state for the element of this phase (−1: none).
  Motion of(int phase) const {
    auto m = *this;
    if (phase >= 0 && reading.pieces) m.piece = reading.pieces + phase;
    return m;
  }
  /// θ_j − θ_i at the start and at the end of the time step.
  std::array<T, 2> swept(const Link& link) const {
    const auto& s = *reading.sweep;
    const T from = angle(link) - 0.5 * s.h * (omega(s.start, link.j) - omega(s.start, link.i));
    return {from, from + s.h * (omega(s.mean, link.j) - omega(s.mean, link.i))};
  }
};

/// Positions alone, for potentials.
struct Placement {
  const double* q;
  /// A point of a body in the world (m).
  Vec2 point(int body, const Vec2& s) const {
    if (body == ground) return s;
    const double c = std::cos(q[3 * body + 2]), sn = std::sin(q[3 * body + 2]);
    return {q[3 * body] + c * s.x() - sn * s.y(), q[3 * body + 1] + sn * s.x() + c * s.y()};
  }
  double angle(const Link& link) const { return theta(q, link.j) - theta(q, link.i); }
};

}  // namespace freeplay
