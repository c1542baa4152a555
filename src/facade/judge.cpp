#include "facade/judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace freeplay {
namespace {

/// Example: "gudgeon lay up to 385 clearances inside its wall".
std::string depth(const ContactSummary& c) {
  return c.has_clearance()
             ? fmt::format("{} lay up to {:.3g} clearances inside its wall", c.name, c.penetration_ratio)
             : fmt::format("{} overlapped by up to {:.3g} m, {:.3g} of {}", c.name, c.penetration,
                           c.penetration_ratio,
                           c.measure == "radius" ? "its radius of curvature" : "the longest arm");
}

/// Bounds of the penetration under an impact law, relative to the contact's measure. Above the
/// first the result is doubtful, above the second it fails. The exact solution has no penetration.
constexpr double doubtful_depth = 1e-3, greatest_depth = 1;

}  // namespace

void warn(Result& result, Family family, std::string_view finer) {
  const bool impact_law = family == Family::nonsmooth;
  const double scale = std::max(result.ledger.scale(), result.ledger.passed);
  // In a mechanism that never moved, the greatest kinetic energy before an impact may be rounding.
  if (!(result.extremes.greatest_gain > 1e-12 * scale))
    result.extremes.gains = 0, result.extremes.greatest_gain = 0;
  // Physical contacts only dissipate. If they add a large share of the energy, they drive the
  // motion.
  const double given = -(result.ledger.contact + result.ledger.friction);
  // Friction may dissipate what impacts added, and cancelling terms may hide the gain, so the gain
  // is also compared with the kinetic energy before the impact.
  const double gain = result.extremes.greatest_gain, found = result.extremes.greatest_kinetic;
  const bool grows = found > 0 && gain > 0.1 * found;
  const bool drives = impact_law && (std::max(given, gain) > 0.1 * scale || grows);
  if (result.extremes.gains > 0)
    result.notes.push_back(fmt::format(
        "{}{} impacts raised the energy, by up to {:.3g} J{}: a restitution of rates with friction can "
        "(Kane and Levinson 1985); nonsmooth.impact_law = \"energetic\" does not",
        drives ? "DOUBTFUL: " : "", result.extremes.gains, gain,
        drives ? fmt::format(" where there is {:.3g} J", grows ? std::min(scale, found) : scale) : ""));
  else if (drives)
    result.notes.push_back(
        fmt::format("DOUBTFUL: contacts with their friction gave {:.3g} J of {:.3g} J; take a smaller {}",
                    given, scale, finer));
  // An impact law prevents penetration except for rounding. Under a contact law the bound is a
  // tenth of the clearance, beyond which the clearance itself changes, or a tenth of the radius of
  // a disc: there the half-width of Hertz's contact, √(δR), is 0.3 R and no longer small, as the
  // half-space assumption requires (Johnson, Contact Mechanics, 1985, §4.1).
  for (const auto& c : result.contacts)
    if (c.penetration_ratio > (impact_law ? doubtful_depth : 0.1))
      result.notes.push_back(fmt::format(
          "DOUBTFUL: {}; {}", depth(c),
          impact_law ? fmt::format("take a smaller {}", finer) : "the contact is too soft for this load"));
  if (std::abs(result.ledger.closure()) > 1e-3 * scale ||
      std::abs(result.ledger.stabilisation) > 1e-3 * scale)
    result.notes.push_back(fmt::format(
        "DOUBTFUL: of {:.3g} J the energy balance misses {:.2g} J and stabilisation did {:.2g} J; "
        "take a smaller {}, or the motion passed a singular position",
        scale, result.ledger.closure(), result.ledger.stabilisation, finer));
}

void refuse_too_deep(Result& result, Family family, std::string_view finer) {
  if (family != Family::nonsmooth || result.ending.status != Ending::Status::finished) return;
  for (const auto& c : result.contacts)
    if (c.penetration_ratio > greatest_depth) {
      result.ending = {
          Ending::Status::failed,
          fmt::format("{}, which an impact law keeps outside: the motion is not this mechanism's; take "
                      "a smaller {}",
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
