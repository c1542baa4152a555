// Which pairs of a System's families may touch: a list of all whose gap is less than a reach, found on a grid of cells as
// wide as two discs and the reach. With d_i how far body i's centre may have come from where the list was made,
//
//     g ≥ g_list − d_i − d_j ≥ reach − 2 max d > 0
//
// for every pair that is not in it, so that none is missed while 2 max d < reach (Verlet, Phys. Rev. 159 (1967) 98). A time
// step with the midpoint q + (h/2) v⁻ and the end q + (h/2)(v⁻ + v⁺) has d_i = |q_i − q_list,i| + (h/2)(|v_i⁻| + |v_i⁺|).
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
  /// A pair: bodies of a family, i = ground at a wall.
  struct Pair {
    int family = 0, i = ground, j = ground;
    auto operator<=>(const Pair&) const = default;
    template <class M>
    void remember(M& m) {
      m(family, i, j);
    }
  };

  explicit Neighbours(std::span<const ContactFamily> families);

  /// Makes the list anew at positions q: all pairs with a gap of less than `reach` (m), in their order.
  void find(const double* q, double reach);
  const std::vector<Pair>& found() const { return found_; }
  double reach() const { return reach_; }
  /// 2 max d (m) of a step of h (s) from q at rates v0 that ends with v1; h = 0: at q.
  double moved(const double* q, double h, const double* v0, const double* v1) const;
  /// A reach (m) that lasts for some steps of that motion.
  double advised(double moved) const;
  /// m/s, greatest speed of a centre.
  double fastest(const double* v) const;

  template <class M>
  void remember(M& m) {
    const auto size = at_.size();
    m(reach_, at_);
    if (at_.size() != size) throw MemoryError("the snapshot's pairs are of another mechanism");
  }

 private:
  int family_of(int body, int other) const {
    const auto b = static_cast<std::size_t>(body), o = static_cast<std::size_t>(other);
    return family_[static_cast<std::size_t>(kind_[b]) * kinds_ + static_cast<std::size_t>(kind_[o])];
  }

  std::span<const ContactFamily> families_;
  std::vector<int> bodies_, kind_;  // kind_ of each body by its index, −1: in none
  std::vector<int> family_;         // of two kinds, −1: they do not touch
  std::size_t kinds_ = 0;
  double least_ = 0, widest_ = 0;  // m, radii
  double reach_ = -1;
  std::vector<double> at_;  // x, y of each of bodies_ where the list was made
  std::vector<Pair> found_;
  std::vector<std::pair<std::uint64_t, int>> cells_;  // of bodies, sorted
};

}  // namespace freeplay
