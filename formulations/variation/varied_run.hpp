// VariedRun: a run of a nonsmooth scheme with its variational equations, for derivatives of quantities
// (sensitivity.cpp) and of the state at the end (end_state.cpp). A Scheme is an EventDriven or an
// AutomaticStepper; both have vary() and refuse_derivatives().
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "formulations/event_driven/event_driven.hpp"
#include "formulations/integrators/tolerance.hpp"
#include "formulations/nonsmooth.hpp"
#include "formulations/time_stepping/adaptive.hpp"
#include "formulations/variation/sensitivity.hpp"
#include "formulations/variation/step_variation.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "simulation/contact_log.hpp"
#include "values/stop.hpp"

namespace freeplay {

inline std::vector<double> restitution_of(const System& system) {
  std::vector<double> list;
  for (int k = 0; k < system.contacts(); ++k)
    list.push_back(system.contact_facts(k).surface.restitution.value_or(0));
  return list;
}

inline RowFacts row_facts(const SensitivityRun& run) {
  return {!redundant_rows(run.system, run.start.q).empty(), run.scene.run.eliminate};
}

inline const MoreauStepper& moreau_of(const MoreauStepper& stepper) { return stepper; }
inline const MoreauStepper& moreau_of(const AdaptiveMoreau& stepper) { return stepper.moreau(); }

/// Lets these objects of the run use traced equations.
void use_traced(const SensitivityRun& run, auto&... variations) {
  if (!run.traced) return;
  TracedEquations own;
  (variations.trace(run.equations ? *run.equations : own, run.start), ...);
}

template <class Scheme>
class VariedRun {
 public:
  VariedRun(const SensitivityRun& run, const std::vector<Column>& integrands, Scheme scheme)
      : run_(run), scheme_(std::move(scheme)), log_(run.system.contacts(), run.system.reported()) {
    scheme_.start(run.start, log_);
    scheme_.vary(run.keys, integrands, least_curved_length(run.system), run.end - run.start.t);
  }
  Scheme& scheme() { return scheme_; }
  /// Runs to the end, and calls `after` after each step. Returns the reason of an earlier stop, else nothing.
  template <class After>
  std::string go(After after) {
    for (double steps = 0; scheme_.t() < run_.end; ++steps) {
      if (run_.stop()) throw Interrupted();
      if (steps >= run_.most_steps) return "the run takes too many steps";
      if (!scheme_.step(std::min(run_.end, scheme_.t() + run_.longest_step))) {
        scheme_.refuse_derivatives(scheme_.failure());
        return scheme_.failure();
      }
      after();
      for (int i = 0; i < run_.system.n(); ++i) fastest_ = std::max(fastest_, std::abs(scheme_.v()[i]));
      log_.advance(scheme_.t());
      log_.drain([](const auto&) {});
    }
    return {};
  }
  /// Greatest rate of a coordinate at the ends of the steps.
  double fastest() const { return fastest_; }

 private:
  const SensitivityRun& run_;
  double fastest_ = 0;
  Scheme scheme_;
  ContactLog log_;
};

/// Likewise a run of time stepping, by a MoreauStepper or an AdaptiveMoreau. Its steps do not depend on
/// SensitivityRun::longest_step: they define the motion.
template <class Stepper>
class VariedSteps {
 public:
  VariedSteps(const SensitivityRun& run, std::vector<Column> integrands, Stepper stepper)
      : run_(run),
        stepper_(std::move(stepper)),
        log_(run.system.contacts(), run.system.reported()),
        scales_(make_scales(run.scene.mechanism, run.system, run.start)),
        mode_(run.system, run.scene.nonsmooth, restitution_of(run.system), row_facts(run), scales_.speed),
        variation_(mode_, run.keys, std::move(integrands), least_curved_length(run.system),
                   run.end - run.start.t, run.scene.nonsmooth.tolerance * scales_.length) {
    stepper_.start(run.start, log_);
  }
  const Stepper& stepper() const { return stepper_; }
  const EventDynamics& mode() const { return mode_; }
  StepVariation& variation() { return variation_; }
  /// Runs to the end. Returns the reason of an earlier stop, else nothing.
  std::string go() {
    std::string stopped;
    use_traced(run_, variation_);
    variation_.start(run_.start);
    while (stopped.empty() && stepper_.t() < run_.end) {
      if (run_.stop()) throw Interrupted();
      if (!stepper_.step(run_.end)) {
        stopped = stepper_.failure();
        variation_.refuse(stopped);
        break;
      }
      variation_.end_step(moreau_of(stepper_), stepper_.t_old());
      log_.advance(stepper_.t());
      log_.drain([](const auto&) {});
    }
    variation_.finish();
    return stopped;
  }

 private:
  const SensitivityRun& run_;
  Stepper stepper_;
  ContactLog log_;
  Scales scales_;
  EventDynamics mode_;
  StepVariation variation_;
};

/// Calls use(VariedSteps&) for the stepper that the scene asks for.
template <class Use>
void with_varied_steps(const SensitivityRun& run, const std::vector<Column>& integrands, Use use) {
  if (!run.system.families().empty())
    throw ModelError("nonsmooth.scheme", "groups of many bodies have no derivatives");
  const auto restitution = restitution_of(run.system);
  const auto& options = run.scene.nonsmooth;
  if (options.step) {
    VariedSteps steps(run, integrands,
                      MoreauStepper(run.system, options, *options.step, restitution, row_facts(run)));
    use(steps);
  } else {
    VariedSteps steps(run, integrands,
                      make_adaptive(run.scene, run.system, restitution, row_facts(run), run.start));
    use(steps);
  }
}

}  // namespace freeplay
