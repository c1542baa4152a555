// What stays open of a mechanism that cannot be closed. The best pose is the least of
//
//     ½ Σ_k Φ_k²/s_k² + ½ Σ_c max(0, −g_c)²     over q,
//
// with s = 1 for lengths and 1/ℓ for angles (ℓ the mechanism's length), and drives held: what they prescribe is met
// before any joint. Levenberg and Marquardt's method (Marquardt, SIAM J. Appl. Math. 11 (1963) 431).
#pragma once

#include <string>
#include <vector>

namespace freeplay {

struct Mechanism;
class System;

/// The joint or drive whose constraint is worst violated, or the contact that overlaps most, and by how much (m or
/// rad).
struct OpenJoint {
  std::string name;
  double amount = 0;
  bool angular = false;
  bool overlap = false;  ///< a contact whose surfaces lie in each other
  bool drive = false;    ///< a prescribed motion
};

/// All that is open at q and the time t (s) of the drives, each joint once with the length of its gap, worst first by `length` (m, of a radian); what is
/// less than a hundredth of the worst is closed.
std::vector<OpenJoint> open_joints(const System& system, const std::vector<double>& q, double length,
                                   double t = 0);

/// Moves q to the nearest best pose that is found at the time t (s) of the drives.
void best_pose(const System& system, double length, bool hold_drives, std::vector<double>& q, double t = 0);

/// "stays open by 0.35 m"
std::string describe(const OpenJoint& open);

/// Dotted key of the table that describes a joint, contact or drive.
std::string key_of(const Mechanism& mechanism, const OpenJoint& open);

}  // namespace freeplay
