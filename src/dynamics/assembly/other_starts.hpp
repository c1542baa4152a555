// Alternative starts of an assembly, for a given pose that leads to no closed pose or to another
// branch than the requested one. The list is the same at every call:
//
//     first    pairs of links with a common joint are mirrored: the joint about the line through
//              their other joints (for a slider, about the line through the other link's joint
//              across the guide), one pair, then several;
//     then     angles 2π {n α_b} of all bodies, with α_b = {φ^−b}, φ^(d+1) = φ + 1 (Kronecker
//              sequence with the generators of M. Roberts, 2018). Each body is attached to the
//              one before it along the joints from the ground; driven and fixed angles are kept.
#pragma once

#include <string>
#include <vector>

namespace freeplay {

struct Mechanism;

/// The pose in which each body without a stated position, starting from the ground and the bodies of
/// stated pose, is attached to the previous one by their joint, at its stated angle, the angle that
/// joints or a drive fix, or its own of q.
std::vector<double> hung(const Mechanism& mechanism, const std::vector<double>& q);

/// Whether a mechanism states a position or an angle, of bodies or drives: hung() is then the
/// intended pose.
bool states_pose(const Mechanism& mechanism);

/// Removes whole turns from free angles in q that differ by more than half a turn from the given
/// ones. A search may add such turns, which would load torsional springs.
void unwind(const Mechanism& mechanism, const std::vector<double>& given, std::vector<double>& q);

class OtherStarts {
 public:
  /// `near`: the pose whose links are mirrored; `length` (m): range of the positions of sliders.
  OtherStarts(const Mechanism& mechanism, std::vector<double> near, double length);
  /// The number of starts; smaller for a large mechanism.
  int count() const { return flips_ + drawn_; }
  /// Start n, n < count(), and its description.
  std::vector<double> pose(int n) const;
  std::string what(int n) const;

 private:
  /// Two bodies with the common joint J and other joints K and L.
  struct Dyad {
    int i, j, J, K, L;
  };
  void find_dyads();
  void turn_over(const Dyad& dyad, std::vector<double>& q) const;
  std::vector<double> drawn(int n) const;

  const Mechanism& m_;
  std::vector<double> near_;
  double length_;
  std::vector<Dyad> dyads_;
  std::vector<unsigned> order_;  // sets of dyads as bits
  int flips_ = 0, drawn_ = 0;
};

}  // namespace freeplay
