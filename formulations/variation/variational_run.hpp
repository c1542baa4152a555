// VariationalRun: a run of a scheme with its variational equations, for derivatives of quantities
// (sensitivity.cpp), of the state at the end (end_state.cpp), and for tangent vectors (tangent_run.cpp).
//
// A scheme has the members
//
//     vary(keys, integrands, length, duration, now)
//                                                begins columns at the present state; see VariedColumns
//     step(end, longest)                         a step of at most `longest` (s), not beyond `end` (s);
//                                                false if there is none, with failure()
//     finish()                                   after the last step
//     variation(), mode(), x()                   the columns, and the mode and the vector of the motion
//     variations()                               these columns, and those of a scheme that it hands over to
//     evaluations()                              of the right-hand side, without those of the columns
//     steps_in_time()                            whether time stepping has made a step
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/sampling.hpp"
#include "dynamics/system.hpp"
#include "formulations/automatic/automatic.hpp"
#include "formulations/event_driven/event_driven.hpp"
#include "formulations/integrators/tolerance.hpp"
#include "formulations/nonsmooth.hpp"
#include "formulations/penalty/penalty_variation.hpp"
#include "formulations/time_stepping/adaptive.hpp"
#include "formulations/variation/sensitivity.hpp"
#include "formulations/variation/step_variation.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "simulation/contact_log.hpp"
#include "values/family.hpp"
#include "values/stop.hpp"

namespace freeplay {

inline std::vector<double> restitution_of(const SensitivityRun& run) {
  if (!run.restitution.empty()) return run.restitution;
  std::vector<double> list;
  for (int k = 0; k < run.system.contacts(); ++k)
    list.push_back(run.system.contact_facts(k).surface.slow_restitution().value_or(0));
  return list;
}

inline RowFacts row_facts(const SensitivityRun& run) {
  return {!redundant_rows(run.system, run.start.q).empty(), run.scene.run.eliminate};
}

/// Common part of the nonsmooth schemes. `make`: a factory of formulations/nonsmooth.hpp.
template <class Stepper>
class NonsmoothScheme {
 public:
  static constexpr const char* lasting =
      "the event begins a lasting contact, which has no impulse at its beginning";
  const Stepper& stepper() const { return stepper_; }
  void vary(const std::vector<VariedKey>& keys, std::vector<Column> integrands, double length,
            double duration, const State& /*now*/) {
    stepper_.vary(keys, std::move(integrands), length, duration);
  }
  bool step(double end, double longest) {
    if (!stepper_.step(std::min(end, t() + longest))) return false;
    log_.advance(t());
    log_.drain([](const auto&) {});
    return true;
  }
  void finish() {}
  double t() const { return stepper_.t(); }
  const double* v() const { return stepper_.v(); }
  const std::string& failure() const { return stepper_.failure(); }
  long evaluations() const { return stepper_.work().rhs; }
  double contact_loss() const { return stepper_.integrals().contact; }

 protected:
  template <class Make>
  NonsmoothScheme(const SensitivityRun& run, Make make)
      : stepper_(make(run.scene, run.system, restitution_of(run), row_facts(run), run.start)),
        log_(run.system.contacts(), run.system.reported()) {
    stepper_.start(run.start, log_);
  }

  Stepper stepper_;
  ContactLog log_;
};

class EventScheme : public NonsmoothScheme<EventDriven> {
 public:
  explicit EventScheme(const SensitivityRun& run) : NonsmoothScheme(run, make_event_driven) {}
  bool steps_in_time() const { return false; }
  Variation& variation() { return stepper_.variation(); }
  std::array<Variation*, 1> variations() { return {&variation()}; }
  const EventDynamics& mode() const { return stepper_.dynamics(); }
  const std::vector<double>& x() const { return stepper_.x(); }
  const std::vector<double>& vector() const { return x(); }
  double contact_loss() const { return mode().contact_loss; }
};

class AutomaticScheme : public NonsmoothScheme<AutomaticStepper> {
 public:
  explicit AutomaticScheme(const SensitivityRun& run) : NonsmoothScheme(run, make_automatic) {}
  void finish() {
    if (in_time()) stepper_.stepped().finish();
  }
  bool steps_in_time() const { return stepper_.work().handovers > 0; }
  Variation& variation() { return in_time() ? stepper_.stepped() : stepper_.events().variation(); }
  std::array<Variation*, 2> variations() { return {&stepper_.events().variation(), &stepper_.stepped()}; }
  const EventDynamics& mode() { return in_time() ? stepper_.stepped_mode() : stepper_.events().dynamics(); }
  const std::vector<double>& x() { return in_time() ? stepper_.stepped().x() : stepper_.events().x(); }

