// Candidate pairs of a System's contact families: a list of all pairs whose gap is less than a
// reach, found on a grid of cells as wide as two discs plus the reach. With d_i a bound on the
// displacement of body i's centre since the list was made,
//
//     g ≥ g_list − d_i − d_j ≥ reach − 2 max d > 0
//
// for every pair not in the list, so that no contact is missed while 2 max d < reach (Verlet, Phys.
// Rev. 159 (1967) 98). A time step with midpoint q + (h/2) v⁻ and end q + (h/2)(v⁻ + v⁺) has
// d_i = |q_i − q_list,i| + (h/2)(|v_i⁻| + |v_i⁺|).
//
// Usage: find() makes the list; before each step, moved() is compared with reach() and the list is
// made anew if necessary.
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/families.hpp"
#include "values/memory.hpp"

namespace freeplay {

class Neighbours {
 public:
  /// A pair of a family by its bodies; i = ground for a wall.
  struct Pair {
    int family = 0, i = ground, j = ground;
    auto operator<=>(const Pair&) const = default;
    template <class M>
    void serialize(M& m) {
      m(family, i, j);
    }
  };

  explicit Neighbours(std::span<const ContactFamily> families);

  /// Makes the list at positions q: all pairs with a gap below `reach` (m), sorted.
  void find(const double* q, double reach);
  const std::vector<Pair>& found() const { return found_; }
  double reach() const { return reach_; }
  /// 2 max d (m) for a step of h (s) from q with rates v0 at its start and v1 at its end; h = 0: at
  /// q.
  double moved(const double* q, double h, const double* v0, const double* v1) const;
  /// A reach (m) that remains valid for several steps of that motion.
  double advised(double moved) const;
  /// Greatest speed of a centre (m/s).
  double fastest(const double* v) const;

  template <class M>
  void serialize(M& m) {
    const auto size = at_.size();
    m(reach_, at_);
    if (at_.size() != size) throw MemoryError("the snapshot's pairs belong to another mechanism");
  }

 private:
  int family_of(int body, int other) const {
    const auto b = static_cast<std::size_t>(body), o = static_cast<std::size_t>(other);
    return family_[static_cast<std::size_t>(kind_[b]) * kinds_ + static_cast<std::size_t>(kind_[o])];
  }

  std::span<const ContactFamily> families_;
  std::vector<int> bodies_, kind_;  // kind_ of each body by its index; −1: in no family
  std::vector<int> family_;         // of two kinds; −1: they have no contact
  std::size_t kinds_ = 0;
  double least_ = 0, widest_ = 0;  // m, least and greatest radius
  double reach_ = -1;
  std::vector<double> at_;  // x, y of each of bodies_ when the list was made
  std::vector<Pair> found_;
  std::vector<std::pair<std::uint64_t, int>> cells_;  // cells of the bodies, sorted
};

}  // namespace freeplay
