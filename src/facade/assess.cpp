#include "facade/assess.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>

#include "dynamics/system.hpp"
#include "mechanism/scene.hpp"
#include "simulation/touches.hpp"
#include "values/diagnostic.hpp"

namespace freeplay {
namespace {

/// "penetration at gudgeon reached 15 % of the clearance"
std::string depth(const ContactSummary& c) {
  const auto ratio = c.penetration_ratio;
  if (!c.has_clearance())
    return fmt::format("penetration at {} reached {:.3g} m, {:.3g} of the {}", c.name, c.penetration, ratio,
                       c.measure == "radius" ? "radius of curvature" : "longest arm");
  return fmt::format(
      "penetration at {} reached {} the clearance", c.name,
      ratio < 10 ? fmt::format("{:.3g} % of", 100 * ratio) : fmt::format("{:.3g} times", ratio));
}

/// Bounds of the penetration under an impact law, relative to the contact's measure. Above the
/// first the result is doubtful, above the second it fails. The exact solution has no penetration.
constexpr double doubtful_depth = 1e-3, greatest_depth = 1;

}  // namespace

double rounding_energy(const System& system, const State& start, double time) {
  constexpr double few = 256 * std::numeric_limits<double>::epsilon();
  const double length = system.size();
  auto e = system.make_evaluation();
  system.place(start.t, start.q.data(), e);
  system.rate(start.q.data(), start.v.data(), e);
  auto z = start.z;
  z.resize(static_cast<std::size_t>(system.states()));
  system.forces(start.t, start.q.data(), start.v.data(), z.data(), e, {});
  double force = 0, acceleration = 0;
  for (int c = 0; c < system.n(); ++c) {
    const auto i = static_cast<std::size_t>(c);
    const double arm = system.is_angle(c) ? length : 1, f = std::abs(e.force[i]) / arm;
    if (!std::isfinite(f)) continue;
    force += f;
    acceleration = std::max(acceleration, f * arm * arm / system.mass()[i]);
  }
  return few * force * std::sqrt(length * acceleration) * time;
}

void warn(Result& result, Family family, std::string_view finer, double rounding) {
  const bool impact_law = family == Family::nonsmooth;
  const double scale = std::max(result.ledger.scale(), result.ledger.passed);
  // In a mechanism that never moved, the greatest kinetic energy before an impact may be rounding.
  if (!(result.extremes.greatest_gain > std::max(1e-12 * scale, rounding)))
    result.extremes.gains = 0, result.extremes.greatest_gain = 0;
  // Physical contacts only dissipate. If they add a large share of the energy, they drive the
  // motion.
  const double given = -(result.ledger.contact + result.ledger.friction);
  // Friction may dissipate what impacts added, and cancelling terms may hide the gain, so the gain
  // is also compared with the kinetic energy before the impact.
  const double gain = result.extremes.greatest_gain, found = result.extremes.greatest_kinetic;
  const bool grows = found > 0 && gain > 0.1 * found;
  const bool drives =
      impact_law && std::max(given, gain) > rounding && (std::max(given, gain) > 0.1 * scale || grows);
  if (result.extremes.gains > 0)
    // Newton's law with friction: Kane and Levinson, Dynamics (1985).
    result.notes.push_back(diagnostic_as<Diagnostic::impacts_add_energy>(
        drives ? Severity::warning : Severity::note, result.extremes.gains, gain,
        drives ? fmt::format(" of {:.3g} J", grows ? std::min(scale, found) : scale) : ""));
  else if (drives)
    result.notes.push_back(diagnostic<Diagnostic::contacts_add_energy>(given, scale, finer));
  // Under an impact law surfaces penetrate by rounding only. Under a contact law a journal may
  // penetrate by a tenth of its clearance, beyond which the clearance itself is changed, and a disc
  // by a tenth of its radius: there the half-width of Hertz's contact, √(δR), is 0.3 R, no longer
  // small as the assumption of a half-space requires (Johnson, Contact Mechanics, 1985, §4.1).
  for (const auto& c : result.contacts)
    if (c.penetration_ratio > (impact_law ? doubtful_depth : 0.1))
      result.notes.push_back(impact_law ? diagnostic<Diagnostic::penetration>(depth(c), finer)
                                        : diagnostic<Diagnostic::penetration_of_force>(depth(c)));
  const double accepted = std::max({1e-3 * scale, rounding, 1e-6 * result.ledger.exchanged});
  if (std::abs(result.ledger.closure()) > accepted || std::abs(result.ledger.stabilisation) > accepted)
    result.notes.push_back(diagnostic<Diagnostic::energy_balance>(result.ledger.closure(), scale,
                                                                  result.ledger.stabilisation, finer));
}

void refuse_too_deep(Result& result, Family family, std::string_view finer) {
  if (family != Family::nonsmooth || result.ending.status != Ending::Status::finished) return;
  for (const auto& c : result.contacts)
    if (c.penetration_ratio > greatest_depth) {
      result.ending = {
          Ending::Status::failed,
          fmt::format(
              "{}, which an impact law must keep near zero: the results are invalid; use a smaller {}",
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
