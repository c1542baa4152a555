// A prescribed motion of a joint, one row. s is the joint's angle θ_j − θ_i, or its position a·d
// along the axis a of body i; y is a function of x, which is time or the angle φ of another joint:
//
//     Φ = s − y(x),   x = t:  Φ_t = −y′, γ = y″        x = φ:  Φ_t = 0, ∂Φ/∂φ = −y′, γ = y″ φ̇²
//
// Along an axis, with n = perp a, γ also has the terms −2 ω_i n·ḋ + ω_i² a·d + ω_j² a·r_j − ω_i²
// a·r_i.
//
// For a time step from t₀ to t₁, step() sets values that make the end of the step exact:
//
//     Φ_t = −(y₁ − y₀)/h,     −Φ_t + ½ h γ = y′₁
#pragma once

#include <array>
#include <cmath>

#include "dynamics/kinematics.hpp"
#include "mechanism/piecewise.hpp"

namespace freeplay {

struct MotionRow {
  Link link;
  int row = 0, index = 0;  ///< of the row, and among the motion rows
  Piecewise course = {};
  bool slides = false;
  Vec2 axis{1, 0};
  bool follows = false;  ///< whether x is the angle of `other`
  Link other = {};
  int phase = -1;  ///< index of x in System::phases; −1: none
  /// Entries of G (−1: none). Bodies i and j have x, y, θ; a row of an angle uses θ alone.
  std::array<int, 3> of_i{-1, -1, -1}, of_j{-1, -1, -1};
  int other_i = -1, other_j = -1;

  template <class T>
  void place(const T& t, const T* q, EvaluationOf<T>& e) const {
    const T x = follows ? T(theta(q, other.j) - theta(q, other.i)) : t;
    // Restricted to its piece, y is smooth up to the knot at which a step ends.
    const auto y = phase >= 0 && e.pieces ? course.jet(x, e.pieces[phase].inside()) : course.jet(x);
    e.bend[index] = y.bend;
    if (slides) {
      const auto a = arms(link, q, e);
      const Vec2Of<T> along = turned(link.i, axis, e);
      e.phi[row] = dot(along, a.d) - y.value;
      put(e, of_i, -along.x(), -along.y(), -cross(a.ri, along) - cross(a.d, along));
      put(e, of_j, along.x(), along.y(), cross(a.rj, along));
    } else {
      e.phi[row] = theta(q, link.j) - theta(q, link.i) - y.value;
      put(e, of_i, T(0), T(0), T(-1));
      put(e, of_j, T(0), T(0), T(1));
    }
    if (!follows) {
      e.phi_t[row] = -y.slope;
      return;
    }
    // A body may already have an entry.
    const auto add = [&](int entry, int body, const T& amount) {
      if (entry < 0) return;
      const bool shared = body == link.i || body == link.j;
      e.G[entry] = shared ? e.G[entry] + amount : amount;
    };
    add(other_i, other.i, y.slope);
    add(other_j, other.j, -y.slope);
  }

  template <class T>
  void rate(const T* q, const T* v, EvaluationOf<T>& e) const {
    T g = e.bend[index];
    if (follows) {
      const T turning = omega(v, other.j) - omega(v, other.i);
      g = g * turning * turning;
    }
    if (slides) {
      const auto a = arms(link, q, e);
      const Vec2Of<T> along = turned(link.i, axis, e), n = perp(along);
      const T wi = omega(v, link.i), wj = omega(v, link.j);
      g += wi * wi * (dot(along, a.d) - dot(along, a.ri)) + wj * wj * dot(along, a.rj) -
           2 * wi * dot(n, relative_velocity(link, a, v));
    }
    e.gamma[row] = g;
  }

  /// Prepares a time step from t0 to t1; call it between place() and rate().
  void step(double t0, double t1, Evaluation& e) const {
    if (follows) return;
    const double h = t1 - t0, mean = mean_rate(t0, t1);
    e.phi_t[row] = -mean;
    e.bend[index] = 2 / h * (course.jet(t1).slope - mean);
  }

 private:
  /// (y₁ − y₀)/h. Over a short step, where the difference is mostly rounding, by Gauss quadrature
  /// with three points.
  double mean_rate(double t0, double t1) const {
    const double h = t1 - t0, y0 = course.value(t0), y1 = course.value(t1), whole = (y1 - y0) / h;
    const double middle = 0.5 * (t0 + t1), out = 0.3872983346207417 * h;  // √(3/5)/2
    const double rate = (5 * (course.jet(middle - out).slope + course.jet(middle + out).slope) +
                         8 * course.jet(middle).slope) /
                        18;
    return std::abs(rate - whole) <= 1e-15 * (std::abs(y0) + std::abs(y1)) / h ? rate : whole;
  }
  template <class T>
  static void put(EvaluationOf<T>& e, const std::array<int, 3>& entry, const T& x, const T& y,
                  const T& turn) {
    if (entry[0] >= 0) e.G[entry[0]] = x;
    if (entry[1] >= 0) e.G[entry[1]] = y;
    if (entry[2] >= 0) e.G[entry[2]] = turn;
  }
};

/// The row of a fixed ratio between two joints: the same with a straight line y. It prescribes no
/// motion, so it is no drive.
struct RatioRow : MotionRow {};

}  // namespace freeplay
