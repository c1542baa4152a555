// The profile (mechanism/profile.hpp) of a worn surface, which the contact of a joint takes.
//
// Wear is a depth over the polar angle; contacts need the support function. The support function of the
// convex hull of a surface with the polar radius R + d(ψ) is
//
//     H(φ) = max over ψ of (R + d(ψ)) cos(ψ − φ),
//
// with d linear between its angles. A worn place has the radius of curvature of the other surface, so w, the
// difference of both radii of curvature (profile.hpp), is about 0 there, and the set C = {d: d·n ≤ h} of
// places of the journal's centre has corners at its ends. The profile is therefore that of a neighbour of C:
// C is made convex, eroded and dilated by a radius ρ (its corners get the radius ρ; elsewhere it is the same),
// and its support function h is smoothed to
//
//     p_k = (h_(k−1) + 4 h_k + h_(k+1))/6,
//
// so that the second derivative of the cubic spline through p at its points is the second difference of h,
// which convexity bounds: w ≥ ρ but for terms of the square of the spacing. The joint thus remains one contact
// with its name. At a corner with the normals n ± α the journal rests higher than in the worn bearing by up to
//
//     ρ (1/cos α − 1).
//
// If both surfaces deviate, each has a share of the clearance in its h, and w is the sum of both. A share that is
// too small makes hollows of the surface shallower: in a lune with the curvature of the other surface, p has a
// share of its depth. Of some shares, those are taken with which the greater change of both surfaces is least, by
// convexity, rounding and smoothing.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "mechanism/profile.hpp"
#include "study/wear/worn_bearing.hpp"

namespace freeplay {

/// ρ as a share of the clearance.
inline constexpr double corner_share = 0.02;

/// Number of directions of the profile of a surface with n angles: even, at most 360.
std::size_t support_points(std::size_t n);

/// H − R (m) at `count` equal angles from 0, of a surface of this nominal radius (m) whose polar radius
/// deviates by d (m) at equal angles from 0.
std::vector<double> support_deviations(std::span<const double> d, double radius, std::size_t count);

/// The support function (m) of the set {d: d·n_k ≤ h_k} of equal angles from 0. h > 0.
std::vector<double> convex_support(const std::vector<double>& h);

/// As convex_support(), with corners rounded by `radius` (m), less than every h.
std::vector<double> rounded_support(const std::vector<double>& h, double radius);

/// The profiles of the surfaces of one joint, through support_points() points.
struct WornProfiles {
  std::optional<Profile> bearing, journal;  ///< absent: round, or nothing of the joint is worn
  double changed = 0;                       ///< m, sum of the greatest changes of both p
};

/// Those with which a joint runs after this wear.
WornProfiles worn_profiles(const WornBearing& worn);

/// Gives a joint of the mechanism these profiles, in place of its own. Changes nothing if nothing is worn.
/// Returns WornProfiles::changed.
double set_worn(Mechanism& mechanism, const WornBearing& worn);

}  // namespace freeplay
