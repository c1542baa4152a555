// Wear of a bearing by a rigid journal under Archard's law, and the load of an elastic foundation.
//
// Worn area of the cross-section after the sliding distance s under the force F, with the length L of the bearing
// and the coefficient k = depth/(pressure × sliding):
//
//     A = k F s/L
//
// Constant direction: the worn place has the form of the journal, a circle of radius r whose centre is x = c + h from
// that of the bore of radius R = r + c, h the depth. Its area is that of the lune outside the bore,
//
//     A = π r² − r² (α − ½ sin 2α) − R² (β − ½ sin 2β)
//     cos α = (x² + r² − R²)/(2 x r),   cos β = (x² + R² − r²)/(2 x R)
//
// with the two-circle intersection by its segments. β is the half angle of the worn place, seen from the centre of the
// bore; α − β that of the circles at its edge. Near h = 0 the terms cancel; A = ∫ 2 r sin α(h) dh has none, since the
// lune advances along its chord:
//
//     dA/dh = 2 r sin α,    sin α = √((2x r)² − (x² + r² − R²)²)/(2x r),  the root being (h)(2c + h)(2r + h + 2c)(2r − h)
//
// Load that rotates with the journal, against the bearing (or with the bearing, against the journal): even wear,
//
//     A = π ((R + h)² − R²)    or    π (r² − (r − h)²)
//
// Elastic foundation: the journal at x = c + δ presses p = K ⟨x cos φ + √(r² − x² sin² φ) − R⟩ on the bore,
//
//     F = K L R ∫ p/K cos φ dφ
//
// by Gauss's rule with five points in equal parts of the arc −β to β. Sign convention: h, δ > 0 into the bearing.
// Units: m, N, Pa/m, m²/N, rad.
// Source: J. F. Archard, J. Appl. Phys. 24 (1953) 981; P. Põdra, S. Andersson, Wear 207 (1997) 79; geometry by hand.
#pragma once

#include <array>
#include <cmath>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

/// A round bore and a round journal.
struct BoreAndJournal {
  double bore = 0;       ///< m, R
  double clearance = 0;  ///< m, c
  double length = 0;     ///< m, L
  double journal() const { return bore - clearance; }
};

/// ∫ f over an interval by Gauss's rule with five points in equal parts.
template <class Function>
double gauss(const Function& f, double from, double to, int parts = 64) {
  constexpr std::array<double, 3> place{0, 0.5384693101056831, 0.9061798459386640},
      weight{0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  double sum = 0;
  const double half = 0.5 * (to - from) / parts;
  for (int i = 0; i < parts; ++i) {
    const double middle = from + (2 * i + 1) * half;
    sum += weight[0] * f(middle);
    for (const std::size_t k : {1, 2})
      sum += weight[k] * (f(middle - place[k] * half) + f(middle + place[k] * half));
  }
  return half * sum;
}

/// Area (m²) of the lune by segments of circles; rounding: 1e-16 r².
inline double lune_area(const BoreAndJournal& b, double depth) {
  const double R = b.bore, r = b.journal(), x = b.clearance + depth;
  const double alpha = std::acos((x * x + r * r - R * R) / (2 * x * r)),
               beta = std::acos((x * x + R * R - r * r) / (2 * x * R));
  return 3.141592653589793 * r * r - r * r * (alpha - 0.5 * std::sin(2 * alpha)) -
         R * R * (beta - 0.5 * std::sin(2 * beta));
}

/// The same as the integral of its chord, without cancellation.
inline double lune_area_by_chord(const BoreAndJournal& b, double depth) {
  const double c = b.clearance, r = b.journal();
  // With h = depth u² the integrand is smooth: the chord grows as √h.
  return gauss(
      [&](double u) {
        const double h = depth * u * u, x = c + h;
        return std::sqrt(h * (2 * c + h) * (2 * r + 2 * c + h) * (2 * r - h)) / x * 2 * depth * u;
      },
      0, 1);
}

/// Depth (m) of the lune of this area.
inline double lune_depth(const BoreAndJournal& b, double area) {
  double low = 0, high = b.journal();
  bisect(low, high, 200, [&](double h) { return lune_area_by_chord(b, h) < area; });
  return 0.5 * (low + high);
}

/// Half angle (rad) of the lune, from the centre of the bore.
inline double lune_half_angle(const BoreAndJournal& b, double depth) {
  const double c = b.clearance, h = depth, R = b.bore, r = b.journal(), x = c + h;
  return std::atan2(std::sqrt(h * (2 * c + h) * (2 * r + 2 * c + h) * (2 * r - h)),
                    x * x + (R - r) * (R + r));
}

/// Sliding distance (m) to a worn area by Archard's law.
inline double sliding_to(const BoreAndJournal& b, double area, double force, double coefficient) {
  return area * b.length / (coefficient * force);
}

/// Depth (m) of even wear of this area on the outside of a radius (bearing, side 1) or its inside (journal, −1).
inline double even_depth(double radius, double area, double side) {
  const double more = area / (3.141592653589793 * radius * radius);
  return radius * more / (1 + std::sqrt(1 + side * more));
}

/// Load (N) at the penetration `depth` (m) of round surfaces on a foundation of stiffness K (Pa/m).
inline double foundation_load(const BoreAndJournal& b, double stiffness, double depth) {
  const double R = b.bore, r = b.journal(), x = b.clearance + depth, edge = lune_half_angle(b, depth);
  return stiffness * b.length * R *
         gauss(
             [&](double phi) {
               const double s = std::sin(phi), half = std::sin(0.5 * phi);
               // x cos φ + √(r² − x² s²) − R, with δ = x + r − R taken out.
               const double root = std::sqrt(r * r - x * x * s * s);
               return (depth - 2 * x * half * half - x * x * s * s / (root + r)) * std::cos(phi);
             },
             -edge, edge);
}

}  // namespace freeplay::reference
