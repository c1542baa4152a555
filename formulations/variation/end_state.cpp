#include "formulations/variation/end_state.hpp"

#include <boost/math/tools/minima.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "dynamics/system.hpp"
#include "formulations/automatic/automatic.hpp"
#include "formulations/event_driven/event_driven.hpp"
#include "formulations/integrators/tolerance.hpp"
#include "formulations/nonsmooth.hpp"
#include "formulations/penalty/dynamics.hpp"
#include "formulations/penalty/penalty.hpp"
#include "formulations/penalty/penalty_variation.hpp"
#include "formulations/variation/varied_run.hpp"
#include "mechanism/scene.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

constexpr std::size_t parts = 4;  // of a step
/// A minimum is known to half the digits of the force in its time, thus to all digits in its value.
constexpr int bits = 26;

}  // namespace

void LeastForces::add_step(double t0, double h, const std::function<bool(int)>& closed,
                           const std::function<double(int, double)>& force) {
  if (!(h > 0)) return;
  if (!begun_)
    for (int k = 0; k < contacts_; ++k)
      if (closed(k)) list_.push_back({.contact = k});
  begun_ = true;
  std::erase_if(list_, [&](const auto& one) { return !closed(one.contact); });
  for (auto& one : list_) {
    const auto at = [&](double t) { return force(one.contact, t); };
    const auto take = [&](double t, double value) {
      if (value < one.least) one.least = value, one.t = t;
      one.greatest = std::max(one.greatest, value);
    };
    std::array<double, parts + 1> f{};
    for (std::size_t i = 0; i <= parts; ++i) {
      const double t = t0 + static_cast<double>(i) / parts * h;
      take(t, f[i] = at(t));
    }
    // Around the least samples; at an end of the step, the minimum may be on either side of it.
    const double width = h / parts;
    for (std::size_t i = 0; i <= parts; ++i) {
      const std::size_t middle = std::clamp<std::size_t>(i, 1, parts - 1);
      if ((i > 0 && f[i - 1] < f[i]) || (i < parts && f[i + 1] < f[i])) continue;
      const double bend = std::abs(f[middle - 1] - 2 * f[middle] + f[middle + 1]);
      if (f[i] - bend > one.least) continue;
      const double t = t0 + static_cast<double>(i) * width;
      const auto [share, value] = boost::math::tools::brent_find_minima(
          [&](double s) { return at(t + s * width); }, i > 0 ? -1.0 : 0.0, i < parts ? 1.0 : 0.0, bits);
      take(t + share * width, value);
    }
  }
}

// The state at the end of a run and its derivatives, by each scheme.

namespace {

/// Fills an EndState from the integrated vector x, its columns and its onsets at the end of a run.
template <class Variation, class Present>
void take_end(const SensitivityRun& run, Variation& variation, const Present& d, const std::vector<double>& x,
              double t, EndState& end) {
  const auto& system = run.system;
  const auto n = static_cast<std::size_t>(system.n()), states = static_cast<std::size_t>(system.states());
  const auto offset = static_cast<std::size_t>(d.state_offset());
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
}

void add_onsets(const std::vector<VariedOnset>& onsets, EndState& end) {
  for (const auto& onset : onsets)
    end.onsets.push_back({onset.contact, onset.t, onset.rate, onset.dt, onset.drate});
  std::ranges::stable_sort(end.onsets, {}, &EndState::Onset::t);
}

EndState by_events(const SensitivityRun& run) {
  VariedRun motion(
      run, {},
      make_event_driven(run.scene, run.system, restitution_of(run.system), row_facts(run), run.start));
  auto& scheme = motion.scheme();
  use_traced(run, scheme.variation());
  EndState end;
  LeastForces forces(run.system.contacts());
  const auto probe = scheme.dynamics().twin();
  std::vector<double> slope(static_cast<std::size_t>(probe->size()));
  end.stopped = motion.go([&] {
    probe->take_mode(scheme.dynamics());
    forces.add_step(
        scheme.t_old(), scheme.t() - scheme.t_old(), [&](int k) { return probe->contacts[k].closed; },
        [&](int k, double t) {
          (*probe)(scheme.x_at(t), slope, t);
          return probe->contacts[k].lambda_n;
        });
  });
  end.lasting = forces.lasting();
  take_end(run, scheme.variation(), scheme.dynamics(), scheme.x(), scheme.t(), end);
  add_onsets(scheme.variation().onsets(), end);
  end.fastest = motion.fastest();
  return end;
}

EndState by_automatic_scheme(const SensitivityRun& run) {
  VariedRun motion(
      run, {}, make_automatic(run.scene, run.system, restitution_of(run.system), row_facts(run), run.start));
  auto& scheme = motion.scheme();
  use_traced(run, scheme.events().variation(), scheme.stepped());
  EndState end;
  end.stopped = motion.go([] {});
  end.stepped = scheme.work().handovers > 0;
  auto& events = scheme.events();
  if (scheme.time_steps()) {
    scheme.stepped().finish();
    take_end(run, scheme.stepped(), scheme.stepped_mode(), scheme.stepped().x(), scheme.t(), end);
  } else {
    take_end(run, events.variation(), events.dynamics(), events.x(), scheme.t(), end);
  }
  add_onsets(events.variation().onsets(), end);
  add_onsets(scheme.stepped().onsets(), end);
  end.fastest = motion.fastest();
  return end;
}

EndState by_time_stepping(const SensitivityRun& run) {
  EndState end;
  end.stepped = true;
  with_varied_steps(run, {}, [&](auto& steps) {
    end.stopped = steps.go();
    auto& variation = steps.variation();
    take_end(run, variation, steps.mode(), variation.x(), steps.stepper().t(), end);
    add_onsets(variation.onsets(), end);
  });
  return end;
}

/// Normal forces of the last step of a penalty run, in the modes before it.
class PressingForces {
 public:
  explicit PressingForces(const PenaltySteps& steps)
      : steps_(steps), probe_(steps.dynamics().twin()), x_(steps.x().size()) {}
  void begin_step() {
    for (std::size_t k = 0; k < probe_->contacts().size(); ++k)
      probe_->contacts()[k].mode() = steps_.dynamics().contacts()[k].mode();
  }
  /// A contact that closes or opens at the end of the step is open within or after it.
  bool closed(int k) const { return probe_->contacts()[k].closed && steps_.dynamics().contacts()[k].closed; }
  double at(int k, double t) {
    const int n = probe_->system().n();
    steps_.interpolate(t, x_.data(), x_.data() + n);
    const auto& row = probe_->contact_rows.at(k, x_, t);
    return probe_->contacts()[k].normal_force(row.gap, row.normal.dot(x_.data() + n));
  }
  /// Whether contact k began, ended, or had an impact at the end of the step.
  bool changed(int k) const {
    const auto &was = probe_->contacts()[k], &now = steps_.dynamics().contacts()[k];
    return was.closed != now.closed || was.in_impact != now.in_impact;
  }

