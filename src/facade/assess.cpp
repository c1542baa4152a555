#include "facade/assess.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "dynamics/system.hpp"
#include "values/diagnostic.hpp"

namespace freeplay {
namespace {

/// "penetration at gudgeon reached 15 % of the clearance"
std::string depth(const ContactSummary& c) {
  const auto ratio = c.penetration_ratio;
  if (!c.has_clearance())
    return fmt::format("penetration at {} reached {:.3g} m, {:.3g} of the {}", c.name, c.penetration, ratio,
                       c.measure == "radius" ? "radius of curvature" : "longest arm");
  return fmt::format(
      "penetration at {} reached {} the clearance", c.name,
      ratio < 10 ? fmt::format("{:.3g} % of", 100 * ratio) : fmt::format("{:.3g} times", ratio));
}

/// Bounds of the penetration under an impact law, relative to the contact's measure. Above the
/// first the result is doubtful, above the second it fails. The exact solution has no penetration.
constexpr double doubtful_depth = 1e-3, greatest_depth = 1;

}  // namespace

double rounding_energy(const System& system, const State& start, double time) {
  constexpr double few = 256 * std::numeric_limits<double>::epsilon();
  const double length = system.size();
  auto e = system.make_evaluation();
  system.place(start.t, start.q.data(), e);
  system.rate(start.q.data(), start.v.data(), e);
  auto z = start.z;
  z.resize(static_cast<std::size_t>(system.states()));
  system.forces(start.t, start.q.data(), start.v.data(), z.data(), e, {});
  double force = 0, acceleration = 0;
  for (int c = 0; c < system.n(); ++c) {
    const auto i = static_cast<std::size_t>(c);
    const double arm = system.is_angle(c) ? length : 1, f = std::abs(e.force[i]) / arm;
    if (!std::isfinite(f)) continue;
    force += f;
    acceleration = std::max(acceleration, f * arm * arm / system.mass()[i]);
  }
  return few * force * std::sqrt(length * acceleration) * time;
}

void warn(Result& result, Family family, std::string_view finer, double rounding) {
  const bool impact_law = family == Family::nonsmooth;
  const double scale = std::max(result.ledger.scale(), result.ledger.passed);
  // In a mechanism that never moved, the greatest kinetic energy before an impact may be rounding.
  if (!(result.extremes.greatest_gain > std::max(1e-12 * scale, rounding)))
    result.extremes.gains = 0, result.extremes.greatest_gain = 0;
  // Physical contacts only dissipate. If they add a large share of the energy, they drive the
  // motion.
  const double given = -(result.ledger.contact + result.ledger.friction);
  // Friction may dissipate what impacts added, and cancelling terms may hide the gain, so the gain
  // is also compared with the kinetic energy before the impact.
  const double gain = result.extremes.greatest_gain, found = result.extremes.greatest_kinetic;
  const bool grows = found > 0 && gain > 0.1 * found;
  const bool drives =
      impact_law && std::max(given, gain) > rounding && (std::max(given, gain) > 0.1 * scale || grows);
  if (result.extremes.gains > 0)
    // Newton's law with friction: Kane and Levinson, Dynamics (1985).
    result.notes.push_back(diagnostic_as<Diagnostic::impacts_add_energy>(
        drives ? Severity::warning : Severity::note, result.extremes.gains, gain,
        drives ? fmt::format(" of {:.3g} J", grows ? std::min(scale, found) : scale) : ""));
  else if (drives)
    result.notes.push_back(diagnostic<Diagnostic::contacts_add_energy>(given, scale, finer));
  // Under an impact law surfaces penetrate by rounding only. Under a contact law a journal may
  // penetrate by a tenth of its clearance, beyond which the clearance itself is changed, and a disc
  // by a tenth of its radius: there the half-width of Hertz's contact, √(δR), is 0.3 R, no longer
  // small as the assumption of a half-space requires (Johnson, Contact Mechanics, 1985, §4.1).
  for (const auto& c : result.contacts)
    if (c.penetration_ratio > (impact_law ? doubtful_depth : 0.1))
      result.notes.push_back(impact_law ? diagnostic<Diagnostic::penetration>(depth(c), finer)
                                        : diagnostic<Diagnostic::penetration_of_force>(depth(c)));
  const double accepted = std::max({1e-3 * scale, rounding, 1e-6 * result.ledger.exchanged});
  if (std::abs(result.ledger.closure()) > accepted || std::abs(result.ledger.stabilisation) > accepted)
    result.notes.push_back(diagnostic<Diagnostic::energy_balance>(result.ledger.closure(), scale,
                                                                  result.ledger.stabilisation, finer));
}

void refuse_too_deep(Result& result, Family family, std::string_view finer) {
  if (family != Family::nonsmooth || result.ending.status != Ending::Status::finished) return;
  for (const auto& c : result.contacts)
    if (c.penetration_ratio > greatest_depth) {
      result.ending = {
          Ending::Status::failed,
          fmt::format(
              "{}, which an impact law must keep near zero: the results are invalid; use a smaller {}",
              depth(c), finer)};
      return;
    }
}

void refuse_not_finite(Result& result) {
  const auto fail = [&](const char* what) {
    if (result.ending.status == Ending::Status::finished)
      result.ending = {Ending::Status::failed, fmt::format("{} at t = {:.9g} s", what, result.t_end)};
  };
  for (const auto* list : {&result.final_state.q, &result.final_state.v, &result.final_state.z})
    for (double x : *list)
      if (!std::isfinite(x)) fail("the state is not finite");
  if (!std::isfinite(result.ledger.scale()) || !std::isfinite(result.ledger.closure()))
    fail("the energy balance is not finite");
}

}  // namespace freeplay
