#include "formulations/time_stepping/step_diagnostics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formulations/contact/contact_problem.hpp"

namespace freeplay {

void add_step_notes(const StepDiagnostics& found, const System& system, bool fixed,
                    const FilmStep::Leap& leap, const StepResolution::Bend& bend,
                    std::vector<std::string>& notes) {
  if (!found.motions.empty())
    notes.push_back("Painlevé paradox: friction admits several motions, and one was chosen; first at " +
                    found.motions);
  if (found.jams > 0)
    notes.push_back(fmt::format(
        "Painlevé paradox: {} times friction admitted no finite force at a sliding contact, and an impulse "
        "stopped it; first at {}",
        found.jams, found.jam));
  if (found.undecided > 0) notes.push_back(undecided_note(found.undecided));
  if (found.inelastic > 0)
    notes.push_back(fmt::format(
        "{} steps with several contacts were solved without restitution because no solver found impulses "
        "with it",
        found.inelastic));
  if (found.unsettled > 0)
    notes.push_back(fmt::format(
        "warning: in {} steps the iteration between film force and dry contact did not converge; use a "
        "smaller {}",
        found.unsettled, finer_key(fixed)));
  if (fixed && leap.share > 0.3)
    notes.push_back(fmt::format(
        "warning: the film of {} changed by {:.2g} of its thickness in one step and is not resolved; use "
        "{:.1g} times this nonsmooth.step, or \"automatic\"",
        system.contact_facts(leap.contact).name, leap.share, 0.1 / leap.share));
  if (bend.over > 1)
    notes.push_back(fmt::format(
        "warning: the curve of {} deviates from a straight line within one step, by {:.2g} of its greatest "
        "value; use less than {:.1g} times this nonsmooth.step, or \"automatic\"",
        system.curve_readers()[static_cast<std::size_t>(bend.reader)].name, bend.share,
        std::min(1 / std::max(std::sqrt(bend.over), 10 * bend.share), 0.5)));
  if (found.locked > 0)
    notes.push_back(fmt::format(
        "the mechanism is self-locking in {} contact problems, first at t = {:.9g} s: joint friction "
        "outgrows its reactions, and impulses may stop sliding parts",
        found.locked, found.locked_since));
  if (found.unswept > 0)
    notes.push_back(fmt::format(
        "warning: in {} steps the iteration for a tabulated torque did not converge: its pulse reverses "
        "the motion within a step; use a smaller {}, or the event-driven scheme",
        found.unswept, finer_key(fixed)));
}

}  // namespace freeplay