 private:
  bool in_time() const { return stepper_.time_steps(); }
};

inline MoreauStepper make_moreau(const Scene& scene, const System& system,
                                 const std::vector<double>& restitution, RowFacts facts, const State&) {
  return {system, scene.nonsmooth, *scene.nonsmooth.step, restitution, facts};
}
inline const MoreauStepper& moreau_of(const MoreauStepper& stepper) { return stepper; }
inline const MoreauStepper& moreau_of(const AdaptiveMoreau& stepper) { return stepper.moreau(); }

/// Time stepping with fixed or adaptive steps. They define the motion, and do not depend on
/// SensitivityRun::longest_step.
template <auto make, class Stepper>
class TimeSteps : public NonsmoothScheme<Stepper> {
 public:
  explicit TimeSteps(const SensitivityRun& run)
      : NonsmoothScheme<Stepper>(run, make),
        scales_(make_scales(run.scene.mechanism, run.system, run.start)),
        position_error_(run.scene.nonsmooth.tolerance * scales_.length),
        mode_(run.system, run.scene.nonsmooth, restitution_of(run), row_facts(run), scales_.speed) {}
  void vary(const std::vector<VariedKey>& keys, std::vector<Column> integrands, double length,
            double duration, const State& now) {
    variation_ = std::make_unique<StepVariation>(mode_, keys, std::move(integrands), length, duration,
                                                 position_error_);
    variation_->start(now);
  }
  bool step(double end, double /*longest*/) {
    const auto& stepper = this->stepper_;
    if (!NonsmoothScheme<Stepper>::step(end, INFINITY)) return false;
    variation_->end_step(moreau_of(stepper), stepper.t_old());
    return true;
  }
  void finish() { variation_->finish(); }
  bool steps_in_time() const { return true; }
  StepVariation& variation() { return *variation_; }
  std::array<StepVariation*, 1> variations() { return {&variation()}; }
  const EventDynamics& mode() const { return mode_; }
  const std::vector<double>& x() const { return variation_->x(); }

 private:
  Scales scales_;
  double position_error_;
  EventDynamics mode_;
  std::unique_ptr<StepVariation> variation_;
};

class PenaltyScheme {
 public:
  static constexpr const char* lasting = "the contact lasts to the end of the run";
  explicit PenaltyScheme(const SensitivityRun& run)
      : run_(run), parts_(make_penalty_parts(run.scene, run.system, run.start, run.contacts)) {}
  void vary(const std::vector<VariedKey>& keys, std::vector<Column> integrands, double length,
            double duration, const State& now) {
    variation_ = std::make_unique<PenaltyVariation>(parts_, run_.scene, now, keys, std::move(integrands),
                                                    length, duration);
  }
  bool step(double end, double longest) {
    if (variation_) variation_->begin_step();
    if (!parts_.steps->step(std::min(end, t() + longest))) return false;
    if (variation_) variation_->end_step();
    return true;
  }
  void finish() {}
  bool steps_in_time() const { return false; }
  const PenaltyParts& parts() const { return parts_; }
  const PenaltySteps& steps() const { return *parts_.steps; }
  double t() const { return steps().t(); }
  /// Without the data that contacts retain, which x() has.
  const std::vector<double>& vector() const { return steps().x(); }
  const double* v() const { return vector().data() + run_.system.n(); }
  std::string failure() const { return steps().failure(); }
  long evaluations() const { return mode().work.rhs; }
  PenaltyVariation& variation() { return *variation_; }
  std::array<PenaltyVariation*, 1> variations() { return {variation_.get()}; }
  const PenaltyDynamics& mode() const { return steps().dynamics(); }
  std::vector<double> x() const { return variation_->x(); }

