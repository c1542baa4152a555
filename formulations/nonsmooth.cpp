#include "formulations/nonsmooth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/movable_rows.hpp"
#include "formulations/automatic/automatic.hpp"
#include "formulations/integrators/tolerance.hpp"
#include "formulations/marched.hpp"
#include "mechanism/scene.hpp"
#include "values/diagnostic.hpp"

namespace freeplay {
namespace {

/// An impact acts up to one step late, with the velocity at the step's beginning. After a flight
/// from rest of N steps the relative error is 1/N.
constexpr double fewest_steps = 30;
/// Greatest κ of the compliant impact law; the number of its steps grows as √κ.
constexpr double stiffest_shear = 1e4;

/// The part that all nonsmooth schemes share: contact models and notes. A Stepper adds singular()
/// and nearest_singular().
template <class Stepper>
class Nonsmooth final : public Marched<Stepper> {
  using Marched<Stepper>::system_, Marched<Stepper>::stepper_;

 public:
  Nonsmooth(const System& system, const State& state, std::vector<double> restitution, Stepper stepper,
            double accepted)
      : Marched<Stepper>(Family::nonsmooth, system, state, std::move(stepper)),
        restitution_(std::move(restitution)),
        accepted_(accepted) {}
  std::vector<ContactModel> contact_models() const override {
    std::vector<ContactModel> models;
    for (int k = 0; k < system_.reported(); ++k)
      models.push_back({*system_.contact_facts(k).surface.slow_restitution(), restitution_[k], 0, 0, 0});
    return models;
  }
  std::vector<std::string> notes() const override {
    std::vector<std::string> notes;
    if (stepper_.singular())
      notes.push_back(diagnostic<Diagnostic::redundant_constraints>());
    else if (stepper_.nearest_singular() < singular_pivot)
      notes.push_back(diagnostic<Diagnostic::singular_position>());
    const auto& w = stepper_.work();
    const auto& e = stepper_.extremes();
    if (w.lcp_retries > 0)
      notes.push_back(diagnostic<Diagnostic::fallback_solver>(w.lcp_retries, w.lcp_solves));
    stepper_.add_notes(notes);
    if (e.ambiguous > 0) notes.push_back(diagnostic<Diagnostic::several_solutions>(e.ambiguous));
    if (e.lcp_residual > accepted_) notes.push_back(diagnostic<Diagnostic::contact_residual>(e.lcp_residual));
    if (e.shortest_flight < fewest_steps)
      notes.push_back(
          diagnostic<Diagnostic::short_flight>(e.shortest_flight, 100 / std::max(1.0, e.shortest_flight)));
    if constexpr (requires { stepper_.unseen(); }) unseen_note(stepper_.unseen(), notes);
    if constexpr (requires { stepper_.passage(); })
      if (const auto& p = stepper_.passage(); p.share > 0.5)
        notes.push_back(diagnostic<Diagnostic::missed_obstacle>(system_.contact_facts(p.contact).name,
                                                                p.share, 0.5 / p.share));
    return notes;
  }

