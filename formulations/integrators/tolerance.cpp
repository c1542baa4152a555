#include "formulations/integrators/tolerance.hpp"

#include <algorithm>
#include <cmath>

#include "model/mechanism.hpp"
#include "model/planar.hpp"
#include "model/system.hpp"
#include "values/state.hpp"

namespace freeplay {

double greatest_speed(const System& system, const double* v) {
  double speed = 0;
  for (int k = 0; k < system.contacts(); ++k) {
    Vec2 apart{0, 0};
    double turning = 0;
    const auto [i, j] = system.contact_facts(k).bodies;
    for (const auto& [body, sign] : {std::pair{i, -1.0}, std::pair{j, 1.0}})
      if (body != ground) {
        apart += sign * planar::velocity(v, body);
        turning += system.longest_arm() * std::abs(planar::rate(v, body));
      }
    speed = std::max(speed, apart.norm() + turning);
  }
  return speed;
}

namespace {

/// Of what loads and torques give the bodies at the start, or a torque's table at its greatest (m/s²).
double greatest_acceleration(const Mechanism& mechanism, const System& system, const State& start,
                             double arm) {
  auto e = system.make_evaluation();
  system.place(start.t, start.q.data(), e);
  system.rate(start.q.data(), start.v.data(), e);
  std::vector<double> z = start.z;
  z.resize(system.states());
  system.forces(start.t, start.q.data(), start.v.data(), z.data(), e, {});
  double most = 0;
  for (int i = 0; i < system.n(); ++i)
    most = std::max(most, std::abs(e.force[i]) / system.mass()[i] * (system.is_angle(i) ? arm : 1));
  for (const auto& drive : mechanism.drives)
    if (const auto* d = std::get_if<TorqueDrive>(&drive))
      for (const int body : bodies_of(mechanism.joints[d->joint]))
        for (const auto& [x, torque] : d->table)
          if (body != ground) most = std::max(most, std::abs(torque) / mechanism.bodies[body].inertia * arm);
  for (const auto& drive : mechanism.drives)
    std::visit(
        [&]<class Kind>(const Kind& d) {
          if constexpr (requires { d.greatest_effort(mechanism); })
            for (const int body : bodies_of(mechanism.joints[d.joint]))
              if (body != ground)
                most = std::max(most,
                                d.greatest_effort(mechanism) / (Kind::reports == ForceElement::Kind::push
                                                                    ? mechanism.bodies[body].mass
                                                                    : mechanism.bodies[body].inertia / arm));
        },
        drive);
  return std::isfinite(most) ? most : 0;
}

}  // namespace

Scales make_scales(const Mechanism& mechanism, const System& system, const State& start) {
  Scales s;
  const double arm = system.longest_arm() > 0 ? system.longest_arm() : 1;
  s.length = arm;
  for (int k = 0; k < system.contacts(); ++k)
    s.length = std::min(s.length, system.contact_facts(k).clearance);
  double omega = 0;
  for (const auto& drive : mechanism.drives)
    if (const auto* d = std::get_if<SpeedDrive>(&drive)) omega = std::max(omega, std::abs(d->speed));
  double along = 0;          // m/s, of prescribed sliding
  double change = INFINITY;  // s, in which a prescribed rate changes
  for (const auto& drive : mechanism.drives)
    std::visit(
        [&](const auto& d) {
          if constexpr (requires { d.change_time(mechanism); })
            change = std::min(change, d.change_time(mechanism));
          if constexpr (requires { d.pace(mechanism); }) omega = std::max(omega, d.pace(mechanism));
          if constexpr (requires { d.slide_pace(mechanism); })
            along = std::max(along, d.slide_pace(mechanism));
        },
        drive);
  omega = std::max(omega, along / arm);
  s.speed = std::max({s.length * omega, std::sqrt(mechanism.gravity.norm() * s.length), 1e-3 * s.length});
  if (omega == 0 && mechanism.gravity.is_zero()) {
    s.guessed = true;
    s.speed = std::max({s.speed, greatest_speed(system, start.v.data()),
                        std::sqrt(greatest_acceleration(mechanism, system, start, arm) * s.length)});
  }
  s.angle = s.length / arm;
  s.angular_speed = s.speed / arm;
  s.time = std::min(change, omega > 0 ? 1 / omega : s.length / s.speed);
  return s;
}

ErrorNorm motion_norm(const System& system, const Scales& s, double tolerance) {
  ErrorNorm norm;
  norm.tolerance = tolerance;
  const int n = system.n();
  for (int i = 0; i < n; ++i) norm.absolute.push_back(system.is_angle(i) ? s.angle : s.length);
  norm.relative.assign(n, 0);
  for (int i = 0; i < n; ++i) norm.absolute.push_back(system.is_angle(i) ? s.angular_speed : s.speed);
  norm.relative.resize(2 * n, 1);
  return norm;
}

void add_states(ErrorNorm& norm, const System& system, int offset) {
  norm.absolute.resize(offset, INFINITY);
  for (int k = 0; k < system.states(); ++k) norm.absolute.push_back(system.state_scale(k));
  norm.relative.resize(norm.absolute.size(), 0);
}

}  // namespace freeplay
