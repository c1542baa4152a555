#include "formulations/event_driven/event_findings.hpp"

#include <fmt/format.h>

namespace freeplay {

void EventFindings::tell(const System& system, double rounding, std::vector<std::string>& notes) const {
  const double scale = std::max(most_kinetic, 1e-300);
  if (lockups.count > 0)
    notes.push_back(fmt::format(
        "Painlevé: {} times friction admitted no finite force on what slid, and an impact without collision "
        "ended the sliding: up to {:.2g} of the greatest kinetic energy at once",
        lockups.count, lockups.energy / scale));
  if (unsolved.count > 0)
    notes.push_back(fmt::format(
        "{} times no solver found forces that friction admits on what slid (whether there are any is not known), and "
        "an impact without collision ended the sliding: up to {:.2g} of the greatest kinetic energy at once",
        unsolved.count, unsolved.energy / scale));
  if (inelastic.count > 0)
    notes.push_back(fmt::format(
        "{} impacts of several contacts were taken without restitution, for no solver found impulses with it: up to "
        "{:.2g} of the greatest kinetic energy was lost at once",
        inelastic.count, inelastic.energy / scale));
  if (unloaded.count > 0)
    notes.push_back(fmt::format(
        "t = {:.6g} s, {}: {} took part in an impact with gaps of {:.1g} m, closed to rounding; a real gap there would "
        "change the motion",
        unloaded.t, system.contact_facts(unloaded.contact).name,
        unloaded.count == 1 ? "an unloaded contact" : fmt::format("{} unloaded contacts", unloaded.count),
        unloaded.gap));
  if (merged > 1e3 * rounding)
    notes.push_back(fmt::format("contacts up to {:.2g} m apart were struck at once", merged));
}

}  // namespace freeplay
