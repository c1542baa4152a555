// The best pose of a mechanism that cannot be closed, and the joints that stay open in it. The best
// pose minimises
//
//     ½ Σ_k Φ_k²/s_k² + ½ Σ_c max(0, −g_c)²     over q,
//
// with s = 1 for lengths and 1/ℓ for angles (ℓ: the mechanism's length). Drives may be held: their
// prescribed motion then has priority over all joints. The method is that of Levenberg and
// Marquardt (Marquardt, SIAM J. Appl. Math. 11 (1963) 431).
#pragma once

#include <string>
#include <vector>

namespace freeplay {

struct Mechanism;
class System;

/// An open joint or drive, or an overlapping contact, with the size of its violation (m or rad).
struct OpenJoint {
  std::string name;
  double amount = 0;
  bool angular = false;
  bool overlap = false;  ///< a contact with overlapping surfaces
  bool drive = false;    ///< a prescribed motion
};

/// All open joints at q and at time t (s) of the drives, each once with the length of its gap. They
/// are sorted by size, greatest first; `length` (m) converts angles. Gaps below a hundredth of the
/// greatest are omitted.
std::vector<OpenJoint> open_joints(const System& system, const std::vector<double>& q, double length,
                                   double t = 0);

/// Moves q to the nearest local optimum, at time t (s) of the drives; `held` coordinates (empty: none)
/// keep their values.
void best_pose(const System& system, double length, bool hold_drives, std::vector<double>& q, double t = 0,
               const std::vector<char>& held = {});

/// For example "stays open by 0.35 m".
std::string describe(const OpenJoint& open);

/// Dotted key of the table of a joint, contact or drive.
std::string key_of(const Mechanism& mechanism, const OpenJoint& open);

}  // namespace freeplay
