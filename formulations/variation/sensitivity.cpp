#include "formulations/variation/sensitivity.hpp"

#include <fmt/format.h>

#include <type_traits>

#include "formulations/variation/variational_run.hpp"

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
/// Relative difference of derivatives that the differences of closed forms explain.
constexpr double same_derivative = 1e-9;

/// Which of two simultaneous events has a number depends on a key by which their times change differently.
void refuse_ties(const VariedOnset& onset, const std::vector<VariedOnset>& onsets, Sensitivity& s) {
  for (const auto& other : onsets) {
    if (&other == &onset || std::abs(other.t - onset.t) > same_time * std::abs(onset.t)) continue;
    for (std::size_t c = 0; c < s.reasons.size(); ++c) {
      const double a = onset.dt[c], b = other.dt[c];
      if (s.reasons[c].empty() && !(std::abs(a - b) <= same_derivative * std::max(std::abs(a), std::abs(b))))
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

double energy_of(EnergyTerm term, EventDynamics& f, const std::vector<double>& x, double /*t*/) {
  return summed_energy<EventDynamics>(term, f, x);
}
double energy_of(EnergyTerm term, ExtendedPenalty& f, const std::vector<double>& x, double t) {
  if (term != EnergyTerm::contact) return summed_energy<PenaltyDynamics>(term, f, x);
  return x[static_cast<std::size_t>(f.integral_offset()) + PenaltyDynamics::contact_work] -
         f.stored_energy(x, t);
}

/// Evaluates all quantities at the end of a run.
template <class Scheme>
void take_quantities(const SensitivityRun& run, Scheme& scheme, Sensitivities& all) {
  auto& variation = scheme.variation();
  const auto& d = scheme.mode();
  const auto& x_end = scheme.x();
  const double t_end = scheme.t();
  const auto keys = run.keys.size();
  auto onsets = variation.onsets();
  std::ranges::stable_sort(onsets, {}, &VariedOnset::t);
  std::vector<std::string> ended;
  for (std::size_t c = 0; c < keys; ++c) ended.push_back(variation.reason(c));
  using Function = typename std::remove_reference_t<decltype(variation)>::Function;
  using Vector = std::vector<double>;
  const auto at_end = [&](const Function& value, Sensitivity& s) {
    s.derivatives = variation.end_derivatives(d, x_end, t_end, value, s.value, s.reasons);
    for (const auto& onset : onsets)
      for (std::size_t c = 0; c < keys; ++c)
        if (std::abs(onset.t - t_end) <= same_time * std::abs(t_end) && s.reasons[c].empty() &&
            !(std::abs(onset.dt[c] - run.keys[c].end_rate) <=
              1e-12 * std::abs(t_end) / run.keys[c].scale())) {
          s.reasons[c] = fmt::format("a contact closes at the end of the run, t = {:.9g} s", t_end);
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
        take_event(q, onsets, ended, Scheme::lasting, s);
        break;
      case Of::mean:
        s.value = variation.mean(integral, run.start.t, t_end);
        s.derivatives = variation.mean_derivatives(integral++, d, x_end, run.start.t, t_end);
        s.reasons = ended;
        break;
      case Of::peak: {
        const auto found = variation.peak(peak++, d, x_end, t_end);
        s.value = found.y;
        s.derivatives = found.slope;
        s.reasons = found.reasons;
        break;
      }
      case Of::energy:
        // The vector of nonsmooth runs does not contain the energy lost in contacts.
        if constexpr (requires { scheme.contact_loss(); })
          if (q.term == EnergyTerm::contact) {
            s.value = scheme.contact_loss();
            s.reasons = ended;
            for (std::size_t c = 0; c < keys; ++c)
              if (ended[c].empty()) s.derivatives[c] = variation.contact_loss()[c];
            break;
          }
        at_end([&](auto& f, const Vector& x, double t) { return Vector{energy_of(q.term, f, x, t)}; }, s);
        break;
      case Of::end:
        at_end([&](auto& f, const Vector& x, double t) { return Vector{observed(q.column, f, x, t)}; }, s);
        break;
    }
  }
}

}  // namespace

Sensitivities run_sensitivities(const SensitivityRun& run, Family family) {
  Sensitivities all;
  for (const auto& key : run.keys) {
    all.keys.push_back(key.name);
    all.key_values.push_back(key.value);
  }
  std::vector<Column> integrands;
  std::vector<PeakChannel> channels;
  for (const auto& q : run.quantities) {
    if (q.of == Of::mean) integrands.push_back(q.column);
    if (q.of == Of::peak) channels.push_back(q.channel);
  }
  with_variational_run<false>(run, family, integrands, [&](auto& motion) {
    motion.variation().watch_peaks(channels);
    while (motion.step()) {
    }
    all.stopped = motion.stopped();
    take_quantities(run, motion.scheme(), all);
    all.cost = motion.cost();
  });
  return all;
}

}  // namespace freeplay
