// Dynamics of mechanism/elements/beam_element.hpp, which states the equations.
#pragma once

#include <algorithm>

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
    const Shape<T> s(*this, m, link);
    T e = s.chord - length + bowing(s.phi_i, s.phi_j), a = s.phi_i - start, b = s.phi_j + start;
    if (damping > 0) {
      const auto [rate, rate_i, rate_j] = s.rates(m, link);
      e += damping * rate, a += damping * rate_i, b += damping * rate_j;
      out.power.damping -= damping * (stretch * rate * rate + own * (rate_i * rate_i + rate_j * rate_j) +
                                      2 * other * rate_i * rate_j);
    }
    s.pull(*this, link, e, a, b, out);
  }
  /// The change of its forces by a small displacement m.v.
  void resist(const auto& m, const auto& link, auto& out) const {
    const Shape<double> s(*this, m, link);
    const auto [e, a, b] = s.rates(m, link);
    s.pull(*this, link, e, a, b, out, tension(s));
  }

  /// Stiffness (N/m, N m/rad, N m/rad) of the strains e, a + b and a − b, which are uncoupled.
  std::array<double, 3> stiffness() const { return {stretch, 0.5 * (own + other), 0.5 * (own - other)}; }
  /// What a tension adds to it: the bowing has the second derivatives l/20 by a + b and l/12 by a − b. It holds the
  /// pieces of a cable, which hardly has a stiffness of its own; compression adds nothing, so that the sum stays positive.
  std::array<double, 3> tension_stiffness(const auto& m, const Link& link) const {
    const double force = tension(Shape<double>(*this, m, link));
    return {0, force * length / 20, force * length / 12};
  }
  /// Bodies in the order of the entries of strain_rows(), with the number of their coordinates there.
  std::array<std::array<int, 2>, 2> strain_columns() const { return {{{between[0], 3}, {between[1], 3}}}; }
  /// Their rates as rows on the velocities of the moving bodies. Returns the end of the values.
  double* strain_rows(const auto& m, const Link& link, double* values) const {
    const Shape<double> s(*this, m, link);
    const auto row = [&](const Vec2& push, double on_i, double on_j) {  // on ẋ_j − ẋ_i, ω_i and ω_j
      const auto put = [&](int body, const Vec2& arm, double sign, double turning) {
        if (body == ground) return;
        *values++ = sign * push.x();
        *values++ = sign * push.y();
        *values++ = sign * cross(arm, push) + turning;
      };
      put(link.i, s.arm.ri, -1, on_i);
      put(link.j, s.arm.rj, 1, on_j);
    };
    row(s.along - ((s.by_i + s.by_j) / s.chord) * s.left, s.by_i, s.by_j);
    row((-2 / s.chord) * s.left, 1, 1);
    row({0, 0}, 1, -1);
    return values;
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
  /// Geometry at one state.
  template <class T>
  struct Shape {
    Shape(const Dynamics& x, const auto& m, const Link& link) : arm(m.arms(link)) {
      using std::atan2, std::sqrt;
      chord = sqrt(dot(arm.d, arm.d));
      along = {arm.d.x() / chord, arm.d.y() / chord};
      left = perp(along);
      const auto turn = [&](int body, const Vec2& s) {
        const auto t = turned(body, s, m.e);
        return atan2(cross(along, t), dot(along, t));
      };
      phi_i = turn(link.i, x.tangent[0]), phi_j = turn(link.j, x.tangent[1]);
      by_i = x.length / 30 * (4 * phi_i - phi_j), by_j = x.length / 30 * (4 * phi_j - phi_i);
    }
    /// Rates of e, a, b.
    std::array<T, 3> rates(const auto& m, const Link& link) const {
      const auto w = m.relative_velocity(link, arm);
      const T spin = dot(left, w) / chord, rate_i = omega(m.v, link.i) - spin,
              rate_j = omega(m.v, link.j) - spin;
      return {dot(along, w) + by_i * rate_i + by_j * rate_j, rate_i, rate_j};
    }
    /// Applies the forces of strains e, a, b; `tension` (N): adds the change of its moments by a and b.
    void pull(const Dynamics& x, const Link& link, const T& e, const T& a, const T& b, auto& out,
              double tension = 0) const {
      const double bow = tension * x.length / 30, own = x.own + 4 * bow, other = x.other - bow;
      const T force = x.stretch * e, moment_i = force * by_i + own * a + other * b,
              moment_j = force * by_j + own * b + other * a, across = (moment_i + moment_j) / chord;
      out.couples(link, T(-moment_i), T(-moment_j));
      out.pull(link, arm,
               Vec2Of<T>{across * left.x() - force * along.x(), across * left.y() - force * along.y()});
      if constexpr (requires { out.section(force, across, across); })  // M rises from −m_i to m_j
        out.section(force, -across, 0.5 * (moment_j - moment_i) + x.section * (moment_i + moment_j));
    }
    Arms<T> arm;
    T chord, phi_i, phi_j, by_i, by_j;  // by: ∂e/∂φ
    Vec2Of<T> along, left;
  };

  double tension(const Shape<double>& s) const {
    return std::max(0.0, stretch * (s.chord - length + bowing(s.phi_i, s.phi_j)));
  }
  /// l (2φ_i² − φ_i φ_j + 2φ_j²)/30
  template <class T>
  T bowing(const T& phi_i, const T& phi_j) const {
    return length / 30 * (2 * (phi_i * phi_i + phi_j * phi_j) - phi_i * phi_j);
  }
};

}  // namespace freeplay
