#include "formulations/sensitivity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/assembly/assembly.hpp"
#include "formulations/event_driven/event_driven.hpp"
#include "formulations/integrators/tolerance.hpp"
#include "formulations/least_forces.hpp"
#include "formulations/nonsmooth.hpp"
#include "formulations/peak_search.hpp"
#include "formulations/penalty/penalty_variation.hpp"
#include "formulations/step_variation.hpp"
#include "formulations/time_stepping/adaptive.hpp"
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
  return system.longest_arm() > 0 ? system.longest_arm() : 1;
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
  switch (q.of) {
    case Of::event_time:
      s.value = onset.t;
      s.derivatives = onset.dt;
      return;
    case Of::event_rate:
      s.value = onset.rate;
      s.derivatives = onset.drate;
      return;
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
}

std::vector<double> restitution_of(const System& system) {
  std::vector<double> list;
  for (int k = 0; k < system.contacts(); ++k)
    list.push_back(system.contact_facts(k).surface.restitution.value_or(0));
  return list;
}

RowFacts row_facts(const SensitivityRun& run) {
  return {!redundant_rows(run.system, run.start.q).empty(), run.scene.run.eliminate};
}

/// A run of the event-driven scheme with its variational equations.
class VariedRun {
 public:
  VariedRun(const SensitivityRun& run, const std::vector<Column>& integrands)
      : run_(run),
        restitution_(restitution_of(run.system)),
        scheme_(make_event_driven(run.scene, run.system, restitution_, row_facts(run), run.start)),
        log_(run.system.contacts(), run.system.reported()) {
    scheme_.start(run.start, log_);
    scheme_.vary(run.keys, integrands, least_curved_length(run.system), run.end - run.start.t);
    if (run.traced) scheme_.variation().trace(run.start);
  }
  EventDriven& scheme() { return scheme_; }
  /// Runs to the end, and calls `after` after each step. Returns the reason of an earlier stop, else nothing.
  template <class After>
  std::string go(After after) {
    while (scheme_.t() < run_.end) {
      if (run_.stop()) throw Interrupted();
      if (!scheme_.step(std::min(run_.end, scheme_.t() + run_.longest_step))) {
        scheme_.variation().refuse(scheme_.failure());
        return scheme_.failure();
      }
      after();
      log_.advance(scheme_.t());
      log_.drain([](const auto&) {});
    }
    return {};
  }
  std::vector<VariedOnset> onsets() {
    auto list = scheme_.variation().onsets();
    std::ranges::stable_sort(list, {}, &VariedOnset::t);
    return list;
  }

 private:
  const SensitivityRun& run_;
  std::vector<double> restitution_;
  EventDriven scheme_;
  ContactLog log_;
};

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

void run_event_driven(const SensitivityRun& run, Sensitivities& all) {
  VariedRun motion(run, integrands_of(run));
  auto& scheme = motion.scheme();
  auto& variation = scheme.variation();
  variation.watch_peaks(channels_of(run));
  all.stopped = motion.go([] {});
  const auto& d = scheme.dynamics();
  take_quantities(
      run, variation, d,
      {scheme.x(), scheme.t(), "the event begins a lasting contact, which has no impulse at its beginning"},
      [](EnergyTerm term, EventDynamics& f, const std::vector<double>& x, double) {
        return summed_energy<EventDynamics>(term, f, x);
      },
      [&](Sensitivity& s, const std::vector<std::string>& ended) {
        s.value = d.contact_loss;
        s.reasons = ended;
        for (std::size_t c = 0; c < ended.size(); ++c)
          if (ended[c].empty()) s.derivatives[c] = variation.contact_loss()[c];
        return true;
      },
      all);
  all.cost = cost_of(variation.evaluations(), scheme.work().rhs);
}

const MoreauStepper& moreau_of(const MoreauStepper& stepper) { return stepper; }
const MoreauStepper& moreau_of(const AdaptiveMoreau& stepper) { return stepper.moreau(); }

template <class Stepper>
void run_steps(const SensitivityRun& run, Stepper stepper, Sensitivities& all) {
  const auto& options = run.scene.nonsmooth;
  const auto scales = make_scales(run.scene.mechanism, run.system, run.start);
  const auto restitution = restitution_of(run.system);
  ContactLog log(run.system.contacts(), run.system.reported());
  stepper.start(run.start, log);
  EventDynamics mode(run.system, options, restitution, row_facts(run), scales.speed);
  StepVariation variation(mode, run.keys, integrands_of(run), least_curved_length(run.system),
                          run.end - run.start.t, options.tolerance * scales.length);
  variation.watch_peaks(channels_of(run));
  variation.start(run.start);
  while (stepper.t() < run.end) {
    if (run.stop()) throw Interrupted();
    if (!stepper.step(run.end)) {
      all.stopped = stepper.failure();
      variation.refuse(all.stopped);
      break;
    }
    variation.end_step(moreau_of(stepper), stepper.t_old());
    log.advance(stepper.t());
    log.drain([](const auto&) {});
  }
  variation.finish();
  take_quantities(
      run, variation, mode,
      {variation.x(), stepper.t(),
       "the event begins a lasting contact, which has no impulse at its beginning"},
      [](EnergyTerm term, EventDynamics& f, const std::vector<double>& x, double) {
        return summed_energy<EventDynamics>(term, f, x);
      },
      [&](Sensitivity& s, const std::vector<std::string>& ended) {
        s.value = stepper.integrals().contact;
        s.reasons = ended;
        for (std::size_t c = 0; c < ended.size(); ++c)
          if (ended[c].empty()) s.derivatives[c] = variation.contact_loss()[c];
        return true;
      },
      all);
  all.cost = cost_of(variation.evaluations(), stepper.work().rhs);
}

