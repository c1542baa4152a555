// ModeTrials: all modes of a few contacts and joints, tried one by one. A mode holds if the motion
// that it gives (mode_motion.hpp) satisfies the complementarity conditions of mode_choice.hpp.
// Friction bounds that depend on reactions may grow faster than these, so that no iteration finds
// them, or that several motions are possible.
#pragma once

#include <string>
#include <vector>

#include "formulations/event_driven/mode_motion.hpp"

namespace freeplay {

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

}  // namespace freeplay
