// StepPace: time scales of a motion for adaptive steps. The shortest useful step, the floor, is the
// time in which the fastest body, relative to the bodies that it may contact, travels the tolerance
// of its clearance,
//
//     least floor = tolerance × ℓ / v_max
//
// If many impacts accumulate in a short time, the floor is raised, up to a fifth of ℓ/v_max, and
// later lowered again.
#pragma once

#include "formulations/integrators/tolerance.hpp"

namespace freeplay {

class StepPace {
 public:
  StepPace(double tolerance, const Scales& scales);

  /// Starts at t with a motion of this speed; `film_rate`: angular speed (rad/s) of the fastest
  /// journal in a film.
  void start(double t, double speed, double film_rate, long gains);
  /// Takes into account the speed (m/s) after a step.
  void note_speed(double speed);
  /// Called after each step; `gains`: number of impacts so far that raised the energy.
  void note_step(double t, long gains);
  /// Ratio of the present floor to the least floor.
  double raised() const { return least_floor > 0 ? floor / least_floor : 1; }
  /// Whether impacts accelerate the motion without limit, so that shorter steps do not help. A body
  /// that springs or drives accelerate from rest gains speed without impacts and does not count.
  bool runs_away(long gains) const {
    return calm_speed > 0 && fastest > 1e3 * calm_speed && gains > calm_gains;
  }

  /// m/s, the mechanism's own speed if a body moves far faster than it: a prescribed motion drives a locked
  /// mechanism, whose speeds grow without limit; else 0.
  double far_exceeded() const {
    return !scales_.guessed && fastest > 1e4 * scales_.fastest ? scales_.fastest : 0;
  }

  /// @name Serialized state
  ///@{
  double fastest = 0;                 // m/s
  double pace = 0;                    // s, in which the fastest body crosses the least clearance
  double film_pace = 0;               // s, of a film that rotates with its journal
  double floor = 0, least_floor = 0;  // s
  // since the last check of the pace; of those, steps over impacts
  long steps = 0, impacts_now = 0;
  double since = 0;       // s, time of that check
  double calm_speed = 0;  // m/s, the greatest speed when impacts last raised no energy
  long gains = 0;         // impacts that raised the energy, at the last check
  // impacts that raised the energy, when calm_speed was taken
  long calm_gains = 0;
  ///@}

 private:
  void find();

  double tolerance_;
  Scales scales_;
};

}  // namespace freeplay
