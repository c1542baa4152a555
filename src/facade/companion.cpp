#include "facade/companion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "mechanism/scene.hpp"
#include "simulation/touches.hpp"
#include "values/diagnostic.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

/// Whether an onset is that of a gap that a step has left after an impact without rebound: an impact is
/// made up to a step early, so that a gap of at most |v⁻| h remains, which closes later. `e` moves v T/2 in
/// the time T since that impact.
bool closes_leftover(const ContactEvent& impact, const ContactEvent& e, double h) {
  return impact.kind == EventKind::impact && std::abs(impact.v_n_plus) <= 1e-9 * std::abs(impact.v_n_minus) &&
         0.5 * std::abs(e.v_n_minus) * (e.t - impact.t) <= std::abs(impact.v_n_minus) * h;
}

/// Records contact onsets, except those of a gap that a step has left. Requests the end of the run when it
/// has enough of them or a time is reached.
class FirstTouches final : public Observer {
 public:
  FirstTouches(std::size_t enough, double until, double step, const StopToken& requested)
      : enough_(enough), until_(until), step_(step), requested_(requested) {}
  std::vector<ContactEvent> list;
  double t = 0;  ///< s, time reached
  StopToken token() const { return StopToken(done_); }

  void event(const Event& e) override {
    if (!is_onset(e)) return;
    const auto before = std::ranges::find_if(
        last_, [&](const auto& x) { return x.contact == e.contact && x.bodies == e.bodies; });
    const bool leftover = before != last_.end() && closes_leftover(*before, e, step_);
    if (before == last_.end())
      last_.push_back(e);
    else
      *before = e;
    if (!leftover && list.size() < enough_) list.push_back(e);
  }
  void step(const Step& step) override {
    t = step.t1;
    if (list.size() == enough_ || t >= until_ || requested_()) done_ = true;
  }

 private:
  std::size_t enough_;
  double until_, step_;             // s
  std::vector<ContactEvent> last_;  // onset of each contact
  StopToken requested_;
  std::atomic<bool> done_ = false;
};

/// The first onsets of `list`, for each contact as many as `own` has.
std::vector<ContactEvent> as_many(const std::vector<ContactEvent>& own,
                                  const std::vector<ContactEvent>& list) {
  std::vector<ContactEvent> kept;
  for (const auto& e : list) {
    const auto of = [&](const ContactEvent& x) { return x.contact == e.contact && x.bodies == e.bodies; };
    if (std::ranges::count_if(kept, of) < std::ranges::count_if(own, of)) kept.push_back(e);
  }
  return kept;
}

/// Observes one run. A run that fails still provides the onsets before the failure.
void watch(const Scene& scene, const SimulationOptions& options, FirstTouches& touches) {
  Simulation(scene, "nonsmooth", options)
      .run({.observers = {&touches}, .keep_events = false, .stop = touches.token()});
}

}  // namespace

std::optional<OnsetDoubt> doubt_first_touches(const Scene& scene, const SimulationOptions& options,
                                              const StopToken& stop) {
  if (scene.nonsmooth.scheme_in_force() != Scheme::moreau_jean || !scene.nonsmooth.step) return {};
  Scene bare = scene;
  bare.instruments.clear();
  bare.run.forces = false;
  const double duration = scene.run.duration;
  FirstTouches own(companion_touches, duration, *scene.nonsmooth.step, stop);
  watch(bare, options, own);
  if (own.list.empty() || stop()) return {};

  // Choose the ratio r so that the refined run, over the same time, takes no more steps than the
  // run has left.
  const double ratio = std::clamp(std::floor(0.6 * duration / own.t), 2.0, 8.0);
  bare.nonsmooth.step = *scene.nonsmooth.step / ratio;
  // Continue the refined run for a while longer: an onset that comes late is not missing.
  const double until = own.t + 0.25 * (own.t - (own.list.size() > 1 ? own.list.front().t : 0));
  // Simultaneous contacts may begin in another order: a few more onsets include them all.
  FirstTouches finer(own.list.size() + 3, std::min(until, duration), *bare.nonsmooth.step, stop);
  watch(bare, options, finer);
  if (stop()) return {};

  const auto apart = onset_difference(own.list, as_many(own.list, finer.list));
  OnsetDoubt d;
  d.touches = static_cast<int>(own.list.size());
  d.until = own.list.back().t;
  d.step = *scene.nonsmooth.step;
  d.companion_step = *bare.nonsmooth.step;
  d.factor = 2 * ratio / (ratio - 1);
  d.time = d.factor * apart.time;
  d.speed = d.factor * apart.speed;
  d.impulse = d.factor * apart.impulse;
  d.missing = apart.missing || apart.touches < d.touches;
  return d;
}

void add(const OnsetDoubt& d, Result& result) {
  result.first_touches = d;
  const auto what = d.touches == 1 ? std::string("the first contact event")
                                   : fmt::format("the first {} contact events", d.touches);
  if (d.missing || d.greatest() > 1)
    result.notes.push_back(diagnostic<Diagnostic::first_contacts_change>(d.companion_step, what, d.until));
  else
    result.notes.push_back(d.greatest() > doubtful_touches
                               ? diagnostic<Diagnostic::first_contacts_inaccurate>(what, 100 * d.greatest())
                               : diagnostic<Diagnostic::first_contacts_error>(what, 100 * d.greatest()));
}

void add_companion(const Simulation& simulation, const SimulationOptions& options, const StopToken& stop,
                   Result& result) {
  if (result.formulation != name_of(Family::nonsmooth) || result.ending.status != Ending::Status::finished)
    return;
  if (const auto doubt = doubt_first_touches(simulation.scene(), options, stop))
    add(*doubt, result);
  else if (stop())
    result.notes.push_back(diagnostic<Diagnostic::first_contacts_unknown>());
}

}  // namespace freeplay
