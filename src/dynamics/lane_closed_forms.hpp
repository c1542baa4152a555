// Impulses of an ordinary step in a lane (lane_functions.hpp), recorded with Traced numbers: a contact, a
// joint friction, or both. The operations are those of formulations/contact/ (solvers.cpp,
// solvers.cpp and contact_residual()).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "numerics/traced.hpp"

namespace freeplay {

/// @name Short forms
///@{
inline Traced less(const Traced& a, const Traced& b) { return holds(a, Relation::less, b); }
inline Traced at_most(const Traced& a, const Traced& b) { return holds(a, Relation::less_equal, b); }
/// std::min(a, b)
inline Traced least(const Traced& a, const Traced& b) { return select(less(b, a), b, a); }
/// x − x: NaN for an infinite or undefined x.
inline Traced zero_if_finite(const Traced& x) {
  const Traced& same = x;
  return x - same;
}
///@}

/// The impulses, and what the step requires of them.
struct LaneImpulses {
  Traced normal, tangent, slide;  ///< N s; of the contact, and of the joint friction
  Traced residual, residual_rate;
  std::vector<Traced> conditions;
};

/// ContactProblem::solve() of a contact with friction, where it is pressed and regular. D: D_NN, D_NT, D_TT.
LaneImpulses with_friction(const std::array<Traced, 3>& D, const Traced& bn0, const Traced& bt,
                           const Traced& target, const Traced& friction, const Traced& tolerance);
/// The same without friction.
LaneImpulses frictionless(const Traced& nn, const Traced& bn0, const Traced& target, const Traced& tolerance);
/// A joint friction alone.
LaneImpulses sliding(const Traced& D, const Traced& b, const Traced& bound, const Traced& tolerance);

/// Entries of D and b by the contact's normal and tangent and by the joint.
struct LaneMode {
  Traced nn, nt, tt, ns, ts, ss, bn, bt, bs;
  std::optional<Traced> friction;  ///< of the contact
  Traced target;                   ///< m/s, of the contact
  Traced bound;                    ///< N s, of the joint friction
  Traced last_n, last_t, last_s;   ///< N s, in the last step
};
/// A contact and a joint friction in the mode of their last impulses: the contact is pressed and slides, or
/// has no friction, and the joint slides. enumeration() tries this mode first.
LaneImpulses with_slide(const LaneMode& m, const Traced& tolerance);

}  // namespace freeplay
