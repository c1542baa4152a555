// Force, kinks and energy of a SpringLaw; mechanism/elements/spring_law.hpp states the equations.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "dynamics/kinematics.hpp"
#include "mechanism/elements/spring_law.hpp"
#include "numerics/choice.hpp"

namespace freeplay {

struct SpringForce : SpringLaw {
  /// E, with the line or polynomial that is valid at `at`.
  template <class T>
  T elastic(double stiffness, double rest, const T& s, const T& at) const {
    if (!table.empty()) return line(table, segment(table, at), s);
    const T x = s - rest;
    return preload.value_or(0) + x * (stiffness + cubic.value_or(0) * x * x);
  }
  template <class T>
  T damper(double damping, const T& rate) const {
    if (damping_table.empty()) return damping * rate;
    return line(damping_table, segment(damping_table, rate), rate);
  }
  /// F, and the part of it that is not a derivative of U.
  template <class T>
  struct Force {
    T whole{0}, damping{0};
    friend Force select(const Traced& condition, const Force& a, const Force& b) {
      return {select(condition, a.whole, b.whole), select(condition, a.damping, b.damping)};
    }
  };
  /// `rate` is used only if there is a damper.
  template <class T>
  Force<T> force(double stiffness, double rest, double damper_rate, const T& s, const T& rate,
                 const PieceOf<T>* piece) const {
    const T at = piece ? piece->inside() : s;
    const auto taut = [&] { return force_at(stiffness, rest, damper_rate, s, rate, at); };
    if (!one_way) return taut();
    return choose(pushes_back(elastic(stiffness, rest, at, at)), taut, [] { return Force<T>{}; });
  }

  /// Places, increasing, where E changes its slope or, for a one-sided spring, its sign. Places
  /// where the spring does not act are omitted.
  std::vector<double> kinks(double stiffness, double rest) const {
    std::vector<double> list;
    const auto e = [&](double s) { return elastic(stiffness, rest, s, s); };
    if (table.empty()) {
      if (one_way) list.push_back(root(stiffness, rest));
      return list;
    }
    const std::size_t n = table.size();
    double steepest = 0;
    for (std::size_t i = 0; i + 1 < n; ++i) steepest = std::max(steepest, std::abs(slope(table, i)));
    for (std::size_t i = 1; i + 1 < n; ++i)
      if (std::abs(slope(table, i) - slope(table, i - 1)) > 1e-9 * steepest && acts(e(table[i].first)))
        list.push_back(table[i].first);
    if (one_way)
      for (std::size_t i = 0; i + 1 < n; ++i) {
        const double k = slope(table, i);
        if (k == 0) continue;
        const double zero = table[i].first - table[i].second / k;
        const bool from = i == 0 || zero >= table[i].first, to = i + 2 == n || zero <= table[i + 1].first;
        if (from && to) list.push_back(zero);
      }
    std::ranges::sort(list);
    const auto same = [](double a, double b) { return b - a <= 1e-12 * std::max(std::abs(a), std::abs(b)); };
    list.erase(std::unique(list.begin(), list.end(), same), list.end());
    return list;
  }

  /// U relative to the place where E is zero, to the rest position, or to a table's first point.
  double energy(double stiffness, double rest, double s) const {
    if (table.empty()) {
      const auto stored = [&](double at) {
        const double x = at - rest;
        return x * (preload.value_or(0) + x * (0.5 * stiffness + 0.25 * cubic.value_or(0) * x * x));
      };
      if (!one_way) return stored(s);
      const double zero = root(stiffness, rest);
      return acts(elastic(stiffness, rest, s, s)) ? stored(s) - stored(zero) : 0;
    }
    const double from = table.front().first, a = std::min(from, s), b = std::max(from, s);
    double sum = 0, at = a;
    for (std::size_t i = 0; i + 1 < table.size(); ++i) {
      const double end = i + 2 == table.size() ? b : std::min(b, table[i + 1].first);
      if (end > at) {
        sum += area(at, line(table, i, at), end, line(table, i, end));
        at = end;
      }
    }
    return s < from ? -sum : sum;
  }

 private:
  /// The force where the spring acts; `at`: a place on the line that is valid.
  template <class T>
  Force<T> force_at(double stiffness, double rest, double damper_rate, const T& s, const T& rate,
                    const T& at) const {
    const T e = elastic(stiffness, rest, s, at);
    if (!damps(damper_rate)) return {e, T(0)};
    const T resists = damper(damper_rate, rate);
    const T whole = e + resists;
    if (!one_way) return {whole, whole - e};
    const auto inside = [&]() -> Force<T> {
      const T some = choose(
          pushes_back(whole), [&] { return whole; }, [] { return T(0); });
      return {some, some - e};
    };
    const auto beyond = [&] {  // the piece, without a jump at its end
      return choose(
          pushes_back(resists),
          [&]() -> Force<T> {
            return {whole, resists};
          },
          [&]() -> Force<T> {
            return {e, T(0)};
          });
    };
    return choose(pushes_back(e), inside, beyond);
  }
  /// Whether a one-sided spring exerts a force of this sign.
  template <class T>
  auto pushes_back(const T& force) const {
    return *one_way == OneWay::pull ? is_below(0, force) : is_below(force, 0);
  }
  /// The index of the line that is valid at s.
  template <class P>
  static auto segment(const SpringTable& t, const P& s) {
    return interval_of(t.size() - 2, s, [&](std::size_t i) { return t[i + 1].first; });
  }
  static double slope(const SpringTable& t, std::size_t i) {
    return (t[i + 1].second - t[i].second) / (t[i + 1].first - t[i].first);
  }
  template <class T, class Index>
  static T line(const SpringTable& t, const Index& i, const T& s) {
    const auto entry = [&](auto f) { return entry_of(t.size() - 1, i, f); };
    return entry([&](std::size_t k) { return t[k].second; }) +
           entry([&](std::size_t k) { return slope(t, k); }) *
               (s - entry([&](std::size_t k) { return t[k].first; }));
  }
  /// ∫ of the acting part of a line.
  double area(double a, double ea, double b, double eb) const {
    if (acts(ea) && acts(eb)) return 0.5 * (b - a) * (ea + eb);
    if (!acts(ea) && !acts(eb)) return 0;
    const double width = (b - a) * (acts(ea) ? ea / (ea - eb) : eb / (eb - ea));
    return 0.5 * width * (acts(ea) ? ea : eb);
  }
  /// Root of preload + stiffness x + cubic x³, which increases. Newton's method starts on the side
  /// where it converges monotonically.
  double root(double stiffness, double rest) const {
    const double p = preload.value_or(0), c = cubic.value_or(0);
    if (p == 0) return rest;
    double x = stiffness > 0 ? -p / stiffness : -std::cbrt(p / c);
    if (c > 0 && stiffness > 0) {
      if (const double other = -std::cbrt(p / c); std::abs(other) < std::abs(x)) x = other;
      for (int i = 0; i < 60; ++i) {
        const double step = (p + x * (stiffness + c * x * x)) / (stiffness + 3 * c * x * x);
        x -= step;
        if (std::abs(step) <= 1e-16 * std::abs(x)) break;
      }
    }
    return rest + x;
  }
};

}  // namespace freeplay
