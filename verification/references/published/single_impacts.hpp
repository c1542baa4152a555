// Tests 1 to 4 of Chung and Ooi for the impact of spheres, with their materials and closed forms.
//
// Tests 1 and 2, elastic normal impact: Hertz, F = K δ^{3/2} with K = 4/3 E* √R,
//
//     two equal spheres of radius r:      R = r/2,   E* = E/(2(1 − ν²)),   effective mass m/2
//     a sphere and a rigid plane:         R = r,     E* = E/(1 − ν²),      effective mass m
//
// and elastic_impact() of hertz_impact.hpp. Test 3: the rebound is e times the approach speed.
// Test 4, oblique impact of a sphere without spin at the speed V and the angle θ from the normal.
// With the normal impulse (1 + e) m V cos θ, the moment of inertia 2/5 m r² and the sliding speed
// u = v − r ω of the contact point (ω positive if it rolls along), gross sliding gives
//
//     v′ = v − μ (1 + e) V cos θ,  r ω′ = 5/2 μ (1 + e) V cos θ,  u′ = v − 7/2 μ (1 + e) V cos θ
//
// as long as u′ > 0, that is tan θ > 7/2 μ (1 + e). A rigid contact sticks below that angle:
// v′ = r ω′ = 5/7 v. The published theory of this range has tangential compliance (Maw, Barber and
// Fawcett 1976).
//
// Source: Y. C. Chung, J. Y. Ooi, Benchmark tests for verifying discrete element modelling codes at
// particle impact level, Granular Matter 13 (2011) 643–656; parameters as reproduced by the
// benchmarks of Yade (V. Angelidakis, B. Chareyre, R. Caulk 2023) and Kratos (tests
// DEM3D_chung_ooi_tests of its DEMApplication), which also digitised the figures of the paper.
// Units: m, kg, s.
#pragma once

#include <cmath>

#include "verification/references/hertz_impact.hpp"

namespace freeplay::reference {

/// A sphere and the speed of its test.
struct ChungOoiSphere {
  double young, poisson, density, radius, speed;
  double mass() const { return 4.0 / 3 * 3.14159265358979323846 * density * radius * radius * radius; }
  double inertia() const { return 0.4 * mass() * radius * radius; }
  double plane_strain_modulus() const { return young / (1 - poisson * poisson); }

  /// `speed` is that of each sphere.
  double pair_stiffness() const { return 4.0 / 3 * plane_strain_modulus() / 2 * std::sqrt(radius / 2); }
  ElasticImpact pair_impact() const { return elastic_impact(pair_stiffness(), mass() / 2, 2 * speed); }
  double plane_stiffness() const { return 4.0 / 3 * plane_strain_modulus() * std::sqrt(radius); }
  ElasticImpact plane_impact() const { return elastic_impact(plane_stiffness(), mass(), speed); }
};

inline constexpr ChungOoiSphere chung_ooi_glass{4.8e10, 0.20, 2800, 0.01, 10},
    chung_ooi_limestone{2e10, 0.25, 2500, 0.01, 10}, chung_ooi_aluminium{7e10, 0.30, 2699, 0.1, 0.2},
    chung_ooi_magnesium{4e10, 0.35, 1800, 0.1, 0.2}, chung_ooi_oxide{3.8e11, 0.23, 4000, 0.0025, 3.9};

/// Points of the paper's figures as digitised by Kratos (benchmark1_graph1, benchmark1_graph2,
/// benchmark2_graph1, benchmark2_graph2): the greatest force (kN), the end of the contact (µs), and
/// a point of force (kN) against overlap (µm) near the end of the curve.
struct ChungOoiReading {
  double force, duration, overlap, force_at_overlap;
};
inline constexpr ChungOoiReading chung_ooi_1_read{10.7039, 40.4785, 265.238, 10.17636},
    chung_ooi_2_read{11.3572, 727.5, 44.982, 9.68539};

/// Result of test 4.
struct ChungOoiRebound {
  double tangential_restitution;  ///< v′/v of the centre
  double spin;                    ///< rad/s, positive if it rolls along
  double angle;                   ///< degrees, of the contact point's velocity from the normal
  bool slides;                    ///< whether it slides throughout
};
inline constexpr double chung_ooi_restitution = 0.98, chung_ooi_friction = 0.092;
inline ChungOoiRebound chung_ooi_rebound(double degrees) {
  const double degree = 3.14159265358979323846 / 180, V = chung_ooi_oxide.speed, r = chung_ooi_oxide.radius;
  const double n = V * std::cos(degrees * degree), v = V * std::sin(degrees * degree);
  const double reduced = chung_ooi_friction * (1 + chung_ooi_restitution) * n, slide = v - 3.5 * reduced;
  if (slide <= 0) return {5.0 / 7, 5.0 / 7 * v / r, 0, false};
  return {1 - reduced / v, 2.5 * reduced / r, std::atan2(slide, chung_ooi_restitution * n) / degree, true};
}

/// Points of the paper's figures of test 4 in gross sliding, as digitised by Kratos
/// (benchmark4_graph1_ref, benchmark4_graph2_ref, benchmark4_graph3_ref); each at its own angle.
struct ChungOoiPoint {
  double at, value;  ///< degrees
};
struct ChungOoiPoints {
  ChungOoiPoint restitution, spin, angle;
};
inline constexpr ChungOoiPoints chung_ooi_4_read[] = {
    {{40.0198, 0.780890}, {39.9803, 544.801}, {39.9197, 11.5710}},
    {{50, 0.845140}, {50, 457.034}, {49.8336, 29.3505}},
    {{59.9802, 0.892916}, {60.0197, 357.492}, {59.9871, 47.7946}},
    {{69.9604, 0.931631}, {69.9606, 246.177}, {69.7422, 64.5770}},
    {{80.0198, 0.966227}, {80.0592, 126.300}, {79.8218, 78.7009}}};

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
