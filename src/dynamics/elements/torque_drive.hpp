// Dynamics of mechanism/elements/torque_drive.hpp, which states the equations.
#pragma once

#include "dynamics/curve_reader.hpp"
#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/torque_drive.hpp"
#include "mechanism/piecewise.hpp"

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
    if constexpr (std::is_same_v<T, double>)
      if (m.reading.sweep) return mean(m, link);
    if (against == Against::time) return interpolate(m.t);
    const T angle = m.angle(link);
    if (!m.piece) return interpolate_periodic(angle);
    // The line through two places within the piece, also beyond its ends.
    const double third = (m.piece->high - m.piece->low) / 3, at = m.piece->low + third;
    const double u = interpolate_periodic(at), slope = (interpolate_periodic(at + third) - u) / third;
    return u + slope * (angle - at);
  }
  /// The table's mean over the interval that a time step covers, so that no pulse falls between two
  /// steps. With the mean rates of the step, the work of an angle's table is exact for the angle
  /// covered.
  double mean(const auto& m, const auto& link) const {
    const bool time = against == Against::time;
    const auto [from, to] =
        time ? std::array{m.t - 0.5 * m.reading.sweep->h, m.t + 0.5 * m.reading.sweep->h} : m.swept(link);
    const double middle = 0.5 * (from + to), width = std::abs(to - from);
    if (!(width > 1e-12 * std::max(1.0, std::abs(middle))))
      return time ? interpolate(middle) : interpolate_periodic(middle);
    const double a = middle - 0.5 * width, whole = time ? 0 : std::floor(width / turn);
    double sum = whole > 0 ? whole * integral(a, a + turn) : 0;
    return (sum + integral(a, a + (width - whole * turn))) / width;
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
    if (x <= table.front().first) return table.front().second;
    if (x >= table.back().first) return table.back().second;
    const auto hi = std::ranges::upper_bound(table, value_of(x), {}, &std::pair<double, double>::first);
    const auto lo = hi - 1;
    return lo->second + (hi->second - lo->second) / (hi->first - lo->first) * (x - lo->first);
  }
  /// One turn of a table of the angle, closed by a line from its last point to its first.
  template <class T>
  T interpolate_periodic(const T& angle) const {
    const double first = table.front().first, last = table.back().first;
    const T x = angle - turn * std::floor((value_of(angle) - first) / turn);
    if (x <= last) return interpolate(x);
    return table.back().second +
           (table.front().second - table.back().second) / (first + turn - last) * (x - last);
  }
};

}  // namespace freeplay
