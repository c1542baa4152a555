// Contacts of one kind among many bodies (mechanism/group.hpp): what they share, and the pair of any two.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dynamics/parts.hpp"
#include "mechanism/body.hpp"
#include "mechanism/surface.hpp"

namespace freeplay {

/// Bodies [first, first + count).
struct BodyRange {
  int first = 0, count = 0;
};

/// Every disc of one range against every disc of another, against the others of its own, or against a wall of the ground.
struct ContactFamily {
  enum class Of { own, others, wall };
  Of of = Of::own;
  std::string name;
  BodyRange first, second;            ///< others: both; else `second` alone
  double radius_i = 0, radius_j = 0;  ///< m; of a wall `radius_j` alone
  Vec2 at{0, 0}, axis{1, 0};          ///< wall: a point (m) and its direction; free space lies on the left
  ContactFacts facts;                 ///< of all, but for their names and bodies

  /// g of a pair with these centres (m), as the pair itself has it.
  double gap(const double* q, int i, int j) const {
    const Vec2 rj = centre(q, j);
    if (of == Of::wall) return dot(perp(axis), rj - at) - radius_j;
    return (rj - centre(q, i)).norm() - (radius_i + radius_j);
  }
  Pair pair(int i, int j) const {
    if (of == Of::wall) return LinePair{{ground, j, at, {0, 0}}, 1, axis, radius_j, radius_j};
    return RoundPair{{i, j, {0, 0}, {0, 0}}, -1, radius_i + radius_j, radius_i, -radius_j};
  }
  /// Calls f with the bodies of each, in order: i < j of its own, i = ground at a wall.
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

/// The name of one pair of a family: of its bodies, or of the wall and its body.
inline std::string pair_name(const std::string& family, const std::vector<std::string>& bodies, int i,
                             int j) {
  const auto& other = bodies[static_cast<std::size_t>(j)];
  return (i == ground ? family : bodies[static_cast<std::size_t>(i)]) + "-" + other;
}

struct Group;
struct Mechanism;
/// What the discs of a group touch: each other, those of the groups that it names, its walls; with the scales of their kinds
/// of contact (elements/disc_contact.hpp, elements/plane_contact.hpp). `longest_arm`: m, of the mechanism.
std::vector<ContactFamily> families_of(const Mechanism& mechanism, const Group& group, double longest_arm);
/// Whether its pairs are found as they come near.
bool found_near(const Group& group, const std::vector<ContactFamily>& families);

}  // namespace freeplay
