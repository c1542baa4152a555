// Applied forces, their potential, and the powers of what has none.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/system.hpp"

namespace freeplay {
namespace {

inline double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }
inline double theta(const double* q, int body) { return body == ground ? 0 : q[3 * body + 2]; }
inline double omega(const double* v, int body) { return body == ground ? 0 : v[3 * body + 2]; }

void add_torque(const std::array<int, 2>& pair, double torque, std::vector<double>& f) {
  if (pair[0] != ground) f[3 * pair[0] + 2] -= torque;
  if (pair[1] != ground) f[3 * pair[1] + 2] += torque;
}

double interpolate(const std::vector<std::pair<double, double>>& table, double x) {
  if (x <= table.front().first) return table.front().second;
  if (x >= table.back().first) return table.back().second;
  const auto hi = std::ranges::upper_bound(table, x, {}, &std::pair<double, double>::first);
  const auto lo = hi - 1;
  return lo->second + (hi->second - lo->second) * (x - lo->first) / (hi->first - lo->first);
}

/// One turn of a table against an angle, closed from its last point to its first.
double interpolate_periodic(const std::vector<std::pair<double, double>>& table, double angle) {
  constexpr double turn = 2 * std::numbers::pi;
  const double first = table.front().first, last = table.back().first;
  const double x = first + (angle - first) - turn * std::floor((angle - first) / turn);
  if (x <= last) return interpolate(table, x);
  const double s = (x - last) / (first + turn - last);
  return table.back().second + s * (table.front().second - table.back().second);
}

}  // namespace

double System::torque_of(const std::array<int, 2>& pair, const TorqueDrive& drive, double t,
                         const double* q) const {
  if (drive.table.size() == 1) return drive.table.front().second;
  if (drive.against == TorqueDrive::Against::time) return interpolate(drive.table, t);
  return interpolate_periodic(drive.table, theta(q, pair[1]) - theta(q, pair[0]));
}

double System::next_knot(double t) const {
  double next = INFINITY;
  for (const auto& [pair, drive] : torque_drives_)
    if (drive.against == TorqueDrive::Against::time && drive.table.size() > 1)
      for (const auto& knot : drive.table)
        if (knot.first > t) next = std::min(next, knot.first);
  return next;
}

void System::add_force(const Link& link, const Arms& a, const Vec2& force, std::vector<double>& f) const {
  const auto push = [&](int body, const Vec2& arm, const Vec2& x) {
    if (body == ground) return;
    const auto b = (3 * body);
    f[b] += x.x();
    f[b + 1] += x.y();
    f[b + 2] += cross(arm, x);
  };
  push(link.i, a.ri, -force);
  push(link.j, a.rj, force);
}

void System::forces(double t, const double* q, const double* v, Evaluation& e) const {
  std::ranges::copy(constant_force_, e.force.begin());
  e.power = {};
  for (const auto& [pair, drive] : torque_drives_) {
    const double torque = torque_of(pair, drive, t, q);
    add_torque(pair, torque, e.force);
    e.power.drive += torque * (omega(v, pair[1]) - omega(v, pair[0]));
  }
  for (const auto& load : force_loads_) {
    const Link link{ground, load.body, {0, 0}, load.at};
    const Arms a = arms(link, q, e);
    add_force(link, a, load.force, e.force);
    e.power.load += load.force.dot(relative_velocity(link, a, v));
  }
  for (const auto& load : torque_loads_) {
    add_torque({ground, load.body}, load.torque, e.force);
    e.power.load += load.torque * omega(v, load.body);
  }
  for (const auto& [link, s] : springs_) {
    const Arms a = arms(link, q, e);
    const double length = std::sqrt(a.d.squaredNorm());
    if (!(length > 0)) continue;  // no direction: no force
    const Vec2 along = a.d / length;
    const double speed = along.dot(relative_velocity(link, a, v));
    add_force(link, a, -(s.stiffness * (length - s.free_length) + s.damping * speed) * along, e.force);
    e.power.damping -= s.damping * speed * speed;
  }
  for (const auto& s : torsions_) {
    const double speed = omega(v, s.between[1]) - omega(v, s.between[0]);
    const double angle = theta(q, s.between[1]) - theta(q, s.between[0]) - s.free_angle;
    add_torque(s.between, -(s.stiffness * angle + s.damping * speed), e.force);
    e.power.damping -= s.damping * speed * speed;
  }
}

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
  const auto point = [&](int body, const Vec2& s) -> Vec2 {
    if (body == ground) return s;
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
