// Root of a function between two places of opposite signs, by algorithm 748 (Alefeld, Potra and Shi, ACM
// Transactions on Mathematical Software 21 (1995) 327; Boost). Boost's headers cost seconds of compilation, so that
// only bracketed_root.cpp includes them.
#pragma once

#include <cstdint>

namespace freeplay {

/// Relative width of the interval that remains, 2^(1−bits), and the greatest number of evaluations.
struct RootSearch {
  unsigned bits = 50;
  std::uintmax_t most = 100;
};

/// bracketed_root of f(context, x).
double root_between(double (*f)(const void* context, double x), const void* context, double a, double b,
                    double fa, double fb, RootSearch search);

/// Root of f between a and b, where f has the opposite signs fa and fb; b if rounding leaves no interval.
template <class F>
double bracketed_root(const F& f, double a, double b, double fa, double fb, RootSearch search = {}) {
  return root_between([](const void* g, double x) -> double { return (*static_cast<const F*>(g))(x); }, &f, a,
                      b, fa, fb, search);
}

/// The same where f is not known at a and b; `most` includes these two evaluations.
template <class F>
double bracketed_root(const F& f, double a, double b, RootSearch search) {
  return bracketed_root(f, a, b, f(a), f(b), {search.bits, search.most - 2});
}

}  // namespace freeplay
