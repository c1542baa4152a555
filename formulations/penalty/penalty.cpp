#include "formulations/penalty/penalty.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/movable_rows.hpp"
#include "formulations/contact/film.hpp"
#include "formulations/integrators/adams.hpp"
#include "formulations/integrators/bulirsch_stoer.hpp"
#include "formulations/integrators/rosenbrock.hpp"
#include "formulations/integrators/tolerance.hpp"
#include "formulations/marched.hpp"
#include "formulations/penalty/stepper.hpp"
#include "mechanism/scene.hpp"
#include "values/diagnostic.hpp"

namespace freeplay {
namespace {

/// The law "mindlin" of a contact. `resolution` (m): rounding error of its gap.
ShearSpring make_shear_spring(const ContactFacts& contact, const ContactForce& law, double resolution) {
  const auto& elastic = law.elastic;
  if (!elastic.is_power() || law.viscous > 0)
    throw ModelError(
        "penalty.friction",
        fmt::format("\"mindlin\" needs an elastic force K δⁿ with hysteresis damping at {}; use a "
                    "point law such as penalty.contact = \"exact\"",
                    contact.name));
  return {*contact.surface.friction, stiffness_ratio(contact.surface), elastic.exponent,
          elastic.force(64 * resolution)};
}

/// Throws if the friction law of the options cannot have the static value of a surface.
void require_static_value(const PenaltyOptions& options, const Surface& surface) {
  if (!surface.friction_by_speed()) return;
  const auto& law = facts_of(options.friction);
  const auto path = fmt::format("surfaces.{}.", surface.name);
  if (!law.stribeck) {
    std::string names;
    for (const auto& other : friction_laws())
      if (other.stribeck) names += fmt::format("{}\"{}\"", names.empty() ? "" : " or ", other.text);
    throw ModelError(
        path + "static_friction",
        fmt::format("needs penalty.friction = {}; \"{}\" has no Stribeck speed", names, law.text));
  }
  if (const double n = surface.peak.stribeck_exponent.value_or(2); n != 2)
    throw ModelError(path + "stribeck_exponent",
                     fmt::format("must be 2 with penalty.friction = \"{}\", is {}; other exponents need the "
                                 "nonsmooth formulation",
                                 law.text, n));
  // Regularised below v₀, the friction would not reach its static value.
  if (law.reads("friction_v1") && *surface.peak.stribeck_speed <= options.friction_v0)
    throw ModelError(path + "stribeck_speed",
                     fmt::format("must be greater than penalty.friction_v0 = {}, is {}", options.friction_v0,
                                 *surface.peak.stribeck_speed));
}

std::vector<PenaltyContact> make_contacts(const Scene& scene, const System& system, const State& state) {
  std::vector<PenaltyContact> contacts;
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& facts = system.contact_facts(k);
    PenaltyContact c;
    c.law = make_contact_force(scene, facts);
    const auto& friction = facts.surface.friction;
    require_static_value(scene.penalty, facts.surface);
    if (friction && !facts_of(scene.penalty.friction).compliant)
      c.friction = make_friction(scene.penalty, facts.surface);
    else if (friction && *friction > 0)
      c.shear = make_shear_spring(facts, c.law, gap_rounding(system, k, state.q.data()));
    c.film = make_film(facts);
    contacts.push_back(c);
  }
  for (int k = 0; k < system.frictions(); ++k)
    if (!system.friction_facts(k).regularisation)
      throw ModelError(
          system.friction_facts(k).path("regularisation"),
          "is missing: the penalty formulation needs this velocity, below which friction is linear");
  return contacts;
}

PenaltyDynamics make_dynamics(const Scene& scene, const System& system, const State& state) {
  PenaltyDynamics dynamics(system, scene.penalty, make_contacts(scene, system, state),
                           {!redundant_rows(system, state.q).empty(), scene.run.eliminate});
  if (scene.penalty.integrator == Integrator::rosenbrock4) dynamics.trace_jacobian(state);
  return dynamics;
}

template <class Method>
class Penalty final : public Marched<PenaltyStepper<Method>>, public PenaltySteps {
  using Base = Marched<PenaltyStepper<Method>>;
  using Base::system_, Base::stepper_;

