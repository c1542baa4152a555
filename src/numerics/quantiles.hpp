// Quantiles of distributions, by Boost.Math. Its headers cost seconds of compilation, so that only
// quantiles.cpp includes them.
#pragma once

namespace freeplay {

/// x with the probability p of smaller values, 0 < p < 1, of the standard normal distribution.
double normal_quantile(double p);
/// The same of Student's distribution with `freedom` > 0 degrees of freedom.
double student_quantile(double freedom, double p);
/// The same of the chi-squared distribution.
double chi_squared_quantile(double freedom, double p);

}  // namespace freeplay
