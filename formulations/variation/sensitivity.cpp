#include "formulations/variation/sensitivity.hpp"

#include <fmt/format.h>

#include <utility>

#include "formulations/event_driven/event_driven.hpp"
#include "formulations/integrators/tolerance.hpp"
#include "formulations/nonsmooth.hpp"
#include "formulations/penalty/penalty_variation.hpp"
#include "formulations/time_stepping/adaptive.hpp"
#include "formulations/variation/step_variation.hpp"
#include "formulations/variation/varied_run.hpp"
#include "mechanism/scene.hpp"
#include "values/family.hpp"

namespace freeplay {

double least_curved_length(const System& system) {
  double least = INFINITY;
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& facts = system.contact_facts(k);
    const double length = facts.has_clearance ? facts.clearance : facts.measure();
    if (length > 0) least = std::min(least, length);
  }
  if (std::isfinite(least)) return least;
  return system.size();
}

namespace {

using Of = VariedQuantity::Of;

/// A term of the energy balance, except the loss in contacts. `Sums` names the integrals within x.
template <class Sums, class Dynamics>
double summed_energy(EnergyTerm term, Dynamics& f, const std::vector<double>& x) {
  const double* integral = x.data() + f.integral_offset();
  switch (term) {
    case EnergyTerm::kinetic:
      return f.system.kinetic(x.data() + f.system.n());
    case EnergyTerm::potential:
      return f.system.potential(x.data());
    case EnergyTerm::drive:
      return integral[Sums::drive];
    case EnergyTerm::load:
      return integral[Sums::load];
    case EnergyTerm::damping:
      return integral[Sums::damping];
    case EnergyTerm::friction:
      return integral[Sums::friction_loss];
    case EnergyTerm::film:
      if constexpr (requires { f.films.any(); })  // else x has the sum in any case
        if (!f.films.any()) return 0;
      return integral[Sums::film_loss];
    case EnergyTerm::contact:
      break;
  }
  return 0;
}

/// Relative difference of times that rounding explains.
constexpr double same_time = 1e-13;

/// Which of two simultaneous events has a number depends on a key by which their times change differently.
void refuse_ties(const VariedOnset& onset, const std::vector<VariedOnset>& onsets, Sensitivity& s) {
  for (const auto& other : onsets) {
    if (&other == &onset || std::abs(other.t - onset.t) > same_time * std::abs(onset.t)) continue;
    for (std::size_t c = 0; c < s.reasons.size(); ++c) {
      const double a = onset.dt[c], b = other.dt[c];
      if (s.reasons[c].empty() && !(std::abs(a - b) <= 1e-9 * std::max(std::abs(a), std::abs(b))))
        s.reasons[c] = fmt::format(
            "t = {:.9g} s: two contacts close at the same time, so that the number of each event depends on "
            "this key",
            onset.t);
    }
  }
}

/// Value and derivatives of a quantity of one contact event. `ended`: reasons of the columns.
void take_event(const VariedQuantity& q, const std::vector<VariedOnset>& onsets,
                const std::vector<std::string>& ended, const char* lasting, Sensitivity& s) {
  if (q.event > onsets.size()) {
    for (auto& reason : s.reasons)
      reason = fmt::format("the run has {} contact event{}", onsets.size(), onsets.size() == 1 ? "" : "s");
    for (std::size_t c = 0; c < ended.size(); ++c)
      if (!ended[c].empty()) s.reasons[c] = ended[c];
    return;
  }
  const auto& onset = onsets[q.event - 1];
  s.reasons = onset.reasons;
  refuse_ties(onset, onsets, s);
  switch (q.of) {
    case Of::event_time:
      s.value = onset.t;
      s.derivatives = onset.dt;
      break;
    case Of::event_rate:
      s.value = onset.rate;
      s.derivatives = onset.drate;
      break;
    default:
      if (onset.lasting) {
        for (auto& reason : s.reasons)
          if (reason.empty()) reason = lasting;
        return;
      }
      s.value = onset.impulse;
      s.derivatives = onset.dimpulse;
      for (std::size_t c = 0; c < ended.size(); ++c)
        if (s.reasons[c].empty() && std::isnan(s.derivatives[c])) s.reasons[c] = ended[c];
  }
  for (std::size_t c = 0; c < ended.size(); ++c)
    if (!s.reasons[c].empty()) s.derivatives[c] = NAN;
}

/// Facts of a finished run.
struct Finished {
  const std::vector<double>& x;
  double t;
  const char* lasting;  ///< why a contact has no impulse
};

/// Evaluates all quantities at the end of a run in the present mode `d`. `contact_loss` gives the energy
/// lost in contacts if the integrated vector does not contain it.
template <class Variation, class Present, class EnergyOf, class ContactLoss>
void take_quantities(const SensitivityRun& run, Variation& variation, const Present& d, const Finished& end,
                     EnergyOf energy_of, ContactLoss contact_loss, Sensitivities& all) {
  const auto keys = run.keys.size();
  auto onsets = variation.onsets();
  std::ranges::stable_sort(onsets, {}, &VariedOnset::t);
  std::vector<std::string> ended;
  for (std::size_t c = 0; c < keys; ++c) ended.push_back(variation.reason(c));
  using Function = typename Variation::Function;
  using Vector = typename Variation::Vector;
  const auto at_end = [&](const Function& value, Sensitivity& s) {
    s.derivatives = variation.end_derivatives(d, end.x, end.t, value, s.value, s.reasons);
    for (const auto& onset : onsets)
      for (std::size_t c = 0; c < keys; ++c)
        if (std::abs(onset.t - end.t) <= same_time * std::abs(end.t) && s.reasons[c].empty() &&
            !(std::abs(onset.dt[c] - run.keys[c].end_rate) <=
              1e-12 * std::abs(end.t) / run.keys[c].scale())) {
          s.reasons[c] = fmt::format("a contact closes at the end of the run, t = {:.9g} s", end.t);
          s.derivatives[c] = NAN;
        }
  };
  std::size_t integral = 0, peak = 0;
  for (const auto& q : run.quantities) {
    auto& s = all.quantities.emplace_back();
    s.name = q.name;
    s.derivatives.assign(keys, NAN);
    s.reasons.assign(keys, "");
    switch (q.of) {
      case Of::event_time:
      case Of::event_rate:
      case Of::event_impulse:
        take_event(q, onsets, ended, end.lasting, s);
        break;
      case Of::mean:
        s.value = variation.mean(integral, run.start.t, end.t);
        s.derivatives = variation.mean_derivatives(integral++, d, end.x, run.start.t, end.t);
        s.reasons = ended;
        break;
      case Of::peak: {
        const auto found = variation.peak(peak++, d, end.x, end.t);
        s.value = found.y;
        s.derivatives = found.slope;
        s.reasons = found.reasons;
        break;
      }
      case Of::energy:
        if (q.term == EnergyTerm::contact && contact_loss(s, ended)) break;
        at_end([&](auto& f, const Vector& x, double t) { return Vector{energy_of(q.term, f, x, t)}; }, s);
        break;
      case Of::end:
        at_end([&](auto& f, const Vector& x, double t) { return Vector{observed(q.column, f, x, t)}; }, s);
        break;
    }
  }
}

std::vector<Column> integrands_of(const SensitivityRun& run) {
  std::vector<Column> integrands;
  for (const auto& q : run.quantities)
    if (q.of == Of::mean) integrands.push_back(q.column);
  return integrands;
}

std::vector<PeakChannel> channels_of(const SensitivityRun& run) {
  std::vector<PeakChannel> channels;
  for (const auto& q : run.quantities)
    if (q.of == Of::peak) channels.push_back(q.channel);
  return channels;
}

double cost_of(long evaluations, long rhs) {
  return rhs > 0 ? static_cast<double>(evaluations) / static_cast<double>(rhs) : 0;
}

/// The same for the nonsmooth formulation, with the energy lost in contacts (J).
void take_nonsmooth(const SensitivityRun& run, Variation& variation, const EventDynamics& d,
                    const std::vector<double>& x, double t, double contact_loss, Sensitivities& all) {
  take_quantities(
      run, variation, d, {x, t, "the event begins a lasting contact, which has no impulse at its beginning"},
      [](EnergyTerm term, EventDynamics& f, const std::vector<double>& y, double) {
        return summed_energy<EventDynamics>(term, f, y);
      },
      [&](Sensitivity& s, const std::vector<std::string>& ended) {
        s.value = contact_loss;
        s.reasons = ended;
        for (std::size_t c = 0; c < ended.size(); ++c)
          if (ended[c].empty()) s.derivatives[c] = variation.contact_loss()[c];
        return true;
      },
      all);
}

void run_event_driven(const SensitivityRun& run, Sensitivities& all) {
  VariedRun motion(
      run, integrands_of(run),
      make_event_driven(run.scene, run.system, restitution_of(run.system), row_facts(run), run.start));
  auto& scheme = motion.scheme();
  auto& variation = scheme.variation();
  use_traced(run, variation);
  variation.watch_peaks(channels_of(run));
  all.stopped = motion.go([] {});
  const auto& d = scheme.dynamics();
  take_nonsmooth(run, variation, d, scheme.x(), scheme.t(), d.contact_loss, all);
  all.cost = cost_of(variation.evaluations(), scheme.work().rhs);
}

void run_time_stepping(const SensitivityRun& run, Sensitivities& all) {
  with_varied_steps(run, integrands_of(run), [&](auto& steps) {
    auto& variation = steps.variation();
    variation.watch_peaks(channels_of(run));
    all.stopped = steps.go();
    const auto& stepper = steps.stepper();
    take_nonsmooth(run, variation, steps.mode(), variation.x(), stepper.t(), stepper.integrals().contact,
                   all);
    all.cost = cost_of(variation.evaluations(), stepper.work().rhs);
  });
}

void run_penalty(const SensitivityRun& run, Sensitivities& all) {
  const auto parts = make_penalty_parts(run.scene, run.system, run.start);
  auto& steps = *parts.steps;
  PenaltyVariation variation(parts, run.scene, run.start, run.keys, integrands_of(run),
                             least_curved_length(run.system), run.end - run.start.t);
  use_traced(run, variation);
  variation.watch_peaks(channels_of(run));
  while (steps.t() < run.end) {
    if (run.stop()) throw Interrupted();
    variation.begin_step();
    if (!steps.step(run.end)) {
      all.stopped = steps.failure();
      variation.refuse(all.stopped);
      break;
    }
    variation.end_step();
  }
  const auto x = variation.x();
  take_quantities(
      run, variation, steps.dynamics(), {x, steps.t(), "the contact lasts to the end of the run"},
      [](EnergyTerm term, ExtendedPenalty& f, const std::vector<double>& y, double t) {
        if (term != EnergyTerm::contact) return summed_energy<PenaltyDynamics>(term, f, y);
        return y[static_cast<std::size_t>(f.integral_offset()) + PenaltyDynamics::contact_work] -
               f.stored_energy(y, t);
      },
      [](Sensitivity&, const std::vector<std::string>&) { return false; }, all);
  all.cost = cost_of(variation.evaluations(), steps.dynamics().work.rhs);
}

}  // namespace

Sensitivities run_sensitivities(const SensitivityRun& run, Family family) {
  Sensitivities all;
  for (const auto& key : run.keys) {
    all.keys.push_back(key.name);
    all.key_values.push_back(key.value);
  }
  if (family == Family::penalty)
    run_penalty(run, all);
  else if (run.scene.nonsmooth.scheme_in_force() == Scheme::moreau_jean)
    run_time_stepping(run, all);
  else
    run_event_driven(run, all);
  return all;
}

}  // namespace freeplay
