// Freewheel (one-way clutch): the second body turns freely against the first in one direction, and is
// held in the other up to the capacity T. With u = ω_j − ω_i, for the free direction "forward",
//
//     u > 0   overruns         M = 0
//     u = 0   engaged          0 ≤ M ≤ T
//     u < 0   slips            M = T
//
// M acts on the second body. This is Coulomb friction with one bound for each direction of the
// torque, T and 0 (ReactionBound in dynamics/evaluation.hpp).
#pragma once

#include <array>
#include <optional>
#include <string>

#include "mechanism/body.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// A one-way clutch.
struct Freewheel {
  /// The free rotation of the second body against the first.
  enum class Free { forward, backward };
  static constexpr std::string_view type = "freewheel", what = "a freewheel";
  static constexpr auto reports = ForceElement::Kind::torque;
  std::string name;                            ///< of the element in the scene
  std::array<int, 2> between{ground, ground};  ///< first and second body: indices, or ground
  double torque_limit = 0;                     ///< N m, T, > 0
  /// in which the second body turns freely against the first
  Free direction = Free::forward;
  /// rad/s, speed below which the penalty formulation's torque is linear in speed
  std::optional<double> regularisation = {};

  static void keys(auto& k, auto& l) {
    k.between("two bodies, or \"ground\" and a body", l.between);
    k.need({"torque_limit", "N m", "capacity: the greatest torque that it transmits, beyond which it slips"},
           l.torque_limit, positive);
    k.choose({"direction", "", "free rotation of the second body against the first: "}, l.direction);
    k.take({"regularisation", "rad/s",
            "speed of slip below which the torque is linear; required by the penalty formulation"},
           l.regularisation, positive);
  }
};

inline constexpr auto free_directions = complete<Freewheel::Free>(
    {{Freewheel::Free::forward, "forward", "counter-clockwise"}, {Freewheel::Free::backward, "backward"}});
constexpr std::span<const Choice<Freewheel::Free>> choices(Freewheel::Free) { return free_directions; }

}  // namespace freeplay
