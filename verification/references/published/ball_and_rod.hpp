// A ball of mass m at the speed v strikes a free rod (mass M, inertia J about its centre) at rest,
// at right angles and at the distance s from the rod's centre. Without friction the impulse P acts
// along the normal, through the ball's centre. With the effective mass μ and the restitution e,
//
//     1/μ = 1/m + 1/M + s²/J,     P = (1 + e) μ v,
//
// and afterwards, positive along v and turning the struck side along v,
//
//     ball  v − P/m,     rod  P/M,     ω = s P/J,     loss  ½ (1 − e²) μ v² .
//
// The point of the rod at the distance J/(M s) beyond the centre has no velocity: struck at its
// centre of percussion, s = L/6 for a slender rod, the rod starts to turn about its other end. A
// rigid impact has no duration; during a contact of the time T the rod turns by about ω T/2.
//
// Source: Newton and Euler by hand; E. J. Routh, Dynamics of a System of Rigid Bodies, Elementary
// Part (1905), on impulsive forces and the centre of percussion. Units: kg, m, s.
#pragma once

namespace freeplay::reference {

struct BallAndRod {
  double ball, rod, inertia, offset, speed, restitution;
  double effective_mass() const { return 1 / (1 / ball + 1 / rod + offset * offset / inertia); }
  double impulse() const { return (1 + restitution) * effective_mass() * speed; }
  double ball_speed() const { return speed - impulse() / ball; }
  double rod_speed() const { return impulse() / rod; }
  double spin() const { return offset * impulse() / inertia; }
  double loss() const { return 0.5 * (1 - restitution * restitution) * effective_mass() * speed * speed; }
};

/// Distance of the strike from the centre of a slender rod at which its other end has no velocity.
inline double slender_rod_percussion(double length) { return length / 6; }

}  // namespace freeplay::reference
