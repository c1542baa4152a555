// Existence and uniqueness of a contact problem's solution: all consistent modes, tried one by one. With friction a problem may have
// several motions or none (Painlevé), where some pressed contact has D_NN ≤ μ|D_NT|.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "formulations/contact/contact_equations.hpp"

namespace freeplay {

constexpr int most_for_modes = 8;  // 4⁸ cases, when they are needed

/// One consistent mode.
struct ContactMode {
  enum class Way { open, stick, right, left };  ///< right: it slides with u_T > 0
  std::vector<Way> ways;                        ///< of each unknown; a frictionless one that presses: stick
  Eigen::VectorXd impulses, rates;              ///< of each row; of several choices of impulses one
};

/// What trying all modes of a problem found: of each motion one mode.
struct ContactModes {
  bool decided = false;  ///< false: too many contacts or modes, nothing was tried
  long tried = 0;
  std::vector<ContactMode> motions;
};

/// How many modes there are to try.
long number_of_modes(const ContactEquations& problem);
/// All consistent modes of up to most_for_modes unknowns, one for each motion (rates of the rows; forces that
/// contacts share are never unique), up to `most` of them; no more than `left` are tried. A contact's force is looked for in
/// the cone of its mode by nonnegative least squares, so that shared forces are found wherever there are some.
ContactModes find_modes(const ContactEquations& problem, int most, long left);
/// Of each island (unknowns coupled by D) with a doubtful contact its modes, and its unknowns in `members`.
std::vector<ContactModes> doubtful_motions(const ContactEquations& problem, long left,
                                           std::vector<std::vector<int>>& members);

/// The motions of the doubtful islands of a problem in words: "tip: open, or sliding to the right with 12 N".
/// `name`: of an unknown; `unit`: of its impulses.
std::string describe_motions(const ContactEquations& problem, const std::function<std::string(int)>& name,
                             const char* unit = "N");

/// The note of `count` problems whose uniqueness was not decided.
std::string undecided_note(long count);

}  // namespace freeplay