void run_time_stepping(const SensitivityRun& run, Sensitivities& all) {
  const auto& options = run.scene.nonsmooth;
  if (!run.system.families().empty())
    throw ModelError("nonsmooth.scheme", "groups of many bodies have no derivatives");
  const auto restitution = restitution_of(run.system);
  if (options.step)
    run_steps(run, MoreauStepper(run.system, options, *options.step, restitution, row_facts(run)), all);
  else
    run_steps(run, make_adaptive(run.scene, run.system, restitution, row_facts(run), run.start), all);
}

void run_penalty(const SensitivityRun& run, Sensitivities& all) {
  const auto parts = make_penalty_parts(run.scene, run.system, run.start);
  auto& steps = *parts.steps;
  PenaltyVariation variation(parts, run.scene, run.start, run.keys, integrands_of(run),
                             least_curved_length(run.system), run.end - run.start.t);
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

namespace {

/// Fills an EndState from the integrated vector x, its columns and its onsets at the end of a run.
template <class Variation, class Present>
void take_end(const SensitivityRun& run, Variation& variation, const Present& d, const std::vector<double>& x,
              double t, int state_offset, EndState& end) {
  const auto& system = run.system;
  const auto n = static_cast<std::size_t>(system.n()), states = static_cast<std::size_t>(system.states());
  const auto offset = static_cast<std::size_t>(state_offset);
  const auto parts = [&](const std::vector<double>& all) {
    std::vector<double> list(all.begin(), all.begin() + static_cast<long>(2 * n));
    list.insert(list.end(), all.begin() + static_cast<long>(offset),
                all.begin() + static_cast<long>(offset + states));
    return list;
  };
  const auto values = parts(x);
  end.state = {t, {}, {}, {}};
  end.state.q.assign(values.begin(), values.begin() + static_cast<long>(n));
  end.state.v.assign(values.begin() + static_cast<long>(n), values.begin() + static_cast<long>(2 * n));
  end.state.z.assign(values.begin() + static_cast<long>(2 * n), values.end());
  auto norm = motion_norm(system, make_scales(run.scene.mechanism, system, run.start), 1);
  add_states(norm, system, static_cast<int>(2 * n));
  for (std::size_t i = 0; i < values.size(); ++i)
    end.scales.push_back(norm.absolute[i] + norm.relative[i] * std::abs(values[i]));
  end.potential = system.potential(x.data());
  end.kinetic = system.kinetic(x.data() + n);
  for (std::size_t c = 0; c < run.keys.size(); ++c)
    if (end.refused.empty()) end.refused = variation.reason(c);
  if (end.refused.empty())
    for (const auto& column : variation.end_columns(d, x, t)) end.columns.push_back(parts(column));
  auto onsets = variation.onsets();
  std::ranges::stable_sort(onsets, {}, &VariedOnset::t);
  for (const auto& onset : onsets)
    end.onsets.push_back({onset.contact, onset.t, onset.rate, onset.dt, onset.drate});
}

EndState penalty_end_state(const SensitivityRun& run) {
  const auto parts = make_penalty_parts(run.scene, run.system, run.start);
  auto& steps = *parts.steps;
  PenaltyVariation variation(parts, run.scene, run.start, run.keys, {}, least_curved_length(run.system),
                             run.end - run.start.t);
  EndState end;
  while (steps.t() < run.end) {
    if (run.stop()) throw Interrupted();
    variation.begin_step();
    if (!steps.step(std::min(run.end, steps.t() + run.longest_step))) {
      end.stopped = steps.failure();
      variation.refuse(end.stopped);
      break;
    }
    variation.end_step();
  }
  take_end(run, variation, steps.dynamics(), variation.x(), steps.t(), steps.dynamics().state_offset(), end);
  return end;
}

}  // namespace

EndState run_end_state(SensitivityRun run) { return run_end_state(std::move(run), Family::nonsmooth); }

EndState run_end_state(SensitivityRun run, Family family) {
  if (family == Family::penalty) return penalty_end_state(run);
  VariedRun motion(run, {});
  auto& scheme = motion.scheme();
  EndState end;
  LeastForces forces(scheme);
  end.stopped = motion.go([&] { forces.add_step(scheme); });
  end.lasting = forces.lasting();
  take_end(run, scheme.variation(), scheme.dynamics(), scheme.x(), scheme.t(),
           scheme.dynamics().state_offset(), end);
  return end;
}

}  // namespace freeplay
