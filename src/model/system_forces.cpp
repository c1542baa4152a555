// Applied forces, their potential, and the powers of what has none.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/plane.hpp"

namespace freeplay {
namespace {

template <class T>
void add_torque(const std::array<int, 2>& pair, const T& torque, std::vector<T>& f) {
  if (pair[0] != ground) f[3 * pair[0] + 2] -= torque;
  if (pair[1] != ground) f[3 * pair[1] + 2] += torque;
}

/// A force on the second body at its arm, and its reaction on the first.
template <class T>
void add_force(int i, const Vec2Of<T>& ri, int j, const Vec2Of<T>& rj, const Vec2Of<T>& force,
               std::vector<T>& f) {
  const auto push = [&](int body, const Vec2Of<T>& arm, double sign) {
    if (body == ground) return;
    f[3 * body] += sign * force.x();
    f[3 * body + 1] += sign * force.y();
    f[3 * body + 2] += sign * cross(arm, force);
  };
  push(i, ri, -1);
  push(j, rj, 1);
}

template <class T>
T interpolate(const std::vector<std::pair<double, double>>& table, const T& x) {
  if (x <= table.front().first) return table.front().second;
  if (x >= table.back().first) return table.back().second;
  const auto hi = std::ranges::upper_bound(table, value_of(x), {}, &std::pair<double, double>::first);
  const auto lo = hi - 1;
  return lo->second + (hi->second - lo->second) / (hi->first - lo->first) * (x - lo->first);
}

/// One turn of a table against an angle, closed from its last point to its first.
template <class T>
T interpolate_periodic(const std::vector<std::pair<double, double>>& table, const T& angle) {
  constexpr double turn = 2 * std::numbers::pi;
  const double first = table.front().first, last = table.back().first;
  const T x = angle - turn * std::floor((value_of(angle) - first) / turn);
  if (x <= last) return interpolate(table, x);
  return table.back().second +
         (table.front().second - table.back().second) / (first + turn - last) * (x - last);
}

}  // namespace

/// A torque drive's table, before any lag.
template <class T>
static T demand(const std::array<int, 2>& pair, const TorqueDrive& drive, const T& t, const T* q) {
  if (drive.table.size() == 1) return drive.table[0].second;
  if (drive.against == TorqueDrive::Against::time) return interpolate(drive.table, t);
  return interpolate_periodic(drive.table, T(theta(q, pair[1]) - theta(q, pair[0])));
}

template <class T>
T System::torque_of(std::size_t drive, const T& t, const T* q, const T* z) const {
  if (state_of_drive_[drive] >= 0) return z[state_of_drive_[drive]];
  return demand(torque_drives_[drive].first, torque_drives_[drive].second, t, q);
}
template double System::torque_of(std::size_t, const double&, const double*, const double*) const;

template <class T>
void System::flow(std::type_identity_t<T> t, const T* q, const T* z, T* dz) const {
  for (const auto& lagged : lagged_) {
    const auto& [pair, drive] = torque_drives_[lagged.drive];
    *dz++ = (demand(pair, drive, t, q) - *z++) / *drive.lag;
  }
}
template void System::flow(double, const double*, const double*, double*) const;
template void System::flow(Gradient, const Gradient*, const Gradient*, Gradient*) const;

double System::next_knot(double t) const {
  double next = INFINITY;
  for (const auto& [pair, drive] : torque_drives_)
    if (drive.against == TorqueDrive::Against::time && drive.table.size() > 1)
      for (const auto& knot : drive.table)
        if (knot.first > t) next = std::min(next, knot.first);
  return next;
}

template <class T>
void System::forces(std::type_identity_t<T> t, const T* q, const T* v, const T* z, EvaluationOf<T>& e) const {
  using std::sqrt;
  std::ranges::copy(constant_force_, e.force.begin());
  e.power = {};
  for (std::size_t k = 0; k < torque_drives_.size(); ++k) {
    const auto& pair = torque_drives_[k].first;
    const T torque = torque_of(k, t, q, z);
    add_torque(pair, torque, e.force);
    e.power.drive += torque * (omega(v, pair[1]) - omega(v, pair[0]));
  }
  for (const auto& load : force_loads_) {
    const Link link{ground, load.body, {0, 0}, load.at};
    const Arms<T> a = arms(link, q, e);
    const Vec2Of<T> force{T(load.force.x()), T(load.force.y())};
    add_force(link.i, a.ri, link.j, a.rj, force, e.force);
    e.power.load += dot(force, relative_velocity(link, a, v));
  }
  for (const auto& load : torque_loads_) {
    add_torque({ground, load.body}, T(load.torque), e.force);
    e.power.load += load.torque * omega(v, load.body);
  }
  for (const auto& [link, s] : springs_) {
    const Arms<T> a = arms(link, q, e);
    const T length = sqrt(dot(a.d, a.d));
    if (!(length > 0)) continue;  // no direction: no force
    const Vec2Of<T> along{a.d.x() / length, a.d.y() / length};
    const T speed = dot(along, relative_velocity(link, a, v));
    const T pull = s.stiffness * (length - s.free_length) + s.damping * speed;
    add_force(link.i, a.ri, link.j, a.rj, Vec2Of<T>{-pull * along.x(), -pull * along.y()}, e.force);
    e.power.damping -= s.damping * speed * speed;
  }
  for (const auto& s : torsions_) {
    const T speed = omega(v, s.between[1]) - omega(v, s.between[0]);
    const T angle = theta(q, s.between[1]) - theta(q, s.between[0]) - s.free_angle;
    add_torque(s.between, T(-(s.stiffness * angle + s.damping * speed)), e.force);
    e.power.damping -= s.damping * speed * speed;
  }
}

template void System::forces(double, const double*, const double*, const double*, Evaluation&) const;
template void System::forces(Gradient, const Gradient*, const Gradient*, const Gradient*,
                             EvaluationOf<Gradient>&) const;

double System::kinetic(const double* v) const {
  double sum = 0;
  for (std::size_t i = 0; i < mass_.size(); ++i) sum += 0.5 * mass_[i] * v[i] * v[i];
  return sum;
}

double System::potential(const double* q) const {
  double sum = 0;
  for (std::size_t b = 0; b < mass_.size(); b += 3)
    sum -= mass_[b] * (gravity_.x() * q[b] + gravity_.y() * q[b + 1]);
  if (springs_.empty() && torsions_.empty()) return sum;
  const auto point = [&](int body, const Vec2& s) -> Vec2Of<double> {
    if (body == ground) return {s.x(), s.y()};
    const double c = std::cos(q[3 * body + 2]), sn = std::sin(q[3 * body + 2]);
    return {q[3 * body] + c * s.x() - sn * s.y(), q[3 * body + 1] + sn * s.x() + c * s.y()};
  };
  for (const auto& [link, s] : springs_) {
    const double x =
        std::sqrt((point(link.j, link.sj) - point(link.i, link.si)).squaredNorm()) - s.free_length;
    sum += 0.5 * s.stiffness * x * x;
  }
  for (const auto& s : torsions_) {
    const double x = theta(q, s.between[1]) - theta(q, s.between[0]) - s.free_angle;
    sum += 0.5 * s.stiffness * x * x;
  }
  return sum;
}

}  // namespace freeplay