 private:
  std::vector<double> restitution_;
  double accepted_;  // relative residual accepted of a contact problem
};

/// Adaptive time stepping leaves a state that is accurate to its own tolerance. The event-driven
/// scheme then uses a tenth of that tolerance.
double tolerance_after_steps(const NonsmoothOptions& options) {
  return std::max(options.tolerance, 0.1 * options.step_tolerance);
}

}  // namespace

EventDriven make_event_driven(const Scene& scene, const System& system,
                              const std::vector<double>& restitution, RowFacts facts, const State& state) {
  const auto scales = make_scales(scene.mechanism, system, state);
  auto norm = motion_norm(system, scales, scene.nonsmooth.tolerance);
  if (system.states() > 0) add_states(norm, system, 2 * system.n() + 2 * system.contacts());
  auto coarse = norm;
  coarse.tolerance = tolerance_after_steps(scene.nonsmooth);
  EventDynamics dynamics(system, scene.nonsmooth, restitution, facts, scales.speed);
  const double first = 1e-3 * scales.time;
  // Films and beams make every mode stiff from its beginning. Friction bounded by reactions or
  // speeds has no derivative.
  const bool stiff = dynamics.films.any() || system.elastic().pattern.rows > 0;
  const long first_probe = stiff && system.reactive_frictions().empty() ? 100 : 0;
  const auto method = [&](const ErrorNorm& accepted) {
    return EventDriven::Method(Dopri5(accepted, first), accepted, first, first_probe);
  };
  EventDriven scheme(std::move(dynamics), method(norm), method(coarse), scales.time,
                     scene.nonsmooth.tolerance * scales.length);
  if (scales.guessed) scheme.find_pace(scales.length);
  return scheme;
}

AdaptiveMoreau make_adaptive(const Scene& scene, const System& system, const std::vector<double>& restitution,
                             RowFacts facts, const State& state) {
  const auto scales = make_scales(scene.mechanism, system, state);
  return {system, MoreauStepper(system, scene.nonsmooth, 0, restitution, facts),
          motion_norm(system, scales, scene.nonsmooth.step_tolerance), scales,
          [&system, options = scene.nonsmooth, restitution, facts, speed = scales.speed] {
            return std::make_unique<EventDynamics>(system, options, restitution, facts, speed);
          }};
}

AutomaticStepper make_automatic(const Scene& scene, const System& system,
                                const std::vector<double>& restitution, RowFacts facts, const State& state) {
  return {make_event_driven(scene, system, restitution, facts, state),
          make_adaptive(scene, system, restitution, facts, state), tolerance_after_steps(scene.nonsmooth)};
}

std::unique_ptr<Formulation> make_nonsmooth(const Scene& scene, const System& system, const State& state,
                                            const std::vector<double>& restitution) {
  refuse_undetermined_friction(system, state);
  const auto reads = [&](int k) { return system.friction_facts(k).reaction->reads_reactions(); };
  if (std::ranges::any_of(system.reactive_frictions(), reads) && system.contacts() > 0 &&
      scene.nonsmooth.impact_law != ImpactLaw::newton)
    throw ModelError(
        "nonsmooth.impact_law",
        "must be \"newton\" in mechanisms with joint friction from reactions: only this law computes the "
        "reaction impulses that bound it");
  std::vector<double> e = restitution;
  for (int k = static_cast<int>(e.size()); k < system.reported(); ++k) {
    const auto& surface = system.contact_facts(k).surface;
    const auto restitution_of = surface.slow_restitution();
    if (!restitution_of)
      throw ModelError(fmt::format("surfaces.{}.restitution", surface.name),
                       "is missing: the impact law needs it");
    e.push_back(*restitution_of);
  }
  const RowFacts facts{!redundant_rows(system, state.q).empty(), scene.run.eliminate};
  const auto with = [&](auto stepper) -> std::unique_ptr<Formulation> {
    return std::make_unique<Nonsmooth<decltype(stepper)>>(system, state, e, std::move(stepper),
                                                          scene.nonsmooth.lcp_tolerance);
  };
  if (scene.nonsmooth.impact_law != ImpactLaw::newton)
    for (const auto& s : scene.mechanism.surfaces)
      if (s.tangential_restitution > 0)
        throw ModelError(fmt::format("surfaces.{}.tangential_restitution", s.name),
                         "applies only to nonsmooth.impact_law = \"newton\"; remove it");
  if (scene.nonsmooth.impact_law == ImpactLaw::compliant)
    for (const auto& s : scene.mechanism.surfaces)
      if (s.stiffness_ratio.value_or(0) > stiffest_shear)
        throw ModelError(
            fmt::format("surfaces.{}.stiffness_ratio", s.name),
            fmt::format("is above {:g}, which nonsmooth.impact_law = \"compliant\" cannot resolve; "
                        "its limit for rigid contacts is \"energetic\"",
                        stiffest_shear));
  switch (scene.nonsmooth.scheme_in_force()) {
    case Scheme::moreau_jean:
      if (!scene.nonsmooth.step) return with(make_adaptive(scene, system, e, facts, state));
      return with(MoreauStepper(system, scene.nonsmooth, *scene.nonsmooth.step, e, facts));
    case Scheme::event_driven:
      return with(make_event_driven(scene, system, e, facts, state));
    case Scheme::automatic:
      // Time stepping does not support all impact laws.
      if (!choice_of(scene.nonsmooth.impact_law).traits.time_stepping)
        return with(make_event_driven(scene, system, e, facts, state));
      return with(make_automatic(scene, system, e, facts, state));
  }
  throw std::logic_error("no such scheme");
}

}  // namespace freeplay
