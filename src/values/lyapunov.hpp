// Lyapunov exponents of a motion.
#pragma once

#include <cmath>
#include <string>
#include <vector>

namespace freeplay {

/// One exponent with its standard error.
struct LyapunovExponent {
  double value = NAN;  ///< 1/s; −∞ if the perturbation vanishes in finite time
  double error = NAN;  ///< 1/s, standard error from the batch means; NaN for −∞
  std::string reason;  ///< why the value is −∞; empty if it is finite
};

/// The spectrum of a motion, or the reason why there is none.
struct Lyapunov {
  /// of the mechanism's own degrees of freedom, greatest first; all, or as many as requested
  std::vector<LyapunovExponent> exponents;
  double period = 0;                  ///< s, of the drives; 0 without a known one
  double sum = NAN, sum_error = NAN;  ///< 1/s, of all exponents, and its standard error
  /// 1/s: the sum that follows from the divergence of the smooth flow and from the impacts alone, and its
  /// two parts; NaN if a contact lasts
  double predicted = NAN, divergence = NAN, impact_part = NAN;
  std::string unpredicted;  ///< why there is no predicted sum; empty if there is one
  long impacts = 0;         ///< contact onsets after the transient
  double transient = 0;     ///< s, excluded before
  double duration = 0;      ///< s, of all batches together
  int batches = 0;          ///< of equal length, from which the standard errors follow
  double cost = 0;          ///< evaluations for the tangent vectors over those of the run
  /// Means from the end of the transient to a time.
  struct Sample {
    double t = 0;                   ///< s
    std::vector<double> exponents;  ///< in the order of `exponents`; −∞ where they are
    double sum = 0;                 ///< 1/s, of the exponents
    double predicted = NAN;         ///< 1/s, the predicted sum; NaN if there is none
  };
  std::vector<Sample> course;  ///< convergence of the means, in the order of time
  /// why the run ended before its duration; the results then cover the complete batches before
  std::string stopped;
  std::string failure;  ///< why there are no exponents; empty if there are
};

}  // namespace freeplay
