// Difference of the mean turns of a measured signal and of a run, and what it is if both are of the
// same motion. With ȳ and x̄ the vectors of the harmonics 1, 2, … of the mean turns (harmonics.hpp),
// scaled so that ‖·‖ is a root mean square, and the relative uncertainty t of the measurement,
//
//     w = √(‖x̄ − ȳ‖² + t²‖ȳ‖²),     E w² = tr V_x + tr V_y + 2 t²‖ȳ‖²
//
// for runs of the measured motion, where V are the covariances of the means with the
// autocorrelation of the turns (difference_of_means()). The term t²‖ȳ‖² in w keeps its logarithm
// smooth where the motion repeats exactly. The mean of the signal, harmonic 0, is excluded:
// accelerometers differ in their response to it. A signal without crank angles is aligned with the
// run first, in phase and sign (alignment.hpp).
#pragma once

#include <cmath>
#include <vector>

#include "measure/harmonics.hpp"
#include "measure/measurement.hpp"
#include "measure/turns.hpp"

namespace freeplay {

// Test whether two samples of vectors have the same mean, for properties of the turns (revolutions)
// of a measurement and of a run. With x̄ and ȳ the means, and r the deviations from them,
//
//     V = V_x + V_y,   V_x = τ_x Σ r rᵀ/(n_x (n_x − 1)),   F = ‖x̄ − ȳ‖²/(tr V + u²),
//
// F follows approximately an F distribution with the degrees of freedom
//
//     f = (tr V + u²)²/(tr V² + u⁴),   f₀ = (tr V + u²)²/Σ_i tr V_i²/ν_i,   ν_i = n_i/τ_i − 1
//
// (Box, Ann. Math. Statist. 25 (1954) 290; Brunner, Dette and Munk, J. Am. Statist. Assoc. 92 (1997)
// 1494): the samples may have different variances, and more dimensions than members. u is an error
// common to all members, of any direction. Members follow each other in time: τ = 1 + 2 Σ ρ_l is
// their integrated autocorrelation time, from the first pairs of lags with a positive sum (Geyer,
// Statist. Sci. 7 (1992) 473), not below 1. A single member has the variance of the other sample.

/// Vectors of equal length, in the order of time.
using Samples = std::vector<std::vector<double>>;

/// Difference of two means.
struct MeanDifference {
  double size = 0;        ///< ‖x̄ − ȳ‖
  double expected = NAN;  ///< its root mean square if the true means are equal; NaN: unknown
  double limit = NAN;     ///< exceeded with the probability of error if the true means are equal
};

/// Compares the means of two samples. `common`: u. `error`: probability of error of the limit.
MeanDifference difference_of_means(const Samples& x, const Samples& y, double common, double error);

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
