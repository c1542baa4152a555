#include "formulations/time_stepping/step_diagnostics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formulations/contact/contact_problem.hpp"
#include "values/diagnostic.hpp"

namespace freeplay {

void add_step_notes(const StepDiagnostics& found, const System& system, bool fixed,
                    const FilmStep::Leap& leap, const StepResolution::Bend& bend,
                    std::vector<std::string>& notes) {
  if (!found.motions.empty()) notes.push_back(diagnostic<Diagnostic::several_motions>(found.motions));
  if (found.jams > 0) notes.push_back(diagnostic<Diagnostic::lockup_impulse>(found.jams, found.jam));
  if (found.undecided > 0) notes.push_back(undecided_note(found.undecided));
  if (found.inelastic > 0) notes.push_back(diagnostic<Diagnostic::no_restitution_steps>(found.inelastic));
  if (found.unsettled > 0)
    notes.push_back(diagnostic<Diagnostic::film_iteration>(found.unsettled, finer_key(fixed)));
  if (fixed && leap.share > 0.3)
    notes.push_back(diagnostic<Diagnostic::film_not_resolved>(system.contact_facts(leap.contact).name,
                                                              leap.share, 0.1 / leap.share));
  if (bend.over > 1)
    notes.push_back(diagnostic<Diagnostic::curve_not_resolved>(
        system.curve_readers()[static_cast<std::size_t>(bend.reader)].name, bend.share,
        std::min(1 / std::max(std::sqrt(bend.over), 10 * bend.share), 0.5)));
  if (found.locked > 0)
    notes.push_back(diagnostic<Diagnostic::self_locking>(found.locked, found.locked_since));
  if (found.unswept > 0)
    notes.push_back(diagnostic<Diagnostic::torque_iteration>(found.unswept, finer_key(fixed)));
}

}  // namespace freeplay
