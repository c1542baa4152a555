#include "formulations/time_stepping/step_diagnostics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formulations/contact/contact_problem.hpp"

namespace freeplay {

void tell_steps(const StepDiagnostics& found, const System& system, bool fixed, const FilmStep::Leap& leap,
                const StepResolution::Bend& bend, std::vector<std::string>& notes) {
  if (!found.motions.empty())
    notes.push_back("Painlevé: friction admits more than one motion, of which one was taken; the first at " +
                    found.motions);
  if (found.jams > 0)
    notes.push_back(fmt::format(
        "Painlevé: friction admitted no finite force on what slid, and an impulse stopped it, {} times; the "
        "first at {}",
        found.jams, found.jam));
  if (found.undecided > 0) notes.push_back(undecided_note(found.undecided));
  if (found.inelastic > 0)
    notes.push_back(fmt::format(
        "{} steps with several contacts were taken without restitution, for no solver found impulses with it",
        found.inelastic));
  if (found.unsettled > 0)
    notes.push_back(fmt::format(
        "DOUBTFUL: in {} steps contact came and went with the film's force, and none was found that fits both; take a smaller "
        "{}",
        found.unsettled, finer_key(fixed)));
  if (fixed && leap.share > 0.3)
    notes.push_back(fmt::format(
        "DOUBTFUL: {} squeezed its film by {:.2g} of its thickness in one step, which takes the film as it was at the step's "
        "middle; take a nonsmooth.step of {:.1g} times this one, or \"automatic\"",
        system.contact_facts(leap.contact).name, leap.share, 0.1 / leap.share));
  if (bend.over > 1)
    notes.push_back(fmt::format(
        "DOUBTFUL: within one step {} reads a curve that departs from a straight line by {:.2g} of its greatest value; take a "
        "nonsmooth.step of less than {:.1g} times this one, or \"automatic\"",
        system.curve_readers()[static_cast<std::size_t>(bend.reader)].name, bend.share,
        std::min(1 / std::max(std::sqrt(bend.over), 10 * bend.share), 0.5)));
  if (found.locked > 0)
    notes.push_back(fmt::format(
        "friction in joints outgrows the reactions that bound it in {} problems, the first at t = {:.9g} s: the mechanism "
        "is self-locking there, and what slides may be stopped at once, by impulses",
        found.locked, found.locked_since));
  if (found.unswept > 0)
    notes.push_back(fmt::format(
        "DOUBTFUL: in {} steps the angle that a torque's table was swept over did not settle: the pulse turns the motion "
        "round within a step; take a smaller {}, or event-driven",
        found.unswept, finer_key(fixed)));
}

}  // namespace freeplay
