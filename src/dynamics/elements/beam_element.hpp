// Dynamics of mechanism/elements/beam_element.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/beam_element.hpp"

namespace freeplay {

template <>
struct Dynamics<BeamElement> : BeamElement {
  double stretch = axial / length;  ///< EA/l
  /// Stiffness of an end's rotation, and its coupling to the other end.
  double own = 0, other = 0;
  double start = -0.5 * curvature * length;  ///< φ_i⁰ = −φ_j⁰
  std::array<Vec2, 2> tangent{};             ///< in the frames of the bodies

  explicit Dynamics(const BeamElement& facts) : BeamElement(facts) {
    const double phi = shear > 0 ? 12 * bending / (shear * length * length) : 0,
                 whole = bending / (length * (1 + phi));
    own = (4 + phi) * whole, other = (2 - phi) * whole;
    tangent = {Vec2{std::cos(angles.x()), std::sin(angles.x())},
               Vec2{std::cos(angles.y()), std::sin(angles.y())}};
  }

  auto link(auto& b) const { return b.link(between, at); }
  bool does_work() const { return damping > 0; }
  bool needs_velocity() const { return damping > 0; }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    using std::atan2, std::sqrt;
    const auto arm = m.arms(link);
    const T chord = sqrt(dot(arm.d, arm.d));
    const Vec2Of<T> along{arm.d.x() / chord, arm.d.y() / chord}, left = perp(along);
    const auto turn = [&](int body, const Vec2& s) {
      const auto t = turned(body, s, m.e);
      return atan2(cross(along, t), dot(along, t));
    };
    const T phi_i = turn(link.i, tangent[0]), phi_j = turn(link.j, tangent[1]);
    T e = chord - length + bowing(phi_i, phi_j), a = phi_i - start, b = phi_j + start;
    const T by_i = length / 30 * (4 * phi_i - phi_j), by_j = length / 30 * (4 * phi_j - phi_i);  // ∂e/∂φ
    if (damping > 0) {
      const auto w = m.relative_velocity(link, arm);
      const T spin = dot(left, w) / chord, rate_i = omega(m.v, link.i) - spin,
              rate_j = omega(m.v, link.j) - spin, rate = dot(along, w) + by_i * rate_i + by_j * rate_j;
      e += damping * rate, a += damping * rate_i, b += damping * rate_j;
      out.power.damping -= damping * (stretch * rate * rate + own * (rate_i * rate_i + rate_j * rate_j) +
                                      2 * other * rate_i * rate_j);
    }
    const T force = stretch * e, moment_i = force * by_i + own * a + other * b,
            moment_j = force * by_j + own * b + other * a, across = (moment_i + moment_j) / chord;
    out.couple(Link{ground, link.i}, T(-moment_i));
    out.couple(Link{ground, link.j}, T(-moment_j));
    out.pull(link, arm,
             Vec2Of<T>{across * left.x() - force * along.x(), across * left.y() - force * along.y()});
  }

  double potential(const auto& at_rest, const auto& link) const {
    const auto place = [&](int body, const Vec2& s, const Vec2& t) {
      const Vec2 p = at_rest.point(body, s);
      return std::pair{p, Vec2(at_rest.point(body, s + t) - p)};
    };
    const auto [p, t] = place(link.i, link.si, tangent[0]);
    const auto [r, u] = place(link.j, link.sj, tangent[1]);
    const Vec2 d = r - p;
    const double phi_i = std::atan2(cross(d, t), dot(d, t)), phi_j = std::atan2(cross(d, u), dot(d, u));
    const double e = d.norm() - length + bowing(phi_i, phi_j), a = phi_i - start, b = phi_j + start;
    return 0.5 * (stretch * e * e + own * (a * a + b * b)) + other * a * b;
  }

 private:
  /// l (2φ_i² − φ_i φ_j + 2φ_j²)/30
  template <class T>
  T bowing(const T& phi_i, const T& phi_j) const {
    return length / 30 * (2 * (phi_i * phi_i + phi_j * phi_j) - phi_i * phi_j);
  }
};

}  // namespace freeplay
