#include "facade/excitation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>
#include <vector>

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
  for (const auto& reader : system.curve_readers())
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

}  // namespace freeplay
