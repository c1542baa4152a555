#include "formulations/event_driven/event_findings.hpp"

#include <fmt/format.h>

namespace freeplay {

void EventFindings::add_notes(const System& system, double rounding, std::vector<std::string>& notes) const {
  const double scale = std::max(most_kinetic, 1e-300);
  if (lockups.count > 0)
    notes.push_back(fmt::format(
        "Painlevé paradox: {} times friction admitted no finite force, and an impact without collision "
        "ended sliding (loss up to {:.2g} of the greatest kinetic energy)",
        lockups.count, lockups.energy / scale));
  if (unsolved.count > 0)
    notes.push_back(fmt::format(
        "{} times no solver found admissible forces, and an impact without collision ended sliding (loss "
        "up to {:.2g} of the greatest kinetic energy)",
        unsolved.count, unsolved.energy / scale));
  if (inelastic.count > 0)
    notes.push_back(fmt::format(
        "{} simultaneous impacts were solved without restitution because no solver found impulses with it; greatest "
        "loss {:.2g} of the greatest kinetic energy",
        inelastic.count, inelastic.energy / scale));
  if (unloaded.count > 0)
    notes.push_back(fmt::format(
        "t = {:.6g} s, {}: {} took part in an impact with a gap of {:.1g} m, which is closed to rounding; "
        "a larger gap would change the motion",
        unloaded.t, system.contact_facts(unloaded.contact).name,
        unloaded.count == 1 ? "an unloaded contact" : fmt::format("{} unloaded contacts", unloaded.count),
        unloaded.gap));
  if (merged > 1e3 * rounding)
    notes.push_back(
        fmt::format("contacts with gaps up to {:.2g} µm were treated as simultaneous", 1e6 * merged));
}

}  // namespace freeplay
