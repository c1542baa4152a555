#include "facade/judge.hpp"

#include <fmt/format.h>

#include <cmath>

namespace freeplay {

void warn(Result& s, Family family) {
  const bool impact_law = family == Family::nonsmooth;
  for (const auto& c : s.contacts)
    if (c.penetration_ratio > (impact_law ? 1e-3 : 0.1))
      s.notes.push_back(fmt::format(
          "DOUBTFUL: {} lay up to {:.3g} clearances inside its wall; {}", c.name, c.penetration_ratio,
          impact_law ? "take a shorter nonsmooth.step" : "the contact is too soft for this load"));
  const double scale = s.ledger.scale();
  if (std::abs(s.ledger.closure()) > 1e-3 * scale || std::abs(s.ledger.stabilisation) > 1e-3 * scale)
    s.notes.push_back(fmt::format(
        "DOUBTFUL: of {:.3g} J the energy balance misses {:.2g} J and stabilisation did {:.2g} J; "
        "tighten the tolerance or shorten the step, or the motion passed a singular position",
        scale, s.ledger.closure(), s.ledger.stabilisation));
}

void refuse_not_finite(Result& s) {
  const auto fail = [&](const char* what) {
    if (s.ending.status == Ending::Status::finished)
      s.ending = {Ending::Status::failed, fmt::format("{} at t = {:.9g} s", what, s.t_end)};
  };
  for (const auto* list : {&s.final_state.q, &s.final_state.v, &s.final_state.z})
    for (double x : *list)
      if (!std::isfinite(x)) fail("the state is not finite");
  if (!std::isfinite(s.ledger.scale()) || !std::isfinite(s.ledger.closure()))
    fail("the energy balance is not finite");
}

}  // namespace freeplay
