// What a reader of the results must know of a run's contact problems.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formulations/time_stepping/moreau.hpp"

namespace freeplay {

/// Notes the first problem with more than one motion, and the first contact that slid on without approach and
/// was stopped by an impulse, because friction there admits no finite force on what slides.
void MoreauStepper::tell_painleve(const ContactSolution& result) {
  undecided_ += result.undecided;
  if (result.ambiguous && motions_.empty()) {
    const auto name = [&](int i) {
      for (int k = 0; k < system_.contacts(); ++k)
        if (contacts_[k].unknown == i) return system_.contact_facts(k).name;
      return std::string("a preloaded joint");
    };
    if (many_) {
      const auto& ids = many_->islands.ambiguous_ids();
      const auto of_island = [&](int i) {
        const int k = ids[i] - system_.frictions();
        return k >= 0 ? facts_of(k).name : std::string("a preloaded joint");
      };
      motions_ = fmt::format("t = {:.9g} s: {}", t_old_,
                             describe_motions(many_->islands.ambiguous(), of_island, "N s"));
    } else {
      motions_ = fmt::format("t = {:.9g} s: {}", t_old_, describe_motions(problem_, name, "N s"));
    }
  }
  for (const int k : live_) {
    const auto& c = contacts_[k];
    if (c.unknown < 0 || c.row.tangent.size == 0) continue;
    const auto& u = problem_.unknowns[c.unknown];
    const double slide = c.row.tangent.dot(v_old_.data()), after = rate_of(u.tangent);
    const double side = slide > 0 ? 1 : -1;
    const double slope = delassus(u.normal, u.normal) - side * u.friction * delassus(u.normal, u.tangent);
    if (u.impulse_n > 0 && slope <= 0 && -c.u_n_minus <= 1e-4 * std::abs(slide) &&
        side * after <= 1e-3 * std::abs(slide) && jams_++ == 0)
      jam_ = fmt::format("t = {:.9g} s, {}", t_old_, facts_of(k).name);
  }
}

void MoreauStepper::tell(std::vector<std::string>& notes) const {
  if (!motions_.empty())
    notes.push_back("Painlevé: friction admits more than one motion, of which one was taken; the first at " +
                    motions_);
  if (jams_ > 0)
    notes.push_back(fmt::format(
        "Painlevé: friction admitted no finite force on what slid, and an impulse stopped it, {} times; the "
        "first at {}",
        jams_, jam_));
  if (undecided_ > 0) notes.push_back(undecided_note(undecided_));
  if (inelastic_ > 0)
    notes.push_back(fmt::format(
        "{} steps with several contacts were taken without restitution, for no solver found impulses with it",
        inelastic_));
  if (unsettled_ > 0)
    notes.push_back(fmt::format(
        "DOUBTFUL: in {} steps contact came and went with the film's force, and none was found that fits both; take a smaller "
        "{}",
        unsettled_, finer()));
  if (step_ > 0 && films_.leap.share > 0.3)
    notes.push_back(fmt::format(
        "DOUBTFUL: {} squeezed its film by {:.2g} of its thickness in one step, which takes the film as it was at the step's "
        "middle; take a nonsmooth.step of {:.1g} times this one, or \"automatic\"",
        system_.contact_facts(films_.leap.contact).name, films_.leap.share, 0.1 / films_.leap.share));
  if (bend_.over > 1)
    notes.push_back(fmt::format(
        "DOUBTFUL: within one step {} reads a curve that departs from a straight line by {:.2g} of its greatest value; take a "
        "nonsmooth.step of less than {:.1g} times this one, or \"automatic\"",
        system_.curve_readers()[static_cast<std::size_t>(bend_.reader)].name, bend_.share,
        std::min(1 / std::max(std::sqrt(bend_.over), 10 * bend_.share), 0.5)));
  if (locked_ > 0)
    notes.push_back(fmt::format(
        "friction in joints outgrows the reactions that bound it in {} problems, the first at t = {:.9g} s: the mechanism "
        "is self-locking there, and what slides may be stopped at once, by impulses",
        locked_, locked_since_));
  if (unswept_ > 0)
    notes.push_back(fmt::format(
        "DOUBTFUL: in {} steps the angle that a torque's table was swept over did not settle: the pulse turns the motion "
        "round within a step; take a smaller {}, or event-driven",
        unswept_, finer()));
}

}  // namespace freeplay
