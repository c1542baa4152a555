// Quantiles and probabilities of distributions, by Boost.Math. Its headers cost seconds of compilation, so that only
// quantiles.cpp includes them.
#pragma once

namespace freeplay {

/// x with the probability p of smaller values, 0 < p < 1, of the standard normal distribution.
double normal_quantile(double p);
/// The same of Student's distribution with `freedom` > 0 degrees of freedom.
double student_quantile(double freedom, double p);
/// The same of the chi-squared distribution.
double chi_squared_quantile(double freedom, double p);
/// x with the probability p of greater values of Fisher's distribution with two degrees of freedom,
/// both > 0.
double fisher_upper_quantile(double freedom1, double freedom2, double p);
/// Probability of more than k successes in n trials of probability p each.
double binomial_above(int n, double p, int k);

}  // namespace freeplay
