#include "analysis/periodicity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string_view>
#include <variant>

#include "dynamics/system.hpp"
#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

constexpr double one_turn = 2 * std::numbers::pi;

/// Period of a function of time; 0 if it has none. A prescribed motion of constant rate turns its joint.
double period_of(const Piecewise& course) {
  if (course.period() > 0) return course.period();
  if (!course.knots().empty()) return 0;
  if (const double length = course.variation(0); std::isfinite(length)) return length;
  const double rate = std::abs(course.jet(0.0).slope);
  return rate > 0 ? one_turn / rate : 0;
}

}  // namespace

Excitation excitation_of(const Mechanism& mechanism, const System& system) {
  Excitation found;
  std::vector<double> periods;
  const auto add = [&](const std::string& name, double period) {
    found.any = true;
    if (period > 0)
      periods.push_back(period);
    else if (found.why.empty())
      found.why = fmt::format("\"{}\" is not a periodic function of time", name);
  };
  for (const auto& drive : mechanism.drives) {
    if (const auto* speed = std::get_if<SpeedDrive>(&drive); speed && speed->speed != 0)
      add(speed->name, one_turn / std::abs(speed->speed));
    if (const auto* torque = std::get_if<TorqueDrive>(&drive))
      if (torque->against == TorqueDrive::Against::time && torque->table.size() > 1) add(torque->name, 0);
  }
  for (const auto& reader : system.curves().readers)
    if (reader.of == CurveReader::Of::time) add(reader.name, period_of(reader.course));
  if (periods.empty() || !found.why.empty()) return found;
  const double longest = std::ranges::max(periods);
  for (const double period : periods) {
    const double ratio = longest / period;
    if (std::abs(ratio - std::round(ratio)) > 1e-9 * ratio) {
      found.why = fmt::format("the drives have periods of {:.9g} s and {:.9g} s", longest, period);
      return found;
    }
  }
  found.period = longest;
  return found;
}

double section_period(const Excitation& excitation, const std::optional<double>& given) {
  if (given && !(*given > 0 && std::isfinite(*given)))
    throw ModelError("period", "must be a positive number of seconds");
  if (excitation.period > 0) {
    if (given && std::abs(*given - excitation.period) > 1e-9 * excitation.period)
      throw ModelError("period",
                       fmt::format("{} s contradicts the drives, whose period is {:.12g} s; omit it", *given,
                                   excitation.period));
    return excitation.period;
  }
  if (given) return *given;
  throw ModelError("period", excitation.any
                                 ? fmt::format("is not known: {}; give the period of the drives in seconds",
                                               excitation.why)
                                 : "is not known: nothing in the scene depends on time; give an estimate of "
                                   "the period of the motion in seconds");
}

namespace {

using Eigen::VectorXd;

constexpr std::array<std::string_view, 3> parts{"x", "y", "theta"};
/// Shifts at which the symmetry is checked, in arms of the mechanism or rad: of both signs, and without a
/// common divisor, so that no periodic structure fits all of them.
constexpr std::array<double, 4> tried{0.618, -0.377, 3.302, -7.093};
/// Greatest relative change that counts as rounding.
constexpr double rounding = 1e-9;

/// All that the equations of motion contain at a state, with what each value belongs to.
struct Look {
  std::vector<double> values, sizes;
  std::vector<std::string> names;

  void add(double value, double size, const std::string& name) {
    values.push_back(value);
    sizes.push_back(size);
    names.push_back(name);
  }
};

Look look_at(const System& system, const State& s, double arm) {
  Look look;
  auto e = system.make_evaluation();
  system.place(s.t, s.q.data(), e);
  system.rate(s.q.data(), s.v.data(), e);
  system.forces(s.t, s.q.data(), s.v.data(), s.z.data(), e);
  for (int i = 0; i < system.rows(); ++i)
    look.add(e.phi[static_cast<std::size_t>(i)], system.is_angle_row(i) ? 1 : arm,
             fmt::format("the constraint of {}", system.row_name(i)));
  double greatest = 0, fastest = 0;
  for (const double f : e.force) greatest = std::max(greatest, std::abs(f));
  for (const double v : s.v) fastest = std::max(fastest, std::abs(v));
  for (const double f : e.force) look.add(f, greatest, "a force of a load or drive");
  for (int k = 0; k < system.contacts(); ++k) {
    ContactRow row;
    system.contact(k, s.q.data(), s.v.data(), e, row);
    const auto name = fmt::format("contact {}", system.contact_facts(k).name);
    look.add(row.gap, arm, name);
    look.add(row.normal.dot(s.v.data()), fastest, name);
    look.add(row.tangent.dot(s.v.data()), fastest, name);
  }
  std::vector<double> rates(static_cast<std::size_t>(system.states()));
  system.flow(s.t, s.q.data(), s.v.data(), s.z.data(), rates.data());
  for (const double rate : rates) look.add(rate, std::abs(rate), "a first-order state");
  return look;
}

}  // namespace

VectorXd shift_of(const Mechanism& mechanism, const std::vector<std::string>& coordinates) {
  const auto& bodies = mechanism.bodies;
  VectorXd shift = VectorXd::Zero(static_cast<Eigen::Index>(3 * bodies.size()));
  for (const auto& name : coordinates) {
    bool known = false;
    for (std::size_t i = 0; i < 3 * bodies.size(); ++i) {
      const auto part = parts[i % 3];
      if (name != fmt::format("{}.{}", bodies[i / 3].name, part) && (name != part || part == "theta"))
        continue;
      shift[static_cast<Eigen::Index>(i)] = 1;
      known = true;
    }
    if (!known)
      throw ModelError("shift",
                       fmt::format("\"{}\" is not a coordinate; give BODY.x, BODY.y or BODY.theta, or "
                                   "x or y for those of all bodies",
                                   name));
  }
  return shift;
}

std::string changes_with_shift(const System& system, const VectorXd& shift, const State& s) {
  const double arm = system.size();
  bool lengths = false;
  for (int i = 0; i < system.n(); ++i) lengths |= shift[i] != 0 && !system.is_angle(i);
  const auto here = look_at(system, s, arm);
  for (const double share : tried) {
    State moved = s;
    for (int i = 0; i < system.n(); ++i)
      moved.q[static_cast<std::size_t>(i)] += shift[i] * share * (lengths ? arm : 1);
    const auto there = look_at(system, moved, arm);
    for (std::size_t i = 0; i < here.values.size(); ++i)
      if (!(std::abs(there.values[i] - here.values[i]) <= rounding * here.sizes[i])) return here.names[i];
  }
  return {};
}

}  // namespace freeplay
