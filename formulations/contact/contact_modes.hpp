// Existence and uniqueness of the solution of a contact problem, by enumeration of all consistent
// modes. With friction, a problem can have several motions or none (Painlevé) where a pressed
// contact has D_NN ≤ μ|D_NT|. find_modes() enumerates one problem, doubtful_motions() the islands
// of a problem in which this condition is met.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "formulations/contact/contact_equations.hpp"

namespace freeplay {

constexpr int most_for_modes = 8;  // 4⁸ cases at most

/// One consistent mode.
struct ContactMode {
  enum class Way { open, stick, right, left };  ///< right: it slides with u_T > 0
  /// of each unknown; stick for a frictionless contact that is pressed
  std::vector<Way> ways;
  Eigen::VectorXd impulses, rates;  ///< of each row; one of several possible choices of impulses
};

/// Result of the enumeration: one mode for each motion.
struct ContactModes {
  bool decided = false;  ///< false: too many contacts or modes, nothing was tried
  long tried = 0;
  std::vector<ContactMode> motions;
};

/// Number of modes to try.
long number_of_modes(const ContactEquations& problem);
/// Finds all consistent modes of up to most_for_modes unknowns, one for each motion, up to `most`
/// of them; tries no more than `left` modes. Motions differ in the rates of their rows, because
/// shared contact forces are never unique. The force of each contact is sought in the cone of its
/// mode by nonnegative least squares, so that shared forces are found wherever they exist.
ContactModes find_modes(const ContactEquations& problem, int most, long left);
/// Finds the modes of each island (unknowns coupled by D) that has a pressed contact with D_NN ≤
/// μ|D_NT|; `members` gets the unknowns of each island.
std::vector<ContactModes> doubtful_motions(const ContactEquations& problem, long left,
                                           std::vector<std::vector<int>>& members);

/// Describes the motions of these islands, for example "tip: open, or sliding to the right with 12
/// N". `name` returns the name of an unknown; `unit` is the unit of its impulses.
std::string describe_motions(const ContactEquations& problem, const std::function<std::string(int)>& name,
                             const char* unit = "N");

/// The note for `count` problems whose uniqueness was not decided.
std::string undecided_note(long count);

}  // namespace freeplay
