// A piecewise function of one variable. On stretch k, with u = x − x_k,
//
//     f(x) = Σ_n c_n uⁿ + A sin(ω u + φ),
//
// so its derivatives and its integral are exact. Outside all stretches the first and the last one
// continue. Alternatively the function repeats with a period, and each period adds `gain`.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "numerics/choice.hpp"

namespace freeplay {

// Cubic splines with continuous second derivative, by their slopes m_i at knots x_i with values
// y_i. Within an interval of width h, s = (x − x_i)/h,
//
//     y = y_i + h m_i s + (3 d − h (2 m_i + m_{i+1})) s² + (h (m_i + m_{i+1}) − 2 d) s³,
//     d = y_{i+1} − y_i
//
// and m solves
//
//     m_{i−1}/h_{i−1} + 2 (1/h_{i−1} + 1/h_i) m_i + m_{i+1}/h_i = 3 (d_{i−1}/h_{i−1}² + d_i/h_i²)
//
// (de Boor, A Practical Guide to Splines, ch. IV).

enum class SplineEnds {
  natural,  ///< second derivative 0
  flat,     ///< first derivative 0
  periodic  ///< derivatives are periodic; the values may differ by a constant for each period
};

/// Slopes at the knots: at least two, x increasing.
std::vector<double> spline_slopes(const std::vector<std::pair<double, double>>& knots, SplineEnds ends);

/// A function's value with its first and second derivative.
template <class T>
struct Jet {
  T value = 0, slope = 0, bend = 0;
};

class Piecewise {
 public:
  static constexpr int terms = 7;
  static_assert(terms % 2 == 1);
  /// P: double, or the traced entries of a table of stretches.
  template <class P>
  struct StretchOf {
    /// End of the previous stretch; of the first stretch, read only if the function repeats.
    P begin = 0;
    std::array<P, terms> c{};
    P amplitude = 0, rate = 0, phase = 0;
    P origin = 0;  ///< u = x − origin
  };
  using Stretch = StretchOf<double>;

  Piecewise() : Piecewise({Stretch{}}) {}
  /// `stretches`: at least one, in increasing order.
  explicit Piecewise(std::vector<Stretch> stretches, double period = 0, double gain = 0)
      : stretches_(std::move(stretches)), period_(period), gain_(gain) {}

  double period() const { return period_; }
  bool is_constant() const {
    const auto& s = stretches_.front();
    return stretches_.size() == 1 && s.amplitude == 0 && gain_ == 0 &&
           std::all_of(s.c.begin() + 1, s.c.end(), [](double x) { return x == 0; });
  }

  /// @name Evaluation at x
  /// `within`: uses the stretch that contains this place, also beyond its ends.
  ///@{
  template <class T>
  T value(const T& x) const {
    return value(x, x);
  }
  template <class T>
  T value(const T& x, const T& within) const {
    using std::sin;
    const auto p = find(within);
    const auto& s = stretch(p.index);
    const T u = x - (s.origin + p.shift);
    T y = s.c[terms - 1];
    for (int n = terms - 2; n >= 0; --n) y = y * u + s.c[n];
    if (!vanishes(s.amplitude)) y += s.amplitude * sin(s.rate * u + s.phase);
    return y + p.above;
  }
  template <class T>
  Jet<T> jet(const T& x) const {
    return jet(x, x);
  }
  template <class T>
  Jet<T> jet(const T& x, const T& within) const {
    using std::cos, std::sin;
    const auto p = find(within);
    const auto& s = stretch(p.index);
    const T u = x - (s.origin + p.shift);
    Jet<T> j{T(s.c[terms - 1]), T(0), T(0)};
    for (int n = terms - 2; n >= 0; --n) {
      j.bend = j.bend * u + 2 * j.slope;
      j.slope = j.slope * u + j.value;
      j.value = j.value * u + s.c[n];
    }
    if (!vanishes(s.amplitude)) {
      const T angle = s.rate * u + s.phase;
      const T up = s.amplitude * sin(angle), along = s.amplitude * cos(angle);
      j.value += up;
      j.slope += s.rate * along;
      j.bend -= s.rate * s.rate * up;
    }
    j.value += p.above;
    return j;
  }
  ///@}

  /// ∫ f from a to b.
  double integral(double a, double b) const {
    if (b < a) return -integral(b, a);
    if (period_ > 0 && b - a > period_) {
      const double turns = std::floor((b - a) / period_), first = by_stretches(a, a + period_);
      const double to = a + turns * period_;
      return turns * first + gain_ * period_ * turns * (turns - 1) / 2 + by_stretches(to, b);
    }
    return by_stretches(a, b);
  }
  /// Mean of f between a and b; f if they are equal.
  double mean(double a, double b) const {
    const double middle = 0.5 * (a + b);
    if (!(std::abs(b - a) > 1e-12 * std::max(1.0, std::abs(middle)))) return value(middle);
    return integral(a, b) / (b - a);
  }
  /// The same in a trace, whose guards require that no knot is between a and b, and a ≠ b.
  Traced mean(const Traced& a, const Traced& b) const;
  /// F with F′ = f and F(at) = value.
  Piecewise antiderivative(double at, double value) const;

