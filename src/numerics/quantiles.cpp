#include "numerics/quantiles.hpp"

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace freeplay {

double normal_quantile(double p) { return boost::math::quantile(boost::math::normal(), p); }
double student_quantile(double freedom, double p) {
  return boost::math::quantile(boost::math::students_t(freedom), p);
}
double chi_squared_quantile(double freedom, double p) {
  return boost::math::quantile(boost::math::chi_squared(freedom), p);
}
double fisher_upper_quantile(double freedom1, double freedom2, double p) {
  return quantile(complement(boost::math::fisher_f(freedom1, freedom2), p));
}
double binomial_above(int n, double p, int k) { return cdf(complement(boost::math::binomial(n, p), k)); }

}  // namespace freeplay
