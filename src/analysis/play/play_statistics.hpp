// Output play as a distribution: quantiles of an output when each journal and each tooth takes a random place within
// its clearance, independent of the others: uniform on the disc (or its rim), uniform between two opposite contacts
// (or at one of them); and each number with a tolerance (mechanism/tolerance.hpp) takes a random deviation d.
//
// The output h(u, d) of N samples is computed exactly, by closure. Its linear part L = h(0, 0) + a·u + b·d,
// evaluated for many more samples, serves as a control variate of the distribution function (Lavenberg and Welch,
// Management Science 27 (1981) 322):
//
//     F(y) ≈ P(L ≤ y) + (1/N) Σ [1(h_i ≤ y) − 1(L_i ≤ y)].
//
// Only samples between y and their linear part contribute to its error. The standard errors of the quantiles are
// those of the mean over ten parts of the samples.
#pragma once

#include <Eigen/Core>

#include <vector>

#include "analysis/play/play_extremes.hpp"
#include "values/play.hpp"

namespace freeplay {

/// An output to first order, value + a·u + b·d.
struct LinearOutput {
  double value = 0;
  Eigen::VectorXd a, b;
};
/// Output k; b follows from its values at the limits of each tolerance. Needs extremes.enclose() with success.
LinearOutput linear_output(LooseMechanism& mechanism, PlayExtremes& extremes, int k);

/// The contributions of the components, then of the tolerances, to the variance of an output to first order. They
/// sum to 1.
std::vector<double> variance_shares(const LooseMechanism& mechanism, PlayPlace place,
                                    const LinearOutput& output);

/// Quantiles of output k; needs extremes.enclose() with success.
PlayQuantiles play_quantiles(LooseMechanism& mechanism, PlayExtremes& extremes, int k,
                             const PlaySampling& sampling, const LinearOutput& output);

}  // namespace freeplay
