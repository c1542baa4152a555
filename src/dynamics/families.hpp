// Contact families: contacts of one kind among many bodies (mechanism/group.hpp), with their common
// facts and the pair of any two bodies. Neighbours finds the pairs that may touch within a step.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dynamics/parts.hpp"
#include "mechanism/body.hpp"
#include "mechanism/surface.hpp"

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

}  // namespace freeplay
