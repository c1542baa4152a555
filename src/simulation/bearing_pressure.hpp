// Pressure between a journal and its bearing on an elastic foundation (Winkler), over the angle of the
// bearing.
//
// In the direction e(φ) from the bearing's centre, in the axes of the bearing's body, a round journal with
// its centre at x penetrates the bearing by
//
//     δ(φ) = x·e + √(ρ_j² − (x × e)²) − ρ_b,    ρ_b = R_b + d_b(φ),    ρ_j = R_j + d_j(φ_j)
//
// with the deviations d_b and d_j of the polar radii and the angle φ_j = φ + (x × e)/R_j − (θ_j − θ_i) of the
// touching place on the journal. A journal that is not round is exact to first order in d_j/R_j. The pressure
// and its resultant are
//
//     p = ⟨δ⟩/(1/K + s),    F = L R_b ∫ p e dφ
//
// K is that of an elastic layer, (1 − ν) E_l/[(1 + ν)(1 − 2ν) t] in plane strain (P. Põdra, S. Andersson,
// Wear 207 (1997) 79; S. Mukras et al., Wear 268 (2010) 643), or that of the foundation on which the
// contact of round surfaces under this load is as wide as Hertz's (K. L. Johnson, Contact Mechanics, 1985,
// section 4.3),
//
//     K = (3π/8) E*/a,    a² = 4 F R_b R_j/(π E* L c),    E* = E/[2(1 − ν²)]
//
// solve() finds x for a given F by Newton's method with step halving: F is the gradient of a convex energy,
// up to terms in c/R. The deviations are interpolated by cubics (Catmull and Rom), and δ between two angles
// by the parabola through three points, so that contacts narrower than a step are resolved.
//
// For a round journal and bearing, and for c ≪ R, p = K ⟨(c + δ) cos φ − c⟩ has the resultant, its slope and
// energy of RoundFoundation in closed form; the contact law "elastic-foundation" is that resultant.
#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <vector>

#include "values/vec2.hpp"

namespace freeplay {

struct Mechanism;
struct RevoluteJoint;
struct Surface;
class Roundness;

/// The elastic foundation between a journal and its bearing.
struct Foundation {
  double bearing_radius = 0;  ///< m, R_b
  double clearance = 0;       ///< m, c = R_b − R_j
  double length = 0;          ///< m, L
  double stiffness = 0;       ///< Pa/m, K of a layer; 0: matched to Hertz's width
  double modulus = 0;         ///< Pa, E*; read where K is matched

  /// m, R_j
  double journal_radius() const { return bearing_radius - clearance; }
  /// a (m), Hertz's half width at a load (N, > 0).
  double half_width(double force) const;
  /// K (Pa/m) at a load (N, > 0).
  double at(double force) const;
};

/// K (Pa/m) of the layer of a surface; 0: it has none.
double layer_stiffness(const Surface& surface);
/// The foundation of a joint with clearance. Throws ModelError that names a missing key.
Foundation foundation_of(const Mechanism& mechanism, const RevoluteJoint& joint);

/// Resultant of p = K ⟨(c + δ) cos φ − c⟩ of round surfaces, for K L R_b = 1 and c = 1; δ ≥ 0 in units of c.
/// With cos α = 1/(1 + δ),
///
///     F = (1 + δ)(α + sin α cos α) − 2 sin α,    dF/dδ = α + sin α cos α
///     ∫ F dδ = ½ [(1 + δ)² (α + sin α cos α) − 4 (1 + δ) sin α + 2α]
///
/// Power series in tan α replace F and its integral where their terms cancel. F → (2/3) (2δ)^(3/2) as δ → 0.
struct RoundFoundation {
  static double force(double depth);   ///< F
  static double slope(double depth);   ///< dF/dδ
  static double energy(double depth);  ///< ∫ F dδ
};

/// A distribution of pressure in equilibrium with a load.
struct Pressure {
  Vec2 centre{};  ///< m, x: the journal's centre in the axes of the bearing's body
  /// Pa, at n equal angles from 0: mean over two steps, weighed by the hat function of the angle, so that
  /// their sum is the integral exactly
  std::vector<double> p;
  double total = 0;     ///< N, ∫ p dA = L R_b (2π/n) Σ p
  double greatest = 0;  ///< Pa, greatest p
  /// Whether solve() begins at `centre`, which is that of a similar load.
  bool warm = false;
  /// work space of solve()
  std::vector<double> halves;
  std::vector<Vec2> points, nodes;
};

/// No position of the journal balances the load.
struct NoEquilibrium : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Finds the pressure under a load of `force` (N, > 0) on the bearing in the direction `direction` (rad, in
/// the axes of the bearing's body).
///
/// bearing: d_b (m) at n ≥ 8 equal angles from 0 in the axes of the bearing's body, > 0: larger bearing, as
/// of wear. journal: d_j (m) at n_j equal angles in the axes of the journal's body, < 0: worn; empty:
/// round. turn: θ_j − θ_i (rad). softening: s (m/Pa), for implicit steps of wear. Allocates nothing if
/// `out` was used for the same n before. Throws NoEquilibrium, also if Hertz's contact, to which K is matched,
/// would be wider than half of the circumference.
void solve(const Foundation& foundation, std::span<const double> bearing, std::span<const double> journal,
           double turn, double force, double direction, double softening, Pressure& out);

/// Deviations (m) of the polar radius of a surface of nominal radius `radius` (m) at n equal angles:
/// p − p′²/(2R) of its support function (mechanism/profile.hpp).
std::vector<double> polar_deviations(const Roundness& surface, double radius, std::size_t n);
/// As above, of a profile by its index; empty for none (−1).
std::vector<double> polar_deviations(const Mechanism& mechanism, int profile, double radius, std::size_t n);

}  // namespace freeplay
