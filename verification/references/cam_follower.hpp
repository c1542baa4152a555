// A cam that turns at ω under a follower that is guided straight towards the cam's axis, m its mass
// (kg), pressed down by a spring (k, and F₀ at no lift) and weight. With the angle φ = ωt since no
// lift, in steady contact,
//
//     y = h(φ),    P = m ω² h'' + k h + F₀ + m g           contact force along the guide
//
// Eccentric disc, h = e (1 − cos φ), under a flat face: N = P, and
//
//     P = (m ω² − k) e cos φ + k e + F₀ + m g
//
// reaches zero first at φ = π when m e ω² = 2 k e + F₀ + m g (the jump speed), beyond that where
// cos φ = −(k e + F₀ + m g)/((m ω² − k) e). The cam's torque against its turning is M = N h' and,
// with friction of the face sliding on the cam's profile, μ N (R + h) in addition. Roller on the
// pitch curve r = r₀ + h: pressure angle tan α = h'/r, N = P/cos α without friction, M = P h'.
// Source: Norton, Cam Design and Manufacturing Handbook, on follower dynamics; here from Newton's
// law.
#pragma once

#include <cmath>

#include "verification/references/bisection.hpp"

namespace freeplay::reference {

struct EccentricCam {
  double eccentricity;  ///< m, e
  double mass;          ///< kg, of the follower
  double stiffness;     ///< N/m
  double preload;       ///< N, spring and weight at no lift
  double radius;        ///< m, R, of the cam at no lift; of a roller's pitch curve
  double friction = 0;

  double lift(double phi) const { return eccentricity * (1 - std::cos(phi)); }
  double slope(double phi) const { return eccentricity * std::sin(phi); }
  double press(double phi, double speed) const {
    return mass * speed * speed * eccentricity * std::cos(phi) + stiffness * lift(phi) + preload;
  }
  double jump_speed() const {
    return std::sqrt((2 * stiffness * eccentricity + preload) / (mass * eccentricity));
  }
  /// φ of the first loss of contact, above the jump speed.
  double lost_at(double speed) const {
    return std::acos(-(stiffness * eccentricity + preload) /
                     ((mass * speed * speed - stiffness) * eccentricity));
  }
  /// Time after the loss of contact (s) and rate (m/s) of the landing: y = y_e + (y₀ − y_e) cos
  /// νt + ẏ₀/ν sin νt, ν² = k/m, y_e = −preload/k, against h; the first root by steps of 1e-6 of a
  /// revolution and bisection.
  struct Landing {
    double after, rate;
  };
  Landing landing(double speed) const {
    const double phi = lost_at(speed), nu = std::sqrt(stiffness / mass), rest = -preload / stiffness;
    const double y0 = lift(phi) - rest, v0 = speed * slope(phi);
    const auto gap = [&](double t) {
      return rest + y0 * std::cos(nu * t) + v0 / nu * std::sin(nu * t) - lift(phi + speed * t);
    };
    const double h = 1e-6 * 2 * M_PI / speed;
    // before that, a gap that opens with its third derivative is zero within rounding
    double low = 1000 * h;
    while (gap(low + h) > 0) low += h;
    double high = low + h;
    bisect(low, high, 60, [&](double x) { return gap(x) > 0; });
    return {low, v0 * std::cos(nu * low) - y0 * nu * std::sin(nu * low) - speed * slope(phi + speed * low)};
  }
  double torque_flat(double phi, double speed) const {
    return press(phi, speed) * (slope(phi) + friction * (radius + lift(phi)));
  }
  double torque_roller(double phi, double speed) const { return press(phi, speed) * slope(phi); }
  double normal_roller(double phi, double speed) const {
    return press(phi, speed) / std::cos(std::atan2(slope(phi), radius + lift(phi)));
  }
};

}  // namespace freeplay::reference
