// Interface of contacts and joint friction to the formulations: constant facts, and rows at one
// state.
//
// For contact k with velocities v and accelerations a,
//
//     ġ = normal·v,     g̈ = normal·a − gamma_n        a normal force F_N ≥ 0 acts as normal·F_N
//     v_T = tangent·v,  v̇_T = tangent·a − gamma_t     a friction force F_T acts as tangent·F_T
//
// System::contact_facts() gives the facts, System::contact() fills a ContactRow. Both are plain
// values.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "dynamics/reaction_bound.hpp"
#include "mechanism/body.hpp"
#include "mechanism/surface.hpp"
#include "numerics/sparse.hpp"

namespace freeplay {

/// Facts of a contact pair.
struct ContactFacts {
  std::string name;                           ///< name of the joint or of the contact
  std::array<int, 2> bodies{ground, ground};  ///< bearing's and journal's body
  /// m, scale that resolves gaps: the joint's clearance, or another scale (see has_clearance)
  double clearance = 0;
  bool has_clearance = false;  ///< whether a joint with clearance; false for walls and discs
  /// Reference length of penetrations (m): the clearance if there is one, else the radius of
  /// curvature, else (point contact) the longest arm; 0 if there is none.
  double measure() const { return has_clearance ? clearance : radius > 0 ? radius : arm; }
  double arm = 0;  ///< m, longest arm of the mechanism, for a contact without clearance
  /// Radius of curvature at the contact (m), R_i R_j/|R_i ∓ R_j| inside a ring or between discs; 0
  /// for a sharp corner.
  double radius = 0;
  bool ring = false;                              ///< a journal inside a bearing
  double radius_bearing = 0, radius_journal = 0;  ///< m, of a ring
  /// N/m, if stated; else it follows from the curvature
  std::optional<double> stiffness;
  Surface surface;
  std::optional<double> bearing_length;  ///< m
  std::optional<Lubricant> lubricant;
};

/// Geometry of a contact at one state. Without friction the tangent row is empty. T is double, or
/// Gradient for derivatives.
template <class T>
struct ContactRowOf {
  T gap = 0;                       ///< m
  SparseRowOf<T> normal, tangent;  ///< ġ = normal·v, v_T = tangent·v
  /// Lubricated joints only. film·v = t·ė − ½(ω_i + ω_j)|e| is the tangential motion of the journal
  /// relative to the mean surface; the film's tangential force acts along this row, couples
  /// included. spin·v = ω_j − ω_i.
  SparseRowOf<T> film, spin;
  T gamma_n = 0, gamma_t = 0;  ///< g̈ = normal·a − gamma_n, v̇_T = tangent·a − gamma_t
  /// Lubricated joints only: γ of the film row, and rotation rate of the normal (rad/s).
  T gamma_film = 0, turn = 0;
  template <class M>
  void serialize(M& m) {
    m(gap, normal, tangent, film, spin, gamma_n, gamma_t, gamma_film, turn);
  }
};
using ContactRow = ContactRowOf<double>;

/// Coulomb friction of an ideal joint, with a fixed bound (preloaded) or a bound from the joint's
/// reaction.
struct FrictionFacts {
  std::string name;
  double bound = 0;                      ///< N, used if `reaction` is empty
  std::optional<double> regularisation;  ///< m/s
  std::optional<ReactionBound> reaction = {};

  /// The bound (N) at the sliding speed u (m/s) and multipliers λ of all constraint rows; the bound
  /// of an impulse if λ are impulses.
  double limit(double u, const double* lambda) const {
    return reaction->coefficient(u) * reaction->support(lambda);
  }
};

}  // namespace freeplay
