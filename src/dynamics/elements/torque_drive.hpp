// Dynamics of mechanism/elements/torque_drive.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "dynamics/phase.hpp"
#include "mechanism/elements/torque_drive.hpp"
#include "mechanism/piecewise.hpp"
#include "numerics/choice.hpp"

namespace freeplay {

template <>
struct Dynamics<TorqueDrive> : TorqueDrive {
  auto link(auto& b) const { return b.joint_link(joint); }
  bool does_work() const { return true; }
  bool has_state() const { return lag.has_value(); }
  /// Scale of errors of the state (N m).
  double state_scale() const {
    double greatest = 0;
    for (const auto& point : table) greatest = std::max(greatest, std::abs(point.second));
    return greatest > 0 ? greatest : 1;
  }
  template <class T>
  T flow(const auto& m, const auto& link, const T& z) const {
    return (demand<T>(m, link) - z) / *lag;
  }
  /// `z` is nullptr without a state.
  template <class T>
  void act(const auto& m, const auto& link, const T* z, auto& out) const {
    const T torque = z ? *z : demand<T>(m, link);
    out.couple(link, torque);
    out.power.drive += torque * m.spin(link);
  }
  /// Angles (rad) within one turn at which the table's slope changes; empty for a table of time.
  std::vector<double> angle_kinks() const {
    std::vector<double> kinks;
    if (against != Against::angle || table.size() < 2) return kinks;
    const auto n = table.size();
    double steepest = 0;
    std::vector<double> slope(n);  // from each point to the next, across the end of the turn
    for (std::size_t i = 0; i < n; ++i) {
      const auto& next = table[(i + 1) % n];
      const double width = next.first + (i + 1 == n ? turn : 0) - table[i].first;
      slope[i] = width > 1e-9 ? (next.second - table[i].second) / width : 0;
      steepest = std::max(steepest, std::abs(slope[i]));
    }
    for (std::size_t i = 0; i < n; ++i)
      if (std::abs(slope[i] - slope[(i + n - 1) % n]) > 1e-9 * steepest) kinks.push_back(table[i].first);
    if (kinks.size() > 1 && kinks.back() - kinks.front() > turn * (1 - 1e-9))
      kinks.pop_back();  // the same kink
    return kinks;
  }
  /// A table of the angle as steps see it: straight lines between its kinks.
  std::optional<CurveReader> reader(const Link& link) const {
    auto kinks = angle_kinks();
    if (kinks.empty()) return {};
    return CurveReader{name, CurveReader::Of::place, {link, std::move(kinks), turn}};
  }
  /// The first knot of a table of time after t (s); infinite if there is none.
  double next_knot(double t) const {
    if (against == Against::time && table.size() > 1)
      for (const auto& knot : table)
        if (knot.first > t) return knot.first;
    return INFINITY;
  }

