// Interface of contacts and joint friction to the formulations: names, constant facts, bounds of
// friction, and rows at one state.
//
// For contact k with velocities v and accelerations a,
//
//     ġ = normal·v,     g̈ = normal·a − gamma_n        a normal force F_N ≥ 0 acts as normal·F_N
//     v_T = tangent·v,  v̇_T = tangent·a − gamma_t     a friction force F_T acts as tangent·F_T
//
// System::contact_facts() gives the facts, System::contact() fills a ContactRow. Both are plain
// values.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "mechanism/body.hpp"
#include "mechanism/surface.hpp"
#include "numerics/sparse.hpp"

namespace freeplay {

// Names of a mechanism's contacts, for code that needs no System.

struct Mechanism;

/// The names, including those of joints with clearance, in the order of ContactEvent::contact.
std::vector<std::string> contact_names(const Mechanism& mechanism);

// Bound of the friction in an ideal joint from the joint's own reaction λ = (λ_1, λ_2), the
// multipliers of its rows:
//
//     |f| ≤ μ(|u|) S(λ),     μ(s) = μ + (μ_s − μ) exp(−(s/v_S)²)   (Stribeck; else constant)
//
//     revolute        S = √(λ_1² + λ_2²)          f along the pin's surface, u = r (ω_j − ω_i):
//                                                 a couple r f
//     translational   S = |N|                     N = λ_1 across the guide, f along it, u = a·ḋ
//     with a length L S = |N_1| + |N_2| = max(|N|, 2|M|/L)
//
// The ends of the slider, at ±L/2 along the axis, share N and the guide's couple M = λ_2:
// N_1 + N_2 = N and (N_2 − N_1) L/2 = M. S is a norm (a seminorm if the couple is neglected), so
// |S(a) − S(b)| ≤ S(a − b). This property decides whether the friction is unique
// (formulations/contact/coupled_friction.hpp). In time steps λ are impulses, and the bound is one
// of an impulse. Source of μ(s) with exponent 2: B. Armstrong-Hélouvry, P. Dupont, C. Canudas de
// Wit, Automatica 30 (1994) 1083.

struct ReactionBound {
  int row = -1;      ///< first of the joint's two constraint rows
  int element = -1;  ///< index of the joint in Mechanism::joints
  bool pin = false;  ///< whether the joint is revolute
  /// 1/m, 2/L of a translational joint with a slider length; 0: the couple is neglected
  double couple = 0;
  double friction = 0;  ///< μ of sliding
  double more = 0;      ///< μ_s − μ, ≥ 0
  double stribeck = 1;  ///< m/s, v_S

  double support(double a, double b) const {
    return pin ? std::hypot(a, b) : std::max(std::abs(a), couple * std::abs(b));
  }
  double support(const double* lambda) const { return support(lambda[row], lambda[row + 1]); }
  /// ∂S/∂(λ_1, λ_2); at a kink of S, the derivative of one side.
  std::array<double, 2> slope(double a, double b) const {
    if (pin) {
      const double S = std::hypot(a, b);
      return S > 0 ? std::array{a / S, b / S} : std::array{0.0, 0.0};
    }
    if (couple * std::abs(b) > std::abs(a)) return {0, std::copysign(couple, b)};
    return {std::copysign(1.0, a), 0};
  }
  /// μ(|u|)
  template <class T>
  T coefficient(const T& u) const {
    if (more == 0) return T(friction);
    using std::exp;
    const T x = u / stribeck;
    return friction + more * exp(-x * x);
  }
};

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

/// Geometry of a contact at one state. Without friction the tangent row is empty.
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
