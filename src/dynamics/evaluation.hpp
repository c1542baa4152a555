// What formulations see of a contact and of a preloaded joint: facts, and rows at one state.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "dynamics/reaction_bound.hpp"
#include "mechanism/body.hpp"
#include "mechanism/surface.hpp"
#include "numerics/sparse.hpp"

namespace freeplay {

/// A contact pair as the formulations see it.
struct ContactFacts {
  std::string name;                           ///< of the joint
  std::array<int, 2> bodies{ground, ground};  ///< bearing's and journal's
  double clearance =
      0;  ///< m: the length that gaps are resolved by; that of a joint, or a scale (has_clearance)
  bool has_clearance = false;  ///< a loose joint's; walls and discs have none
  /// m: what a greatest penetration is told over: the clearance where there is one, else the radius of
  /// curvature, of a point the longest arm; 0: nothing to compare with.
  double measure() const { return has_clearance ? clearance : radius > 0 ? radius : arm; }
  double arm = 0;  ///< m, longest of the mechanism, of a contact without clearance
  /// m, of curvature at the contact; 0: a sharp corner. Inside a ring and outside discs R_i R_j/|R_i ∓ R_j|.
  double radius = 0;
  bool ring = false;                              ///< a journal inside a bearing
  double radius_bearing = 0, radius_journal = 0;  ///< m, of a ring
  std::optional<double> stiffness;                ///< N/m, where it is stated; else of the curvature
  Surface surface;
  std::optional<double> bearing_length;  ///< m
  std::optional<Lubricant> lubricant;
};

/// A contact's geometry at one state. Without friction the tangent row stays empty. T is double, or Gradient
/// for derivatives.
template <class T>
struct ContactRowOf {
  T gap = 0;                       ///< m
  SparseRowOf<T> normal, tangent;  ///< ġ = normal·v, v_T = tangent·v
  /// Only for a lubricated joint: film·v = t·ė − ½(ω_i + ω_j)|e|, the journal's sideways motion relative to
  /// the mean surface, along which the film's tangential force acts (its couples included);
  /// spin·v = ω_j − ω_i.
  SparseRowOf<T> film, spin;
  T gamma_n = 0, gamma_t = 0;  ///< g̈ = normal·a − gamma_n, v̇_T = tangent·a − gamma_t
  T gamma_film = 0, turn = 0;  ///< of a film: likewise, and how fast its normal turns (rad/s)
  template <class M>
  void remember(M& m) {
    m(gap, normal, tangent, film, spin, gamma_n, gamma_t, gamma_film, turn);
  }
};
using ContactRow = ContactRowOf<double>;

/// Coulomb friction of an ideal joint as the formulations see it: of a fixed bound (preloaded), or of one from the
/// joint's reaction.
struct FrictionFacts {
  std::string name;
  double bound = 0;                      ///< N, without `reaction`
  std::optional<double> regularisation;  ///< m/s
  std::optional<ReactionBound> reaction = {};

  /// At the sliding speed u (m/s) and multipliers λ of all constraint rows; of an impulse, where λ are.
  double limit(double u, const double* lambda) const {
    return reaction->coefficient(u) * reaction->support(lambda);
  }
};

}  // namespace freeplay
