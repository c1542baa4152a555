#include "numerics/bracketed_root.hpp"

#include <boost/math/tools/toms748_solve.hpp>

namespace freeplay {

double root_between(double (*f)(const void* context, double x), const void* context, double a, double b,
                    double fa, double fb, RootSearch search) {
  if (a >= b) return b;
  const boost::math::tools::eps_tolerance<double> close(search.bits);
  const auto [lo, hi] = boost::math::tools::toms748_solve([&](double x) { return f(context, x); }, a, b, fa,
                                                          fb, close, search.most);
  return 0.5 * (lo + hi);
}

}  // namespace freeplay
