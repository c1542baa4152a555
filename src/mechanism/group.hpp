// A group: many equal discs, declared once by mass, radius, initial positions and contacts.
//
// Each disc is a body named NAME-1, NAME-2, …, in the order of the positions. It may touch the
// other discs of its group, the discs of the groups in `touches`, and straight walls of the ground.
// Each wall is an infinite line through two successive points of `walls`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mechanism/body.hpp"

namespace freeplay {

struct Group {
  /// How contact pairs of the group are stored. `each`: every pair is a contact with its own
  /// columns and statistics. `near`: pairs are found as they approach each other, and are reported
  /// by their events and by sums over each wall (docs/development/decisions/028-groups.md).
  enum class Pairs { each, near };
  static constexpr std::string_view what = "a group";
  /// Default of `pairs`: up to this number of pairs, `each`.
  static constexpr long most_listed = 300;

  std::string name;
  double mass = 0;                              ///< kg, of each disc
  double radius = 0;                            ///< m, > 0
  std::optional<double> inertia = {};           ///< kg m²; default m r²/2, a solid disc
  std::vector<Vec2> positions;                  ///< m, initial centres
  StatedVec2 velocity = {};                     ///< m/s, initial, of all discs
  std::optional<double> angular_velocity = {};  ///< rad/s, initial, of all discs
  /// m; the free space is on the left, going from point to point
  std::vector<Vec2> walls;
  std::vector<int> touches;              ///< indices of earlier groups
  int surface = -1;                      ///< of all contacts of the group
  std::optional<int> wall_surface = {};  ///< of the contacts with walls, if different
  std::optional<Pairs> pairs = {};
  int first = 0;       ///< index of its first body
  bool alone = false;  ///< without any contacts: see idealised()

  int size() const { return static_cast<int>(positions.size()); }
  double moment() const { return inertia.value_or(0.5 * mass * radius * radius); }
  int wall_count() const { return walls.empty() ? 0 : static_cast<int>(walls.size()) - 1; }
  /// Name of disc n, counted from 1.
  std::string body_name(int n) const { return name + "-" + std::to_string(n); }
  /// Disc n as a body, counted from 0.
  Body body(int n) const {
    Body b;
    b.name = body_name(n + 1);
    b.mass = mass;
    b.inertia = moment();
    b.position = positions[static_cast<std::size_t>(n)];
    b.velocity = velocity;
    b.angular_velocity = angular_velocity;
    b.made = true;
    return b;
  }

  static void keys(auto& k, auto& g);
};

inline constexpr auto group_pairs_names =
    complete<Group::Pairs>({{Group::Pairs::each, "each", "every pair is a contact with separate columns"},
                            {Group::Pairs::near, "near",
                             "contacts are detected by proximity, for time stepping with a fixed step"}});
constexpr std::span<const Choice<Group::Pairs>> choices(Group::Pairs) { return group_pairs_names; }

void Group::keys(auto& k, auto& g) {
  k.need({"mass", "kg", "mass of each disc, > 0"}, g.mass, positive);
  k.need({"radius", "m", "of each disc, > 0"}, g.radius, positive);
  k.take({"inertia", "kg m²", "of each about its centre, > 0; if absent: mass radius²/2, of a solid disc"},
         g.inertia, positive);
  k.places({"positions", "m", "centres at the start, [[x, y], ...], or a CSV file of two columns; or grid"},
           {"grid", "", "[columns, rows] of discs, numbered row by row from the lowest; or positions"},
           {"origin", "m", "grid: centre of the first disc"},
           {"spacing", "m", "grid: from column to column and from row to row"},
           {"stagger", "m", "grid: by which every second row is moved along x"}, g.positions);
  k.take({"velocity", "m/s", "of every disc at the start"}, g.velocity);
  k.take({"angular_velocity", "rad/s", "of every disc at the start"}, g.angular_velocity, any_number);
  k.way({"walls", "m",
         "points of a polygon of walls of the ground: NAME-wall1 is the infinite line through the first two, "
         "and so on; the discs are on its left"},
        g.walls);
  k.groups({"touches", "", "groups defined before it whose discs can contact its own"}, g.touches);
  k.surface({"surface", "", "of the contacts of its discs"}, g.surface);
  k.maybe_surface({"wall_surface", "", "of the contacts with walls", "surface"}, g.wall_surface);
  k.choose({"pairs", "", "", "by their number"}, g.pairs);
}

}  // namespace freeplay