 public:
  Penalty(const Scene& scene, const System& system, const State& state, Method method, double v0_floor,
          double pace)
      : Base(Family::penalty, system, state,
             {make_dynamics(scene, system, state), std::move(method), v0_floor, pace}),
        scene_(scene) {}
  bool step(double end) override { return stepper_.step(end); }
  std::string failure() const override { return stepper_.failure(); }
  double t_old() const override { return stepper_.t_old(); }
  double t() const override { return stepper_.t(); }
  const std::vector<double>& x_old() const override { return stepper_.x_old(); }
  const std::vector<double>& x() const override { return stepper_.x(); }
  const PenaltyDynamics& dynamics() const override { return stepper_.dynamics(); }
  void interpolate(double t, double* q, double* v) const override { stepper_.interpolate(t, q, v); }
  void resume(const std::vector<PenaltyMode>& modes) override { stepper_.resume(modes); }
  std::vector<ContactModel> contact_models() const override {
    std::vector<ContactModel> models;
    for (int k = 0; k < system_.contacts(); ++k) {
      const auto& law = stepper_.dynamics().contacts()[k].law;
      const double requested = system_.contact_facts(k).surface.slow_restitution().value_or(1);
      models.push_back({requested,
                        law.viscous > 0 || law.own() ? std::nan("") : delivered_restitution(law.chi),
                        law.elastic.is_power() ? law.elastic.stiffness : 0, law.elastic.exponent, law.chi});
    }
    return models;
  }
  std::vector<std::string> notes() const override {
    std::vector<std::string> notes;
    law_notes(notes);
    unseen_note(stepper_.unseen(), notes);
    if (stepper_.errors().pulse() > 0.1)
      notes.push_back(diagnostic<Diagnostic::torque_pulse>(stepper_.errors().pulse()));
    // A sine in n steps per period of fourth order has a relative error of its integral of
    // (2π/n)⁴/2880, 1e-4 for n = 8, half the number that curves require.
    if (stepper_.errors().coarse > 2)
      notes.push_back(diagnostic<Diagnostic::step_over_curve>(
          stepper_.errors().coarse, scene_.penalty.step / stepper_.errors().coarse));
    if (scene_.penalty.integrator == Integrator::rk4) {
      const double pull = scene_.penalty.step * std::max(scene_.penalty.alpha, scene_.penalty.beta);
      if (scene_.penalty.stabilisation == Stabilisation::baumgarte && pull > 1)
        notes.push_back(diagnostic<Diagnostic::stiff_stabilisation>(1 / pull, 2.785 / scene_.penalty.step));
      if (stepper_.reliefs() > 0) notes.push_back(diagnostic<Diagnostic::stiff_friction>(stepper_.reliefs()));
      const auto& contact = stepper_.errors().short_contact;
      if (contact.lost > 4e-5 * contact.greatest)
        notes.push_back(diagnostic<Diagnostic::short_contact>(contact.duration / scene_.penalty.step,
                                                              contact.duration / 20));
    } else if (stepper_.reliefs() > 0 && system_.elastic().pattern.rows > 0) {
      notes.push_back(diagnostic<Diagnostic::implicit_steps>(stepper_.reliefs()));
    }
    if (stepper_.dynamics().nearest_singular() < singular_pivot)
      notes.push_back(diagnostic<Diagnostic::singular_position>());
    if (stepper_.dynamics().singular()) notes.push_back(diagnostic<Diagnostic::redundant_constraints>());
    return notes;
  }

