// Four-bar loops of a mechanism: four revolute joints A, B, C, D in a ring of four bodies, with
// links
//
//     AD = fixed    AB = input    BC = coupler    CD = output.
//
// Grashof's condition (F. Grashof, Theoretische Maschinenlehre 2 (1883) 113; Norton, Design of
// Machinery, ch. 2): let s be the shortest link, l the longest and p, q the others. If
// s + l ≤ p + q, one link can make full turns relative to the others, and the position of the
// shortest link determines the type. If s + l > p + q, none can. The loop can be closed if
// l ≤ s + p + q.
//
// In a pose the loop is open if A and C are on different sides of the line BD, else crossed; the
// two are mirror images of the dyad BCD about BD. For an input angle of up to half a turn from the
// fixed link these are the terms of the textbooks (Norton, ch. 4).
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
  std::array<double, 4> lengths{};  ///< m, of AD, AB, BC, CD

  double shortest_and_longest() const;  ///< s + l, m
  double other_two() const;             ///< p + q, m
};

/// All loops with nonzero link lengths, each once. The ground is the fixed link if it belongs to
/// the loop. The input is the driven link, else the one whose joint comes first.
std::vector<FourBar> four_bars(const Mechanism& mechanism);

/// Sums of lengths that differ by less than 1e-9 of the total are at a change point.
Grashof type_of(const FourBar& loop);
/// For example "crank-rocker: crank, the shortest link, turns fully".
std::string describe(const Mechanism& mechanism, const FourBar& loop, Grashof type);
/// The reason why the lengths of a loop prevent closure, else empty: "link rod of 0.9 m is 0.1 m
/// longer than the other three of its loop together".
std::string too_long(const Mechanism& mechanism, const FourBar& loop);

/// Product (m⁴) of twice the signed areas of DBA and BDC, which shows the sides of A and C:
/// positive if the loop is open.
double openness(const Mechanism& mechanism, const FourBar& loop, const std::vector<double>& q);

}  // namespace freeplay
