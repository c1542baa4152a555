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
#include "mechanism/static_friction.hpp"
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
//     |f| ≤ μ(|u|) S(λ),     μ(s) = μ + (μ_s − μ) exp(−(s/v_S)ⁿ)   (Stribeck; else constant)
//
//     fixed           S = 1 in the directions that have friction; μ and μ_s are the bounds themselves
//     revolute        S = √(λ_1² + λ_2²)          f along the pin's surface, u = r (ω_j − ω_i):
//                                                 a couple r f
//     translational   S = |N|                     N = λ_1 across the guide, f along it, u = a·ḋ
//     with a length L S = |N_1| + |N_2| = max(|N|, 2|M|/L)
//
//     mesh of teeth   S = c |λ_1|      u of the first wheel at its base circle; c = c₁ where it drives,
//                                      c₂ where it is driven (mechanism/mesh_loss.hpp)
//
// The ends of the slider, at ±L/2 along the axis, share N and the guide's couple M = λ_2:
// N_1 + N_2 = N and (N_2 − N_1) L/2 = M. S is a norm (a seminorm if the couple is neglected), so
// |S(a) − S(b)| ≤ S(a − b); of a mesh, S is sublinear, and the greater of c₁ and c₂ counts. This
// property decides whether the friction is unique (formulations/contact/coupled_friction.hpp). In
// time steps λ are impulses, and the bound is one of an impulse; a fixed bound is multiplied by the
// duration, and gives no impulse to an impact.
// μ(s) is that of mechanism/static_friction.hpp; for a fixed bound its members are forces.

struct ReactionBound : StribeckCurve {
  enum class Of { fixed, pin, guide, mesh };
  using Reactions = std::array<double, 2>;

  Of of = Of::guide;
  int row = -1;      ///< first of the joint's constraint rows; −1: the bound reads none
  int element = -1;  ///< index of the joint in Mechanism::joints
  /// 1/m, 2/L of a translational joint with a slider length; 0: the couple is neglected
  double couple = 0;
  /// Of::fixed: S for forces in the positive and in the negative direction. Of::mesh: c where λ_1 has
  /// the direction of the force, and where it has the opposite one.
  std::array<double, 2> ways{1, 1};

  /// A bound of this force (N) in both directions.
  static ReactionBound fixed(double force) {
    ReactionBound bound;
    bound.of = Of::fixed;
    bound.friction = force;
    return bound;
  }

  bool reads_reactions() const { return of != Of::fixed; }
  /// Whether S depends on λ_2.
  bool reads_second() const { return of == Of::pin || (of == Of::guide && couple > 0); }
  /// Whether S depends on the direction of the force.
  bool directed() const { return (of == Of::fixed || of == Of::mesh) && ways[0] != ways[1]; }
  /// λ_1 and λ_2 of the multipliers of all rows; 0 where S does not depend on them.
  Reactions reactions(const double* lambda) const {
    if (of == Of::fixed) return {};
    return {lambda[row], reads_second() ? lambda[row + 1] : 0};
  }
  /// S, for a friction force in the direction of the sign of `side`. `duration` (s): that of the step
  /// whose impulses λ are; 1 if they are forces.
  double support(const Reactions& l, double side, double duration = 1) const {
    switch (of) {
      case Of::fixed:
        return ways[side < 0 ? 1 : 0] * duration;
      case Of::pin:
        return std::hypot(l[0], l[1]);
      case Of::mesh:
        return share(l, side) * std::abs(l[0]);
      case Of::guide:
        break;
    }
    return std::max(std::abs(l[0]), couple * std::abs(l[1]));
  }
  /// The greatest |S(l + d) − S(l)| for any l and direction.
  double change(const Reactions& d) const {
    if (of == Of::fixed) return 0;
    return directed() ? std::max(support(d, 1), support(d, -1)) : support(d, 1);
  }
  /// ∂S/∂(λ_1, λ_2); at a kink of S, the derivative of one side.
  Reactions slope(const Reactions& l, double side) const {
    switch (of) {
      case Of::fixed:
        return {};
      case Of::pin: {
        const double S = std::hypot(l[0], l[1]);
        return S > 0 ? Reactions{l[0] / S, l[1] / S} : Reactions{};
      }
      case Of::mesh:
        return {std::copysign(share(l, side), l[0]), 0};
      case Of::guide:
        break;
    }
    if (couple * std::abs(l[1]) > std::abs(l[0])) return {0, std::copysign(couple, l[1])};
    return {std::copysign(1.0, l[0]), 0};
  }

 private:
  /// c of Of::mesh
  double share(const Reactions& l, double side) const { return ways[(l[0] < 0) == (side < 0) ? 0 : 1]; }
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
  bool out_of_round = false;                      ///< a ring of which a surface has a profile
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
  /// empty: the same bound in both directions and at all speeds
  std::optional<ReactionBound> reaction = {};

  bool of_mesh() const { return reaction && reaction->of == ReactionBound::Of::mesh; }
  /// The path of a key of its element in the scene.
  std::string path(const std::string& key) const {
    return (of_mesh() ? "joints." : "loads.") + name + "." + key;
  }
  /// The bound (N) of a force with the sign of `side`, at the sliding speed u (m/s) and the
  /// multipliers λ of all constraint rows (N).
  double limit(double u, const double* lambda, double side) const {
    return reaction->coefficient(u) * reaction->support(reaction->reactions(lambda), side);
  }
};

}  // namespace freeplay