 private:
  /// Notes about requests outside the range of a contact law.
  void law_notes(std::vector<std::string>& notes) const {
    if (const auto& own = scene_.penalty.own) {
      notes.push_back(diagnostic<Diagnostic::own_contact_law>(own->name, own->digest));
      return;
    }
    const auto& law = facts_of(scene_.penalty.contact);
    const auto models = contact_models();
    for (int k = 0; k < system_.contacts(); ++k) {
      const auto& facts = system_.contact_facts(k);
      const auto& contact = stepper_.dynamics().contacts()[k];
      if (contact.law.viscous == 0 &&
          std::abs(models[k].restitution_delivered - models[k].restitution_asked) > 0.05)
        notes.push_back(diagnostic<Diagnostic::effective_restitution>(
            facts.name, law.text, models[k].restitution_asked, models[k].restitution_delivered, law.range));
      if (facts.has_clearance &&
          (facts.clearance < law.least_clearance || facts.clearance >= law.clearance_end))
        notes.push_back(diagnostic<Diagnostic::law_clearance_range>(facts.name, law.text,
                                                                    1e3 * facts.clearance, law.range));
      if (facts.surface.tangential_restitution > 0)
        notes.push_back(diagnostic<Diagnostic::tangential_restitution_ignored>(
            facts.name, facts.surface.tangential_restitution));
      const double depth = stepper_.extremes().penetration[k];
      if (depth > 0.5 * contact.law.elastic.limit())
        notes.push_back(
            diagnostic<Diagnostic::law_penetration_range>(facts.name, depth, law.text, law.range));
    }
  }

  const Scene& scene_;
};

/// Whether a drive or load follows a curve, a motor or a governor. A method of high order may take
/// steps through such a motion that are far too long for its work integrals.
bool follows_curves(const Mechanism& m) {
  const auto plain = [](const Drive& d) {
    return std::holds_alternative<SpeedDrive>(d) || std::holds_alternative<TorqueDrive>(d);
  };
  const auto scaled = [](const Load& load) {
    return std::visit(
        [](const auto& l) {
          if constexpr (requires { l.factor; }) return l.factor >= 0;
          return false;
        },
        load);
  };
  return !std::ranges::all_of(m.drives, plain) || std::ranges::any_of(m.loads, scaled);
}

/// kg, mass of the lightest body.
double lightest(const System& system) {
  double least = INFINITY;
  for (int i = 0; i < system.n(); ++i)
    if (!system.is_angle(i)) least = std::min(least, system.mass()[i]);
  return least;
}
/// N, F_el at the greatest depth of an elastic impact of a mass (kg) at a speed (m/s): F_el = K δⁿ.
double impact_force(const ElasticLaw& law, double mass, double speed) {
  const double n = law.exponent;
  return law.force(std::pow((n + 1) * mass * speed * speed / (2 * law.stiffness), 1 / (n + 1)));
}

/// Scales of the integrated vector. Impulses and work integrals have no error control, except the
/// works of drives and loads if they follow curves: their scale is the kinetic energy at the
/// greatest speed, and their own value. (With the speed across a clearance of micrometres, rounding
/// would shorten the steps of free flight to nanoseconds.)
ErrorNorm make_norm(const Scene& scene, const System& system, const Scales& s) {
  const auto& options = scene.penalty;
  ErrorNorm norm = motion_norm(system, s, options.tolerance);
  const int n = system.n();
  // Bristle states exist for all contacts if some contact has them, as in count_bristles().
  const auto& law = facts_of(options.friction);
  bool bristles = false;
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& mu = system.contact_facts(k).surface.friction;
    bristles |= mu && (law.bristle || (law.compliant && *mu > 0));
  }
  if (bristles) {
    // Bristles, after the impulses, which have no error control: deflections of the order 1/σ₀, or
    // the greatest elastic force of an impact of the lightest body.
    norm.absolute.resize(2 * n + 2 * system.contacts(), INFINITY);
    norm.absolute.resize(norm.absolute.size() + system.contacts(), 1 / options.bristle_stiffness);
    for (int k = 0; law.compliant && k < system.contacts(); ++k)
      norm.absolute[2 * n + 2 * system.contacts() + k] =
          impact_force(make_contact_force(scene, system.contact_facts(k)).elastic, lightest(system), s.speed);
    norm.relative.resize(2 * n + 2 * system.contacts(), 0);
    norm.relative.resize(norm.absolute.size(), law.compliant ? 1 : 0);
  }
  const int states = 2 * n + (bristles ? 3 : 2) * system.contacts();
  if (system.states() > 0) add_states(norm, system, states);
  if (follows_curves(scene.mechanism)) {
    double energy = 0;
    for (int i = 0; i < n; ++i)
      energy += 0.5 * system.mass()[i] *
                std::pow(system.is_angle(i) ? s.fastest * s.angular_speed / s.speed : s.fastest, 2);
    norm.absolute.resize(states + system.states(), INFINITY);
    norm.absolute.resize(norm.absolute.size() + 2, energy);
    norm.relative.resize(states + system.states(), 0);
    norm.relative.resize(norm.absolute.size(), 1);
  }
  return norm;
}

