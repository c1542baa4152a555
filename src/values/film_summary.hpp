// Statistics of the lubricant film of one joint over the time after the discarded start.
#pragma once

namespace freeplay {

/// Of one film; times after the discarded start only.
struct FilmSummary {
  double mean_ratio = 0, greatest_ratio = 0;  ///< eccentricity ratio ε
  double mean_thickness = 0;                  ///< m, of the least film thickness c(1 − ε)
  double least_thickness = 0, least_at = 0;   ///< m, and its time (s)
  double mean_load = 0, greatest_load = 0;    ///< N, magnitude of the film force
  double mean_speed = 0;                      ///< rad/s, of |ω_i + ω_j|
  double attitude = 0;                        ///< rad, direction of the mean of (cos φ, sin φ)
  double sommerfeld = 0;                      ///< of mean load and mean speed; 0 without load
  double mean_loss = 0, greatest_loss = 0;    ///< W, dissipated power
};

}  // namespace freeplay
