// ModeChoice: the mode after an event, from a complementarity problem in accelerations (Glocker,
// Set-Valued Force Laws, 2001, chapters 3 and 5),
//
//     0 ≤ g̈ ⊥ λ_N ≥ 0,
//     −λ_T ∈ μ λ_N Sgn(u̇_T) if u_T = 0,   λ_T = −s μ λ_N, s = sgn u_T otherwise,
//
// of the contacts that are closed without relative normal speed and of the joints whose friction is
// at rest. Friction bounds that depend on reactions are iterated until they agree with them
// (contact/coupled_friction.hpp); of few contacts and joints all modes are tried (ModeTrials).
#pragma once

#include <string>
#include <vector>

#include "formulations/contact/contact_problem.hpp"
#include "formulations/contact/coupled_friction.hpp"
#include "formulations/event_driven/mode_motion.hpp"

namespace freeplay {

/// ModeTrials: all modes of a few contacts and joints, tried one by one. A mode holds if the motion
/// that it gives (mode_motion.hpp) satisfies the complementarity conditions above.
/// Friction bounds that depend on reactions may grow faster than these, so that no iteration finds
/// them, or that several motions are possible.
class ModeTrials {
 public:
  using Vector = std::vector<double>;
  static constexpr int open = 2;
  /// What each contact and then each joint at rest does: `open`, or as ModeContact::slip.
  using Mode = std::vector<int>;
  struct Motion {
    Mode mode;
    Vector a;  ///< accelerations
    std::vector<ModeFriction> preloaded;
  };

  /// The closed contacts, their sliding directions (0: at rest), and the joints at rest. `scale` is
  /// the greatest acceleration that the forces of the mode take away (m/s²).
  ModeTrials(const ModeEquations& d, const std::vector<int>& contacts, const std::vector<int>& slips,
             const std::vector<int>& resting, double scale);

  /// Returns the first two motions whose accelerations differ; none if there are more modes than are tried.
  std::vector<Motion> find(ModeEquations& d, ModeMotion& motion, const Vector& x, double t) const;
  void take(ModeEquations& d, ModeMotion& motion, const Motion& found) const;
  std::string words_of(const ModeEquations& d, const Mode& mode) const;

 private:
  void set(ModeEquations& d, const Mode& mode) const;
  bool holds(ModeEquations& d, const Vector& x, const Mode& mode) const;
  bool contact_holds(ModeEquations& d, const Vector& x, std::size_t i, int does) const;
  bool joint_holds(const ModeEquations& d, const ModeFriction& p) const;

  const std::vector<int>&contacts_, &slips_, &resting_;
  std::vector<std::vector<int>> options_;
  double scale_;
};

class ModeChoice {
 public:
  using Vector = std::vector<double>;

  ModeChoice(const NonsmoothOptions& options, int coupled) : problem_(options.solver, options.lcp_tolerance) {
    image_.setZero(coupled);
  }

  /// Determines the mode of d from `candidates`, the closed contacts. Returns an empty text, or the
  /// reason of a failure.
  std::string choose(ModeEquations& d, ModeMotion& motion, const Vector& x, double t,
                     const std::vector<int>& candidates);
  /// Whether the last choice found no forces that friction admits, and whether trying all modes
  /// proved it (lockup_proved()).
  bool locked_up() const { return lockup_; }
  bool lockup_proved() const { return lockup_proved_; }

  long& modes_left() { return problem_.modes_left; }

 private:
  void open_all(ModeEquations& d, const Vector& x, double t);
  void pose(ModeEquations& d, const Vector& x, const std::vector<int>& candidates);
  void pose_driven(const ModeEquations& d);
  ContactSolution settle(ModeEquations& d, const Vector& x, double t, const std::vector<int>& candidates);
  std::string other_motion(ModeEquations& d, const Vector& x, double t, const std::vector<int>& candidates);
  double force_side(int k, int slip) const;
  bool may_be_several(ModeEquations& d);
  void take(ModeEquations& d);
  std::string present_motion(const ModeEquations& d) const;
  std::string name_of_unknown(const ModeEquations& d, int i) const;
  std::string unsolved(const ModeEquations& d, const ContactSolution& solution) const;

  ContactProblem problem_;
  // of problem_: contacts, sliding direction of each, joints at rest
  std::vector<int> contacts_, slips_, resting_;
  BoundIteration bounds_;
  Eigen::VectorXd image_;  // image of the bounds
  bool lockup_ = false, lockup_proved_ = false;
};

}  // namespace freeplay