 private:
  const SensitivityRun& run_;
  PenaltyParts parts_;
  std::unique_ptr<PenaltyVariation> variation_;
};

template <class Scheme>
class VariationalRun {
 public:
  /// Starts the scheme; `run` must outlive this object. Throws ModelError if a controller is sampled.
  explicit VariationalRun(const SensitivityRun& run) : run_(run), scheme_(continuous(run)) {}

  Scheme& scheme() { return scheme_; }
  auto& variation() { return scheme_.variation(); }
  /// Begins columns at the present state. `duration` (s): see VariedColumns.
  void vary(const std::vector<VariedKey>& keys, std::vector<Column> integrands, double duration,
            const State& now) {
    scheme_.vary(keys, std::move(integrands), least_curved_length(run_.system), duration, now);
    varied_ = true;
    TracedEquations own;
    for (auto* variation : scheme_.variations())
      if (run_.traced) variation->trace(run_.equations ? *run_.equations : own, now);
  }
  /// Makes a step to `end` (s) or before. Returns false if there is none: the run then has stopped(), and no
  /// column has a derivative. Throws Interrupted if a stop is requested.
  bool step(double end) {
    if (run_.stop()) throw Interrupted();
    if (!scheme_.step(end, run_.longest_step)) return stop(scheme_.failure());
    for (int i = 0; i < run_.system.n(); ++i) fastest_ = std::max(fastest_, std::abs(scheme_.v()[i]));
    return true;
  }
  /// Likewise to the end of the run; false there, too.
  bool step() {
    if (scheme_.t() < run_.end) {
      if (++steps_ <= run_.most_steps) {
        if (step(run_.end)) return true;
      } else {
        stopped_ = "the run takes too many steps";
      }
    }
    scheme_.finish();
    return false;
  }
  /// The reason of an earlier stop.
  const std::string& stopped() const { return stopped_; }
  /// Evaluations for the columns over those of the run.
  double cost() {
    const auto own = scheme_.evaluations();
    return varied_ && own > 0 ? static_cast<double>(variation().evaluations()) / static_cast<double>(own) : 0;
  }
  /// Greatest rate of a coordinate at the ends of the steps.
  double fastest() const { return fastest_; }

 private:
  static const SensitivityRun& continuous(const SensitivityRun& run) {
    refuse_sampling(run.system, no_derivatives);
    return run;
  }
  bool stop(const std::string& why) {
    stopped_ = why;
    if (varied_)
      for (auto* variation : scheme_.variations()) variation->refuse(why);
    return false;
  }

  const SensitivityRun& run_;
  Scheme scheme_;
  bool varied_ = false;
  double steps_ = 0, fastest_ = 0;
  std::string stopped_;
};

/// Calls use(VariationalRun&) with the columns of all keys, for the formulation and the scheme of the scene.
/// `hands_over`: whether the automatic scheme may hand over to time stepping; else it is event-driven.
template <bool hands_over, class Use>
void with_variational_run(const SensitivityRun& run, Family family, const std::vector<Column>& integrands,
                          Use use) {
  const auto with = [&]<class Scheme>() {
    VariationalRun<Scheme> motion(run);
    motion.vary(run.keys, integrands, run.end - run.start.t, run.start);
    use(motion);
  };
  const auto& options = run.scene.nonsmooth;
  const auto scheme = options.scheme_in_force();
  if (family == Family::penalty) return with.template operator()<PenaltyScheme>();
  if (scheme == Scheme::moreau_jean) {
    if (!run.system.families().empty())
      throw ModelError("nonsmooth.scheme", "groups of many bodies have no derivatives");
    if (options.step) return with.template operator()<TimeSteps<make_moreau, MoreauStepper>>();
    return with.template operator()<TimeSteps<make_adaptive, AdaptiveMoreau>>();
  }
  // Impact laws that time stepping does not have stay event-driven.
  if constexpr (hands_over)
    if (scheme == Scheme::automatic && options.chooses_steps())
      return with.template operator()<AutomaticScheme>();
  with.template operator()<EventScheme>();
}

}  // namespace freeplay
