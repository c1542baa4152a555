// Where an assembly begins again when the pose it was given leads nowhere, or to another branch than the one asked for. The
// list is the same at every call:
//
//     first    pairs of links that share a joint, turned over: the joint mirrored about the line through their other joints
//              (for a slider, about the line through the other link's joint across the guide), one pair, then several;
//     then     angles 2π {n α_b} of all bodies, with α_b = {φ^−b}, φ^(d+1) = φ + 1 (Kronecker's sequence as M. Roberts chose its
//              generators, 2018), each body hung on the one before it along the joints from the ground; drives and fixed
//              angles are kept.
#pragma once

#include <string>
#include <vector>

namespace freeplay {

struct Mechanism;

/// The pose in which each body that joints connect with the ground hangs on the one before it, at its own angle of q or the one
/// that a joint or drive holds.
std::vector<double> hung(const Mechanism& mechanism, const std::vector<double>& q);

/// Whether a mechanism states angles, of bodies or drives, and no position: then hung() is what it means.
bool states_no_place(const Mechanism& mechanism);

/// Takes whole turns off the angles in q that nothing holds, where they stand more than half a turn from those given: what a
/// search wound up, a torsional spring would feel.
void unwind(const Mechanism& mechanism, const std::vector<double>& given, std::vector<double>& q);

class OtherStarts {
 public:
  /// `near`: the pose in which links are turned over; `length`: m, how far sliders are put.
  OtherStarts(const Mechanism& mechanism, std::vector<double> near, double length);
  /// How many there are; fewer for a large mechanism.
  int count() const { return flips_ + drawn_; }
  /// The n-th, n < count(), and what it is.
  std::vector<double> pose(int n) const;
  std::string what(int n) const;

 private:
  /// Two bodies that share joint J, with joints K and L elsewhere.
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
  std::vector<unsigned> order_;  // of sets of dyads, as bits
  int flips_ = 0, drawn_ = 0;
};

}  // namespace freeplay
