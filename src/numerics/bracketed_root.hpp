// Root of a function between two places of opposite signs, by algorithm 748 (Alefeld, Potra and Shi, ACM
// Transactions on Mathematical Software 21 (1995) 327; Boost).
#pragma once

#include <boost/math/tools/toms748_solve.hpp>
#include <cstdint>

namespace freeplay {

/// Relative width of the interval that remains, 2^(1−bits), and the greatest number of evaluations.
struct RootSearch {
  unsigned bits = 50;
  std::uintmax_t most = 100;
};

/// Root of f between a and b, where f has the opposite signs fa and fb; b if rounding leaves no interval.
template <class F>
double bracketed_root(F f, double a, double b, double fa, double fb, RootSearch search = {}) {
  if (a >= b) return b;
  const boost::math::tools::eps_tolerance<double> close(search.bits);
  const auto [lo, hi] = boost::math::tools::toms748_solve(f, a, b, fa, fb, close, search.most);
  return 0.5 * (lo + hi);
}

/// The same where f is not known at a and b; `most` includes these two evaluations.
template <class F>
double bracketed_root(F f, double a, double b, RootSearch search) {
  return bracketed_root(f, a, b, f(a), f(b), {search.bits, search.most - 2});
}

}  // namespace freeplay