 private:
  const PenaltySteps& steps_;
  std::unique_ptr<PenaltyDynamics> probe_;
  std::vector<double> x_;
};

/// What contacts retain, and its derivatives, after q, v and z.
void add_retained(const PenaltyParts& parts, PenaltyVariation& variation, EndState& end) {
  const auto& d = parts.steps->dynamics();
  for (const auto& c : d.contacts()) {
    end.contacts.push_back(c.mode());
    end.retains.push_back(c.law.chi > 0);
    end.scales.insert(end.scales.end(), {parts.speed_scale + c.v0, c.mass});
  }
  const auto columns = variation.end_columns(d, variation.x(), parts.steps->t());
  for (std::size_t c = 0; c < end.columns.size(); ++c)
    end.columns[c].insert(end.columns[c].end(), columns[c].begin() + d.size(), columns[c].end());
}

EndState by_contact_forces(const SensitivityRun& run) {
  const auto parts = make_penalty_parts(run.scene, run.system, run.start, run.contacts);
  auto& steps = *parts.steps;
  PenaltyVariation variation(parts, run.scene, run.start, run.keys, {}, least_curved_length(run.system),
                             run.end - run.start.t);
  use_traced(run, variation);
  EndState end;
  end.renewed.resize(static_cast<std::size_t>(run.system.contacts()));
  LeastForces least(run.system.contacts());
  PressingForces forces(steps);
  while (steps.t() < run.end) {
    if (run.stop()) throw Interrupted();
    variation.begin_step();
    forces.begin_step();
    if (!steps.step(std::min(run.end, steps.t() + run.longest_step))) {
      end.stopped = steps.failure();
      variation.refuse(end.stopped);
      break;
    }
    variation.end_step();
    for (int k = 0; k < run.system.contacts(); ++k)
      if (forces.changed(k)) end.renewed[static_cast<std::size_t>(k)] = true;
    if (std::isfinite(run.longest_step))  // not while settling
      least.add_step(
          steps.t_old(), steps.t() - steps.t_old(), [&](int k) { return forces.closed(k); },
          [&](int k, double t) { return forces.at(k, t); });
  }
  end.lasting = least.lasting();
  take_end(run, variation, steps.dynamics(), variation.x(), steps.t(), end);
  add_retained(parts, variation, end);
  add_onsets(variation.onsets(), end);
  return end;
}

}  // namespace

EndState run_end_state(const SensitivityRun& run, Family family) {
  if (family == Family::penalty) return by_contact_forces(run);
  const auto& options = run.scene.nonsmooth;
  const auto scheme = options.scheme_in_force();
  if (scheme == Scheme::moreau_jean) return by_time_stepping(run);
  // Impact laws that time stepping does not have stay event-driven.
  return scheme == Scheme::automatic && options.chooses_steps() ? by_automatic_scheme(run) : by_events(run);
}

}  // namespace freeplay
