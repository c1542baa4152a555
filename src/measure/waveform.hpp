// Difference of the mean turns of a measured signal and of a run, and what it is if both are of the
// same motion. With ȳ and x̄ the vectors of the harmonics 1, 2, … of the mean turns (harmonics.hpp),
// scaled so that ‖·‖ is a root mean square, and the relative uncertainty t of the measurement,
//
//     w = √(‖x̄ − ȳ‖² + t²‖ȳ‖²),     E w² = tr V_x + tr V_y + 2 t²‖ȳ‖²
//
// for runs of the measured motion, where V are the covariances of the means with the
// autocorrelation of the turns (mean_difference.hpp). The term t²‖ȳ‖² in w keeps its logarithm
// smooth where the motion repeats exactly. The mean of the signal, harmonic 0, is excluded:
// accelerometers differ in their response to it. A signal without crank angles is aligned with the
// run first, in phase and sign (alignment.hpp).
#pragma once

#include <vector>

#include "measure/harmonics.hpp"
#include "measure/measurement.hpp"
#include "measure/turns.hpp"

namespace freeplay {

/// The turns of a measured signal.
struct MeasuredTurns {
  std::vector<Harmonics> turns;
  bool datum = false;  ///< whether crank angles were measured
};
/// Throws SceneError as read_measurement() if the signal has less than one turn. `speed`: of the crank
/// (rad/s).
MeasuredTurns turns_of(const Measurement& measured, double speed);

/// w, in the unit of the signal; NaN if a list is empty. `tolerance`: t.
double waveform_difference(const MeasuredTurns& measured, const std::vector<Harmonics>& model,
                           double tolerance);

/// w of the measured motion itself.
struct ExpectedDifference {
  double value = 0;      ///< √(E w²)
  double deviation = 0;  ///< standard deviation of ln w
};
/// For runs of `turns` turns. NaN if a single turn was measured, whose scatter is unknown.
ExpectedDifference expected_difference(const MeasuredTurns& measured, int turns, double tolerance);

}  // namespace freeplay
