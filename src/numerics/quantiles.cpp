#include "numerics/quantiles.hpp"

#include <boost/math/distributions/chi_squared.hpp>
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

}  // namespace freeplay
