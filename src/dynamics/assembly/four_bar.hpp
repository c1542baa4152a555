// Four-bar loops of a mechanism: four revolute joints A, B, C, D in a ring of four bodies, with links
//
//     AD = fixed    AB = input    BC = coupler    CD = output.
//
// Grashof's condition (F. Grashof, Theoretische Maschinenlehre 2 (1883) 113; Norton, Design of Machinery, ch. 2): with s the
// shortest link, l the longest and p, q the others, one link turns fully against the others where s + l ≤ p + q. Which one
// is the shortest makes the type; none turns fully where s + l > p + q. The loop closes where l ≤ s + p + q.
//
// In a pose the loop is open where A and C lie on either side of the line BD, else crossed: the mirror image of the
// dyad BCD about BD. For an input that stands up to half a turn ahead of the fixed link these are the textbooks' words
// (Norton, ch. 4).
#pragma once

#include <array>
#include <string>
#include <vector>

#include "values/vec2.hpp"

namespace freeplay {

struct Mechanism;

enum class Grashof { crank_rocker, double_crank, double_rocker, change_point, triple_rocker, unclosable };

struct FourBar {
  std::array<int, 4> joints{};      ///< A, B, C, D: indices into Mechanism::joints
  std::array<int, 4> bodies{};      ///< fixed, input, coupler, output
  std::array<double, 4> lengths{};  ///< m, of these: AD, AB, BC, CD

  double shortest_and_longest() const;  ///< s + l, m
  double other_two() const;             ///< p + q, m
};

/// The loops whose links all have a length, each once; the ground is the fixed link where it is one of the four, and the
/// input is the link that a drive turns, or else the one whose joint stands first.
std::vector<FourBar> four_bars(const Mechanism& mechanism);

/// Lengths whose sums differ by less than 1e-9 of their sum are at a change point.
Grashof type_of(const FourBar& loop);
/// "crank-rocker: the shortest link, crank, turns fully"
std::string describe(const Mechanism& mechanism, const FourBar& loop, Grashof type);
/// What keeps a loop from closing, empty where its lengths allow it: "link rod of 0.9 m is 0.1 m longer than the other three of
/// the loop together".
std::string too_long(const Mechanism& mechanism, const FourBar& loop);

/// Twice the signed areas of DBA and BDC tell the sides of A and C: positive where the loop is open, in m⁴.
double openness(const Mechanism& mechanism, const FourBar& loop, const std::vector<double>& q);

}  // namespace freeplay
