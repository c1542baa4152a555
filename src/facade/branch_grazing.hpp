// The branch of motions with a new impact, where a motion begins to touch a contact.
//
// Near the motion that just touches, with the local coordinates u and the key ξ relative to it, an impact of
// approach speed v has v² = κ_u·u + κ_ξ ξ to first order, and the map is
//
//     P = A u + b ξ + c v
//
// (Nordmark, J. Sound Vib. 145 (1991) 279). Periodic motions with this impact are therefore, per unit of v,
//
//     (1 − A) u − b ξ = c,     κ_u·u + κ_ξ ξ = 0.
//
// A and b are those of the motion without the impact; κ and c follow from runs beside it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "facade/branch_solver.hpp"

namespace freeplay {

/// A contact that a motion begins to touch.
struct NewContact {
  std::size_t onset = 0;  ///< index of its onset among those of the motions that touch it
  int contact = 0;
  double speed = 0;  ///< m/s, of approach, at the motion at which it was found
};
/// The contact that the branch touches within `distance` after a motion; nullopt if the order of onsets does
/// not change there by one slow onset.
std::optional<NewContact> new_contact_ahead(const BranchSolver& solver, const BranchMotion& m,
                                            double distance);

/// The first motion with this impact beside a motion that just touches, with the tangent away from it.
std::optional<BranchMotion> first_with_impact(const BranchSolver& solver, const BranchMotion& m,
                                              const NewContact& grazed, std::string& reason);

}  // namespace freeplay
