#include "formulations/event_driven/event_findings.hpp"
#include "values/diagnostic.hpp"

#include <fmt/format.h>

namespace freeplay {

void EventFindings::add_notes(const System& system, double rounding, std::vector<std::string>& notes) const {
  const double scale = std::max(most_kinetic, 1e-300);
  if (lockups.count > 0)
    notes.push_back(diagnostic<Diagnostic::lockup>(lockups.count, lockups.energy / scale));
  if (unsolved.count > 0)
    notes.push_back(diagnostic<Diagnostic::unsolved_contacts>(unsolved.count, unsolved.energy / scale));
  if (inelastic.count > 0)
    notes.push_back(
        diagnostic<Diagnostic::no_restitution_impacts>(inelastic.count, inelastic.energy / scale));
  if (unloaded.count > 0)
    notes.push_back(diagnostic<Diagnostic::unloaded_contact>(
        unloaded.t, system.contact_facts(unloaded.contact).name,
        unloaded.count == 1 ? "an unloaded contact" : fmt::format("{} unloaded contacts", unloaded.count),
        unloaded.gap));
  if (merged > 1e3 * rounding) notes.push_back(diagnostic<Diagnostic::simultaneous_impacts>(1e6 * merged));
}

}  // namespace freeplay
