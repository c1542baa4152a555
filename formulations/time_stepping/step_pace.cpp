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
  constexpr long between = 200;  // steps
  if (++steps < between) return;
  const double passed = t - since;
  const double slow = scales_.guessed ? pace : scales_.time;
  // Otherwise steps are short because the smooth motion needs it, and a higher floor would not
  // resolve it.
  const bool crowded = impacts_now >= 40 || gains_now > gains;
  if (crowded && passed < 0.02 * slow) floor = std::min(4 * floor, std::max(least_floor, 0.2 * pace));
  if (passed > 0.2 * slow) floor = std::max(0.25 * floor, least_floor);
  if (passed > 0.02 * slow || gains_now == gains) {
    calm_speed = fastest;
    calm_gains = gains_now;
  }
  gains = gains_now;
  steps = impacts_now = 0;
  since = t;
}

}  // namespace freeplay
