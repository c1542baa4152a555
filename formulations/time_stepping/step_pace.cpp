#include "formulations/time_stepping/step_pace.hpp"

#include <algorithm>

namespace freeplay {

StepPace::StepPace(double tolerance, const Scales& scales)
    : fastest(scales.guessed ? 0 : scales.speed), tolerance_(tolerance), scales_(scales) {
  find();
}

void StepPace::find() {
  const double longer = raised();
  pace = fastest > 0 ? scales_.length / fastest : 0;
  if (film_pace > 0) pace = pace > 0 ? std::min(pace, film_pace) : film_pace;
  least_floor = tolerance_ * pace;
  floor = longer * least_floor;
}

void StepPace::start(double t, double speed, double film_rate, long gains) {
  fastest = std::max(fastest, speed);
  // An unloaded film whirls with the journal's spin, even if the journal's centre is slow.
  film_pace = film_rate > 0 ? 1 / film_rate : 0;
  find();
  since = t;
  calm_speed = std::max(fastest, scales_.speed);
  calm_gains = gains;
}

void StepPace::note_speed(double speed) {
  if (!(speed > 1.01 * fastest)) return;
  fastest = speed;
  find();
}

void StepPace::note_step(double t, long gains_now) {
  constexpr long between = 200;      // steps
  constexpr long many_impacts = 40;  // among these steps
  // Time of these steps over the scene's: below it the floor rises, above it the floor falls.
  constexpr double slow_progress = 0.02, fast_progress = 0.2;
  constexpr double rise = 4, fall = 0.25, highest_floor = 0.2;  // of the floor; of the pace
  if (++steps < between) return;
  const double passed = t - since;
  const double slow = scales_.guessed ? pace : scales_.time;
  // Otherwise steps are short because the smooth motion needs it, and a higher floor would not
  // resolve it.
  const bool crowded = impacts_now >= many_impacts || gains_now > gains;
  if (crowded && passed < slow_progress * slow)
    floor = std::min(rise * floor, std::max(least_floor, highest_floor * pace));
  if (passed > fast_progress * slow) floor = std::max(fall * floor, least_floor);
  if (passed > slow_progress * slow || gains_now == gains) {
    calm_speed = fastest;
    calm_gains = gains_now;
  }
  gains = gains_now;
  steps = impacts_now = 0;
  since = t;
}

}  // namespace freeplay