 private:
  /// The table's torque, before a lag.
  template <class T>
  T demand(const auto& m, const auto& link) const {
    if (table.size() == 1) return table[0].second;
    if (m.reading.sweep) return mean<T>(m, link);
    if (against == Against::time) return interpolate(m.t);
    const T angle = m.angle(link);
    if (!m.piece) return interpolate_periodic(angle);
    // The line through two places within the piece, also beyond its ends.
    const T third = (m.piece->high - m.piece->low) / 3, at = m.piece->low + third;
    const T u = interpolate_periodic(at), slope = (interpolate_periodic(T(at + third)) - u) / third;
    return u + slope * (angle - at);
  }
  /// The table's mean over the interval that a time step covers, so that no pulse falls between two
  /// steps. With the mean rates of the step, the work of an angle's table is exact for the angle
  /// covered.
  template <class T>
  T mean(const auto& m, const auto& link) const {
    const bool time = against == Against::time;
    const auto [from, to] =
        time ? std::array{T(m.t - 0.5 * m.reading.sweep->h), T(m.t + 0.5 * m.reading.sweep->h)}
             : m.swept(link);
    const T middle = 0.5 * (from + to);
    if constexpr (is_traced<T>) {
      const T width = abs(to - from), a = middle - 0.5 * width;
      require(is_below(1e-12 * max(Traced(1), abs(middle)), width));
      return integral_between_knots(a, T(a + width)) / width;
    } else {
      const double width = std::abs(to - from);
      if (!(width > 1e-12 * std::max(1.0, std::abs(middle))))
        return time ? interpolate(middle) : interpolate_periodic(middle);
      const double a = middle - 0.5 * width, whole = time ? 0 : std::floor(width / turn);
      double sum = whole > 0 ? whole * integral(a, a + turn) : 0;
      return (sum + integral(a, a + (width - whole * turn))) / width;
    }
  }
  /// The same as integral() in a trace, whose guards require that no knot is between a and b.
  Traced integral_between_knots(const Traced& a, const Traced& b) const {
    const bool time = against == Against::time;
    const auto n = table.size();
    const Traced turns = time ? Traced(0) : turn * floor((a - table.front().first) / turn);
    const auto next = interval_of(n, Traced(a - turns), [&](std::size_t k) { return table[k].first; });
    const auto knot = [&](std::size_t before) {
      return entry_of(n + 1, next, [&](std::size_t k) {
        const std::size_t i = k + 1 - before;  // one more than the index
        if (i == 0) return time ? -INFINITY : table[n - 1].first - turn;
        return i <= n ? table[i - 1].first : time ? INFINITY : table[0].first + turn;
      });
    };
    const Traced rounding = 1e-12 * max(Traced(1), max(abs(a), abs(b)));
    require(is_below(knot(1) + turns + rounding, a));
    require(is_below(b + rounding, knot(0) + turns));
    const auto value = [&](const Traced& x) { return time ? interpolate(x) : interpolate_periodic(x); };
    return 0.5 * (b - a) * (value(a) + value(b));
  }
  /// Integral from a to b, at most one turn apart. The trapezoidal rule between knots is exact for
  /// a piecewise linear table.
  double integral(double a, double b) const {
    const bool time = against == Against::time;
    const auto value = [&](double x) { return time ? interpolate(x) : interpolate_periodic(x); };
    double turns = time ? 0 : turn * std::floor((a - table.front().first) / turn);
    std::size_t next = 0;
    while (next < table.size() && table[next].first + turns <= a) ++next;
    double sum = 0, at = a, u = value(a);
    for (;; ++next) {
      if (next == table.size()) {
        if (time) break;
        next = 0;
        turns += turn;
      }
      const double x = table[next].first + turns;
      if (x >= b) break;
      sum += 0.5 * (x - at) * (u + table[next].second);
      at = x;
      u = table[next].second;
    }
    return sum + 0.5 * (b - at) * (u + value(b));
  }
  template <class T>
  T interpolate(const T& x) const {
    const auto n = table.size();
    const auto line = [&] {
      const auto i = interval_of(n - 2, x, [&](std::size_t k) { return table[k + 1].first; });
      const auto entry = [&](auto f) { return entry_of(n - 1, i, f); };
      const auto slope = [&](std::size_t k) {
        return (table[k + 1].second - table[k].second) / (table[k + 1].first - table[k].first);
      };
      return T(entry([&](std::size_t k) { return table[k].second; }) +
               entry(slope) * (x - entry([&](std::size_t k) { return table[k].first; })));
    };
    const auto &first = table.front(), &last = table.back();
    const auto up = [&] { return choose(is_below(x, last.first), line, [&] { return T(last.second); }); };
    return choose(is_below(first.first, x), up, [&] { return T(first.second); });
  }
  /// One turn of a table of the angle, closed by a line from its last point to its first.
  template <class T>
  T interpolate_periodic(const T& angle) const {
    const double first = table.front().first, last = table.back().first;
    const T x = angle - turn * floor_of((angle - first) / turn);
    const auto closing = [&] {
      return T(table.back().second +
               (table.front().second - table.back().second) / (first + turn - last) * (x - last));
    };
    return choose(is_below(last, x), closing, [&] { return interpolate(x); });
  }
};

}  // namespace freeplay
