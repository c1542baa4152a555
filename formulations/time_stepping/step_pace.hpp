// How fast a motion is, for adaptive steps: the shortest step worth taking, the floor, is what the fastest body against what it may
// touch passes in the tolerance of its clearance,
//
//     least floor = tolerance × ℓ / v_max
//
// Where many impacts follow each other in next to no time the floor is raised, up to a fifth of ℓ/v_max, and lowered again.
#pragma once

#include "formulations/integrators/tolerance.hpp"

namespace freeplay {

class StepPace {
 public:
  StepPace(double tolerance, const Scales& scales);

  /// From t on, of a motion of this speed; `film_rate`: rad/s, of the fastest journal in a film.
  void start(double t, double speed, double film_rate, long gains);
  /// Takes a speed (m/s) that a step came to.
  void note_speed(double speed);
  /// After each step; `gains`: impacts so far that raised the energy.
  void note_step(double t, long gains);
  /// How much longer the floor is at present than it need be.
  double raised() const { return least_floor > 0 ? floor / least_floor : 1; }
  /// Impacts drive the motion faster and faster: it comes to no end that shorter steps would reach. A body that springs or
  /// drives accelerate from rest gains as much speed by no impact.
  bool runs_away(long gains) const {
    return calm_speed > 0 && fastest > 1e3 * calm_speed && gains > calm_gains;
  }

  /// @name What a run remembers
  ///@{
  double fastest = 0;                 // m/s
  double pace = 0;                    // s, in which that crosses the least clearance
  double film_pace = 0;               // s, of a film that turns with its journal
  double floor = 0, least_floor = 0;  // s
  long steps = 0, strikes = 0;        // since the pace was looked at; of those, steps over impacts
  double since = 0;                   // s, then
  double calm_speed = 0;              // m/s, the fastest when impacts last gave nothing
  long gains = 0;                     // impacts that raised the energy when the pace was last looked at
  long calm_gains = 0;                // the same when calm_speed was taken
                                      ///@}

 private:
  void find();

  double tolerance_;
  Scales scales_;
};

}  // namespace freeplay