  /// Knots, the places where stretches meet, increasing: all of them, or those of one period.
  std::vector<double> knots() const {
    std::vector<double> list;
    for (std::size_t k = period_ > 0 ? 0 : 1; k < stretches_.size(); ++k) list.push_back(stretches_[k].begin);
    return list;
  }
  /// The first knot after x; infinite if there is none.
  double next_knot(double x) const {
    if (period_ == 0) {
      const auto next = std::upper_bound(stretches_.begin() + 1, stretches_.end(), x, behind);
      return next == stretches_.end() ? INFINITY : next->begin;
    }
    const double shift = period_ * std::floor((x - stretches_.front().begin) / period_);
    for (const double more : {shift, shift + period_, shift + 2 * period_}) {
      auto next = std::upper_bound(stretches_.begin(), stretches_.end(), x - more, behind);
      while (next != stretches_.end() && !(next->begin + more > x)) ++next;  // rounding
      if (next != stretches_.end()) return next->begin + more;
    }
    return x + period_;
  }
  /// The length over which the stretch at x varies (dynamics/phase.hpp); infinite for a
  /// straight line.
  double variation(double x) const {
    const auto& s = stretches_[find(x).index];
    if (s.amplitude != 0) return 6.283185307179586 / std::abs(s.rate);
    int degree = terms - 1;
    while (degree > 0 && s.c[static_cast<std::size_t>(degree)] == 0) --degree;
    if (degree < 2) return INFINITY;
    const bool last = &s == &stretches_.back();
    if (period_ == 0 && (last || &s == &stretches_.front())) return INFINITY;
    const double length = (last ? stretches_.front().begin + period_ : (&s + 1)->begin) - s.begin;
    return degree < 4 ? 4 * length : length;
  }
  /// Absolute jumps of the value and of its first and second derivative at a knot.
  Jet<double> jump(double knot) const {
    const double after = 0.5 * (knot + std::min(next_knot(knot), knot + 1)), before = before_knot(knot);
    const auto a = jet(knot, before), b = jet(knot, after);
    return {std::abs(b.value - a.value), std::abs(b.slope - a.slope), std::abs(b.bend - a.bend)};
  }
  /// The greatest |f|, |f′| and |f″| among samples of the stretches, starting at 0 or at the first
  /// knot.
  Jet<double> greatest() const;

 private:
  template <class P>
  struct Place {
    IndexOf<P> index;  ///< of the stretch
    P shift, above;    ///< of its period
  };
  static bool behind(double x, const Stretch& s) { return x < s.begin; }
  template <class P>
  Place<P> find(const P& x) const {
    P turns = 0;
    if (period_ > 0) turns = floor_of((x - stretches_.front().begin) / period_);
    const P shift = turns * period_;
    return {interval_of(stretches_.size() - 1, P(x - shift),
                        [&](std::size_t k) { return stretches_[k + 1].begin; }),
            shift, turns * gain_};
  }
  const Stretch& stretch(std::size_t index) const { return stretches_[index]; }
  StretchOf<Traced> stretch(const Traced& index) const;
  double by_stretches(double a, double b) const {
    double sum = 0, at = a;
    while (at < b) {
      const double next = std::min(next_knot(at), b), middle = at + 0.5 * (next - at);
      sum += (next - at) * level(middle, 0.5 * (next - at));
      at = next;
    }
    return sum;
  }
  /// The mean from middle − d to middle + d on the stretch around `middle`, from its Taylor series
  /// there:
  ///     Σ_k even f⁽ᵏ⁾ dᵏ/(k + 1)!    and    A sin(·) sin(ωd)/(ωd).
  /// A difference of two integrals would lose most digits over a short interval.
  template <class P>
  P level(const P& middle, const P& d) const {
    using std::sin;
    const auto p = find(middle);
    const auto& s = stretch(p.index);
    const P u = middle - (s.origin + p.shift);
    auto t = s.c;  // f⁽ᵏ⁾/k! by repeated Horner schemes
    for (int k = 0; k < terms; ++k)
      for (int n = terms - 2; n >= k; --n) t[n] += u * t[n + 1];
    P y = 0;
    for (int k = terms - 1; k >= 0; k -= 2) y = y * d * d + t[k] / (k + 1);
    if (!vanishes(s.amplitude)) {
      const P w = s.rate * d, ratio = choose(
                                  is_equal(w, 0), [&] { return P(1); }, [&] { return P(sin(w) / w); });
      y += s.amplitude * sin(s.rate * u + s.phase) * ratio;
    }
    return y + p.above;
  }
  /// A place on the stretch that ends at a knot.
  double before_knot(double knot) const {
    double last = period_ > 0 ? knot - period_ : knot - 1;
    for (double at = last; at < knot; at = next_knot(at)) last = at;
    return 0.5 * (last + knot);
  }
  std::vector<Stretch> stretches_;
  double period_ = 0, gain_ = 0;
};

}  // namespace freeplay
