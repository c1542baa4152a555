#include "formulations/integrators/tolerance.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "mechanism/mechanism.hpp"
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

/// Acceleration of a body by a load or a drive (m/s²), and the time (s) within which the force
/// reverses: infinite if it may last.
struct Push {
  double acceleration = 0, time = INFINITY;
  /// m/s: the speed gained within `length` (m).
  double speed(double length) const {
    const double within = std::sqrt(acceleration * length);
    return std::isfinite(time) ? std::min(within, acceleration * time) : within;
  }
};

/// A force against time without mean gives a mass at most the speed of its greatest impulse, max |∫
/// y dt|. This time (s) is that impulse over max |y|, 2/ω for a sine; infinite for all other
/// courses.
double turning_time(const Piecewise& course) {
  const double period = course.period() > 0      ? course.period()
                        : course.knots().empty() ? course.variation(0)
                                                 : INFINITY;
  if (!std::isfinite(period)) return INFINITY;
  const double most = course.greatest().value;
  if (!(most > 0) || std::abs(course.integral(0, period)) > 1e-9 * most * period) return INFINITY;
  return course.antiderivative(0, 0).greatest().value / most;
}

Piecewise course_of(const ForceDrive& drive, const Mechanism& mechanism) {
  return drive.force.lay(mechanism.curves);
}
Piecewise course_of(const TorqueCurveDrive& drive, const Mechanism& mechanism) {
  return mechanism.curves[static_cast<std::size_t>(drive.curve)].lay();
}

/// Accelerations of the bodies by loads and torques at the start, and by the greatest forces of
/// drives; angles at `arm` (m).
std::vector<Push> pushes(const Mechanism& mechanism, const System& system, const State& start, double arm) {
  std::vector<Push> list;
  const auto n = static_cast<std::size_t>(system.n());
  // N or N m of drives that reverse; s, the longest reversal time of them
  std::vector<double> turning(n, 0), longest(n, 0);
  for (const auto& drive : mechanism.drives)
    if (const auto* d = std::get_if<TorqueDrive>(&drive))
      for (const int body : bodies_of(mechanism.joints[d->joint]))
        for (const auto& [x, torque] : d->table)
          if (body != ground) list.push_back({std::abs(torque) / mechanism.bodies[body].inertia * arm});
  for (const auto& drive : mechanism.drives)
    std::visit(
        [&]<class Kind>(const Kind& d) {
          if constexpr (requires { d.greatest_effort(mechanism); }) {
            constexpr bool along = Kind::reports == ForceElement::Kind::push;
            const double effort = d.greatest_effort(mechanism);
            double time = INFINITY;
            if constexpr (requires { d.against; })
              if (d.against == Argument::time) time = turning_time(course_of(d, mechanism));
            for (const int body : bodies_of(mechanism.joints[d.joint])) {
              if (body == ground) continue;
              const auto& b = mechanism.bodies[body];
              list.push_back({effort / (along ? b.mass : b.inertia / arm), time});
              if (!std::isfinite(time)) continue;
              for (int c = 0; c < planar::coordinates; ++c) {
                const auto i = static_cast<std::size_t>(planar::first(body) + c);
                turning[i] += system.is_angle(static_cast<int>(i)) ? effort * (along ? arm : 1)
                              : along                              ? effort
                                                                   : 0;
                longest[i] = std::max(longest[i], time);
              }
            }
          }
        },
        drive);
  auto e = system.make_evaluation();
  system.place(start.t, start.q.data(), e);
  system.rate(start.q.data(), start.v.data(), e);
  std::vector<double> z = start.z;
  z.resize(static_cast<std::size_t>(system.states()));
  if (!system.sampled().empty()) system.sample(start.t, start.q.data(), start.v.data(), z.data());
  system.forces(start.t, start.q.data(), start.v.data(), z.data(), e, {});
  for (std::size_t i = 0; i < n; ++i) {
    const double force = std::abs(e.force[i]);
    list.push_back({force / system.mass()[i] * (system.is_angle(static_cast<int>(i)) ? arm : 1),
                    force <= turning[i] ? longest[i] : INFINITY});
  }
  std::erase_if(list, [](const Push& push) { return std::isnan(push.acceleration); });
  // Without mass, no speed is known.
  if (std::ranges::any_of(list, [](const Push& push) { return std::isinf(push.acceleration); })) list.clear();
  return list;
}

/// m: the shortest length over which a force changes with position, angles at `arm`: between two
/// kinks, or 1/ω of a sine. Infinite if there is none.
double feature_length(const System& system, const State& start, double arm) {
  double least = INFINITY;
  const auto consider = [&](const Phase& phase, double length) {
    if (length > 0) least = std::min(least, length * (phase.of == Phase::Of::angle ? arm : 1));
  };
  for (int k = 0; k < system.phases(); ++k) {
    const auto& phase = system.phase(k);
    if (phase.speed || phase.contact) continue;
    for (std::size_t i = 1; i < phase.kinks.size(); ++i) consider(phase, phase.kinks[i] - phase.kinks[i - 1]);
  }
  for (const auto& reader : system.curves().readers)
    if (reader.of == CurveReader::Of::place) {
      const double x = reader.argument(start.t, start.q.data(), start.v.data()).value;
      for (const bool above : {false, true}) consider(reader.place, reader.variation(x, above) / Phase::turn);
    }
  return least;
}

}  // namespace

Scales make_scales(const Mechanism& mechanism, const System& system, const State& start) {
  Scales s;
  const double arm = system.size();
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
  double pace = s.speed;  // m/s, for the time scale
  if (omega == 0 && mechanism.gravity.is_zero()) {
    s.guessed = true;
    // A motion within features of its forces may be slower in proportion. Below 1e-4 of the length,
    // rounding of positions would dominate.
    const double within = std::clamp(feature_length(system, start, arm), 1e-4 * s.length, s.length);
    const double fastest = greatest_speed(system, start.v.data());
    s.speed = std::max(1e-3 * within, fastest);
    pace = std::max(pace, fastest);
    for (const auto& push : pushes(mechanism, system, start, arm)) {
      s.speed = std::max(s.speed, push.speed(within));
      pace = std::max(pace, std::sqrt(push.acceleration * s.length));
    }
  }
  s.fastest = std::max({s.speed, arm * omega, std::sqrt(mechanism.gravity.norm() * arm),
                        greatest_speed(system, start.v.data())});
  s.angle = s.length / arm;
  s.angular_speed = s.speed / arm;
  s.time = std::min(change, omega > 0 ? 1 / omega : s.length / pace);
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
