// Forward differentiation: a number with its derivatives in N directions, computed by the chain
// rule, so that a Jacobian is exact to rounding. (Eigen's AutoDiffScalar keeps expressions, which
// Vec2Of cannot store; Boost.Math's autodiff computes higher orders, which are not needed.)
#pragma once

#include <array>
#include <cmath>

#include "values/vec2.hpp"

namespace freeplay {

template <int N>
struct Dual {
  double value = 0;
  std::array<double, N> slope{};

  Dual() = default;
  Dual(double x) : value(x) {}  // a constant
  /// f(x) with the derivative f' at x.value.
  Dual chain(double f, double derivative) const {
    Dual r(f);
    for (int i = 0; i < N; ++i) r.slope[i] = derivative * slope[i];
    return r;
  }

  /// The derivative along a change of all directions.
  double along(const std::array<double, N>& change) const {
    double sum = 0;
    for (int i = 0; i < N; ++i) sum += slope[i] * change[i];
    return sum;
  }

  Dual& operator+=(const Dual& o) {
    value += o.value;
    for (int i = 0; i < N; ++i) slope[i] += o.slope[i];
    return *this;
  }
  Dual& operator-=(const Dual& o) {
    value -= o.value;
    for (int i = 0; i < N; ++i) slope[i] -= o.slope[i];
    return *this;
  }
  Dual& operator*=(const Dual& o) {
    for (int i = 0; i < N; ++i) slope[i] = slope[i] * o.value + value * o.slope[i];
    value *= o.value;
    return *this;
  }
  Dual& operator/=(const Dual& o) {
    value /= o.value;
    for (int i = 0; i < N; ++i) slope[i] = (slope[i] - value * o.slope[i]) / o.value;
    return *this;
  }
  friend Dual operator+(Dual a, const Dual& b) { return a += b; }
  friend Dual operator-(Dual a, const Dual& b) { return a -= b; }
  friend Dual operator*(Dual a, const Dual& b) { return a *= b; }
  friend Dual operator/(Dual a, const Dual& b) { return a /= b; }
  friend Dual operator-(const Dual& a) { return a.chain(-a.value, -1); }
  friend auto operator<=>(const Dual& a, const Dual& b) { return a.value <=> b.value; }
  friend bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }

  friend Dual sqrt(const Dual& x) {
    const double r = std::sqrt(x.value);
    return x.chain(r, r > 0 ? 0.5 / r : 0);
  }
  friend Dual abs(const Dual& x) { return x.value < 0 ? -x : x; }
  friend Dual sin(const Dual& x) { return x.chain(std::sin(x.value), std::cos(x.value)); }
  friend Dual cos(const Dual& x) { return x.chain(std::cos(x.value), -std::sin(x.value)); }
  friend Dual exp(const Dual& x) {
    const double e = std::exp(x.value);
    return x.chain(e, e);
  }
  friend Dual pow(const Dual& x, double p) {
    return x.chain(std::pow(x.value, p), p * std::pow(x.value, p - 1));
  }
  friend Dual log(const Dual& x) { return x.chain(std::log(x.value), 1 / x.value); }
  friend Dual tanh(const Dual& x) {
    const double y = std::tanh(x.value);
    return x.chain(y, 1 - y * y);
  }
  friend Dual atan2(const Dual& y, const Dual& x) {
    const double r2 = x.value * x.value + y.value * y.value;
    Dual r(std::atan2(y.value, x.value));
    for (int i = 0; i < N; ++i) r.slope[i] = (x.value * y.slope[i] - y.value * x.slope[i]) / r2;
    return r;
  }
};

/// Numbers that are the directions of their derivatives.
template <int N>
std::array<Dual<N>, N> directions_of(const std::array<double, N>& x) {
  std::array<Dual<N>, N> list{};
  for (int i = 0; i < N; ++i) {
    list[i] = x[i];
    list[i].slope[i] = 1;
  }
  return list;
}

template <int N>
double value_of(const Dual<N>& x) {
  return x.value;
}

}  // namespace freeplay