Scales scales_of(const Scene& scene, const System& system, const State& state) {
  refuse_undetermined_friction(system, state);
  return make_scales(scene.mechanism, system, state);
}

double floor_of(const Scene& scene, const Scales& scales) {
  return scene.penalty.v0_floor.value_or(1e-3 * scales.speed);
}

/// Wanted: a base of Penalty.
template <class Wanted>
std::unique_ptr<Wanted> make_as(const Scene& scene, const System& system, const State& state,
                                const Scales& scales) {
  const auto& options = scene.penalty;
  const auto with = [&](auto method) -> std::unique_ptr<Wanted> {
    return std::make_unique<Penalty<decltype(method)>>(scene, system, state, std::move(method),
                                                       floor_of(scene, scales), scales.time);
  };
  const auto norm = make_norm(scene, system, scales);
  const double first = 1e-3 * scales.time;
  const auto relieved = [&](auto method) {
    return with(Relieved<decltype(method)>(std::move(method), norm, first));
  };
  switch (options.integrator) {
    case Integrator::rk4:
      return relieved(Rk4(options.step));
    case Integrator::bulirsch_stoer:
      return relieved(BulirschStoer(norm, first));
    case Integrator::adams_bashforth_moulton:
      return relieved(Adams(norm, first));
    case Integrator::rosenbrock4:
      return with(Rosenbrock(norm, first));
    default:
      return relieved(Dopri5(norm, first));
  }
}

}  // namespace

double delivered_by(const Scene& scene, const ContactFacts& contact) {
  if (scene.penalty.own)
    throw ModelError(
        "penalty.contact",
        fmt::format(
            "the effective restitution of {} is unknown, so no impact law can be matched with it; use "
            "--as-given or run the formulations separately",
            scene.penalty.own->name));
  const auto damping = damping_of(scene.penalty);
  if (contact.surface.restitution_by_speed() && damping != ContactLaw::exact)
    throw ModelError(
        fmt::format("surfaces.{}.{}", contact.surface.name,
                    contact.surface.yield_speed ? "yield_speed" : "restitution_table"),
        fmt::format("the effective restitution of \"{}\" differs from the input by an amount that depends on "
                    "the approach speed, so it cannot be matched; use \"exact\", whose effective restitution "
                    "is the input, or compare with --as-given",
                    facts_of(damping).text));
  return delivered_restitution(make_contact_force(scene, contact).chi);
}

Compliances penalty_compliances(const Scene& scene, const System& system) {
  Compliances list;
  for (int k = 0; k < system.contacts(); ++k) {
    const auto law = make_contact_force(scene, system.contact_facts(k)).elastic;
    list.push_back({[law](double depth) { return law.force(depth); },
                    [law](double depth) { return law.slope(depth); },
                    [law](double depth) { return law.energy(depth); }});
  }
  return list;
}

std::unique_ptr<Formulation> make_penalty(const Scene& scene, const System& system, const State& state) {
  return make_as<Formulation>(scene, system, state, scales_of(scene, system, state));
}

PenaltyParts make_penalty_parts(const Scene& scene, const System& system, const State& state,
                                const std::vector<PenaltyMode>& modes) {
  const auto scales = scales_of(scene, system, state);
  auto steps = make_as<PenaltySteps>(scene, system, state, scales);
  steps->resume(modes);
  return {std::move(steps), make_norm(scene, system, scales), floor_of(scene, scales), scales.speed,
          !modes.empty()};
}

std::unique_ptr<PenaltyDynamics> displaced_penalty(const PenaltyDynamics& nominal, const Scene& scene,
                                                   const System& system, const State& state) {
  return nominal.twin_of(system, scene.penalty, make_contacts(scene, system, state));
}

}  // namespace freeplay
