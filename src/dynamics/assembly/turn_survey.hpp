// Positions of a mechanism over a full turn of its drive: the range of the driven angle in which
// its loops close, dead centres and transmission angles.
//
// The ideal mechanism is followed from its start in both directions of the driven angle φ, in
// intervals of 5 degrees (mobility.hpp). The range ends where a loop cannot close any further.
//
//     dead centre          dσ/dφ = 0, where σ is the angle or position of a joint of the ground
//                          that is not driven; it reverses there
//     transmission angle   μ = acute angle at the joint J between the two bodies of a dyad: between
//                          the lines from J to their other joints, or, if the other joint is a
//                          guide, the normal to its axis (Alt, 1932; Norton, Design of Machinery,
//                          section 3.3). The dyad transmits no force to its output at μ = 0.
//
// Dyads are two bodies that join two bodies of determined motion, starting from the ground and the
// driven body (Assur groups of class II). An extremum is located by golden section and a parabola.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/assembly/closure.hpp"

namespace freeplay {

struct Mechanism;

/// An extremum over the turn.
struct TurnExtreme {
  double angle = 0;  ///< rad, of the driven joint
  double value = 0;
};

/// Transmission angle of a dyad (rad, from 0 to π/2).
struct TransmissionAngle {
  std::string joint;  ///< between the two bodies
  TurnExtreme least, greatest;
};

/// Motion of a joint of the ground with its dead centres.
struct OutputMotion {
  std::string joint;
  bool slides = false;
  double travel = 0;                      ///< rad or m, between the extreme positions
  double turns = 0;                       ///< of a pin in a full turn of the drive
  std::vector<TurnExtreme> dead_centres;  ///< in the order of the turn
};

struct TurnSurvey {
  std::string joint;                        ///< the driven joint
  bool full = false;                        ///< the loops close over a full turn
  double lower = 0, upper = 0;              ///< rad, range of the driven angle otherwise
  std::optional<OpenJoint> below, above{};  ///< the joint that opens beyond each limit
  std::vector<OutputMotion> outputs;
  std::vector<TransmissionAngle> transmission;
};

/// The survey from the pose `start`. The driven joint is that of the crank angle
/// (crank_joint()). Empty if there is none, if other prescribed motions depend on time and no drive
/// has a constant speed, if the ideal mechanism is not closed near it, and for more than
/// most_followed bodies.
std::optional<TurnSurvey> survey_turn(const Mechanism& mechanism, const std::vector<double>& start);

}  // namespace freeplay
