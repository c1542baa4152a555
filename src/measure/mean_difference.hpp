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
#pragma once

#include <cmath>
#include <vector>

namespace freeplay {

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

}  // namespace freeplay
