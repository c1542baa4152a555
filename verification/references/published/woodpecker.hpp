// The woodpecker toy: a sleeve with clearance on a pole, and a bird on a torsional spring.
// Coordinates are the height y of the sleeve's centre, which stays on the pole's axis, its angle a
// and the angle b of the bird. The bird's centre is at l_M (cos a, sin a) + l_G (cos b, sin b) from
// the sleeve's centre. Contacts with the pole: the beak (0) and the sleeve's lower (1) and upper
// (2) corner,
//
//     g₀ = l_M cos a + (l_G − l_S) cos b − h_S sin b − r_beak
//     g₁,₂ = r_M cos a ± h_M sin a − r_O
//
// at the heights y + l_M sin a + (l_G − l_S) sin b + h_S cos b and y + r_M sin a ∓ h_M cos a.
// Sliding counts downwards. Newton's restitution 0.5 at the beak, 0 at the sleeve; friction 0.3.
// The published model is linear in a and b.
//
// A stretch ε divides all horizontal and vertical arms by ε and inertias and stiffness by ε², while
// y, the masses and the clearances r_M − r_O and g₀(0, 0) stay. The linear model then has the same
// y, and angles ε times as large; the nonlinear terms vanish with ε.
// Source: Glocker, PhD thesis, TU München 1995; Leine, van Campen and Glocker, J. Vib. Control 9
// (2003) 25; the equations are derived here. Parameters and start: Siconos, siconos/siconos,
// Examples/Mechanics/Woodpecker/ (WoodPeckerConsts.h, WoodPecker.cpp). Units: kg, m, rad, s.
#pragma once

#include "verification/references/published/contact_events.hpp"

namespace freeplay::reference {

struct Woodpecker {
  static constexpr std::size_t coordinates = 3, contacts = 3;  ///< beak, lower, upper corner
  using Vector = std::array<Long, 3>;
  bool linear = false;
  Long stretch = 1;
  Long sleeve = 0.0003L, bird = 0.0045L, gravity = 9.81L;
  Long J_M = 5e-9L / (stretch * stretch), J_S = 7e-7L / (stretch * stretch),
       spring = 0.0056L / (stretch * stretch);
  Long r_M = 0.0031L / stretch, h_M = 0.0058L / stretch, l_M = 0.01L / stretch, l_G = 0.015L / stretch,
       h_S = 0.02L / stretch, l_S = 0.0201L / stretch;
  Long r_O = r_M - 0.0006L, r_beak = l_M + l_G - l_S - 0.0024L;
  std::array<Long, 3> restitution{0.5L, 0, 0}, friction{0.3L, 0.3L, 0.3L};

  Long cosine(Long x) const { return linear ? 1 : std::cos(x); }
  Long sine(Long x) const { return linear ? 0 : std::sin(x); }

  std::array<Vector, 3> mass(const Vector& q) const {
    const Long ya = bird * l_M * cosine(q[1]), yb = bird * l_G * cosine(q[2]),
               ab = bird * l_M * l_G * cosine(q[1] - q[2]);
    return {Vector{sleeve + bird, ya, yb}, Vector{ya, J_M + bird * l_M * l_M, ab},
            Vector{yb, ab, J_S + bird * l_G * l_G}};
  }
  Vector force(const Vector& q, const Vector& v) const {
    const Long torque = spring * (q[1] - q[2]), a = bird * l_M, b = bird * l_G;
    const Long turn = bird * l_M * l_G * sine(q[1] - q[2]);
    return {-(sleeve + bird) * gravity + a * sine(q[1]) * v[1] * v[1] + b * sine(q[2]) * v[2] * v[2],
            -torque - a * gravity * cosine(q[1]) - turn * v[2] * v[2],
            torque - b * gravity * cosine(q[2]) + turn * v[1] * v[1]};
  }
  /// A point at (x₁, z₁) in the sleeve's frame plus (x₂, z₂) in the bird's.
  ContactRows<3> contact(std::size_t k, const Vector& q, const Vector& v) const {
    const Long x1 = k == 0 ? l_M : r_M, z1 = k == 0 ? 0 : k == 1 ? -h_M : h_M;
    const Long x2 = k == 0 ? l_G - l_S : 0, z2 = k == 0 ? h_S : 0, pole = k == 0 ? r_beak : r_O;
    if (linear) return {x1 + x2 - z1 * q[1] - z2 * q[2] - pole, {0, -z1, -z2}, {-1, -x1, -x2}, 0, 0};
    const Long ca = std::cos(q[1]), sa = std::sin(q[1]), cb = std::cos(q[2]), sb = std::sin(q[2]);
    const Long X1 = x1 * ca - z1 * sa, Z1 = x1 * sa + z1 * ca, X2 = x2 * cb - z2 * sb, Z2 = x2 * sb + z2 * cb;
    return {X1 + X2 - pole,
            {0, -Z1, -Z2},
            {-1, -X1, -X2},
            -X1 * v[1] * v[1] - X2 * v[2] * v[2],
            Z1 * v[1] * v[1] + Z2 * v[2] * v[2]};
  }
  Long energy(const Vector& q, const Vector& v) const {
    const auto m = mass(q);
    Long kinetic = 0;
    for (std::size_t i = 0; i < 3; ++i) kinetic += v[i] * product(m[i], v) / 2;
    const Long height = linear ? l_M * q[1] + l_G * q[2] : l_M * std::sin(q[1]) + l_G * std::sin(q[2]);
    return kinetic + (sleeve + bird) * gravity * q[0] + bird * gravity * height +
           spring * (q[1] - q[2]) * (q[1] - q[2]) / 2;
  }
};

/// The published start: the lower corner slides down the pole with 0.3411 m/s. The published angle
/// of the sleeve, −0.1036, is replaced by the one at which the corner is at the pole.
inline ContactEvents<Woodpecker> woodpecker(const Woodpecker& toy) {
  Long a = -0.1034L * toy.stretch;
  for (int i = 0; i < 60; ++i) {
    const auto rows = toy.contact(1, {0, a, 0}, {});
    a -= rows.gap / rows.n[1];
  }
  return {toy, {0, a, -0.2788L * toy.stretch}, {-0.3411L, 0, -7.4583L * toy.stretch}, 1e-4L};
}

/// Woodpecker.ref (siconos-tutorials, commit d73f845), time stepping with 2e-5 s: height of the
/// sleeve and angular velocity of the bird at 0.29998 s.
inline constexpr double published_height = -4.134818676833654e-02;  // m
inline constexpr double published_bird_rate = -8.327555353239312;   // rad/s

}  // namespace freeplay::reference
