// Contact families: contacts of one kind among many bodies (mechanism/group.hpp), with their common
// facts and the pair of any two bodies. Neighbours finds the pairs that may touch within a step.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/parts.hpp"
#include "mechanism/body.hpp"
#include "mechanism/surface.hpp"
#include "values/memory.hpp"

namespace freeplay {

/// Bodies first … first + count − 1.
struct BodyRange {
  int first = 0, count = 0;
};

/// All contacts between the discs of one range and those of another (others), among the discs of
/// one range (own), or between the discs of a range and a wall of the ground (wall).
struct ContactFamily {
  enum class Of { own, others, wall };
  Of of = Of::own;
  std::string name;
  BodyRange first, second;            ///< others: both are used; else only `second`
  double radius_i = 0, radius_j = 0;  ///< m; wall: only radius_j
  /// wall: a point (m) and the direction; free space is on the left
  Vec2 at{0, 0}, axis{1, 0};
  ContactFacts facts;  ///< common facts; names and bodies are those of the pair

  /// Gap of a pair with these coordinates, equal to that of the pair itself.
  double gap(const double* q, int i, int j) const {
    const Vec2 rj = centre(q, j);
    if (of == Of::wall) return dot(perp(axis), rj - at) - radius_j;
    return (rj - centre(q, i)).norm() - (radius_i + radius_j);
  }
  Pair pair(int i, int j) const {
    if (of == Of::wall) return LinePair{{ground, j, at, {0, 0}}, 1, axis, radius_j, radius_j};
    return RoundPair{{i, j, {0, 0}, {0, 0}}, -1, radius_i + radius_j, radius_i, -radius_j};
  }
  /// Calls f with the bodies of each pair, in order: i < j for own, i = ground for a wall.
  template <class F>
  void each(F f) const {
    const int end = second.first + second.count;
    if (of == Of::wall)
      for (int j = second.first; j < end; ++j) f(ground, j);
    else if (of == Of::own)
      for (int i = second.first; i < end; ++i)
        for (int j = i + 1; j < end; ++j) f(i, j);
    else
      for (int i = first.first; i < first.first + first.count; ++i)
        for (int j = second.first; j < end; ++j) f(i, j);
  }
  long pairs() const {
    const long n = second.count;
    return of == Of::wall ? n : of == Of::own ? n * (n - 1) / 2 : n * first.count;
  }
};

/// The name of a pair: its two bodies, or the wall and the body.
inline std::string pair_name(const std::string& family, const std::vector<std::string>& bodies, int i,
                             int j) {
  const auto& other = bodies[static_cast<std::size_t>(j)];
  return (i == ground ? family : bodies[static_cast<std::size_t>(i)]) + "-" + other;
}

struct Group;
struct Mechanism;
/// The contact families of a group: among its discs, with the discs of the groups that it names,
/// and with its walls. Tolerance scales are those of disc and plane contacts
/// (elements/disc_contact.hpp, elements/plane_contact.hpp). `longest_arm` (m): of the mechanism.
std::vector<ContactFamily> families_of(const Mechanism& mechanism, const Group& group, double longest_arm);
/// Whether the pairs are searched during the run, rather than listed as contacts.
bool found_near(const Group& group, const std::vector<ContactFamily>& families);

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
