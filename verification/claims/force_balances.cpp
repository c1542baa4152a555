// Newton–Euler equations of every body with the forces of a run: at instants and over intervals, in
// the process and from forces.csv.
#include <algorithm>
#include <cmath>

#include "mechanism/options.hpp"
#include "verification/claims/force_claims.hpp"

namespace freeplay::verification::force_claims {
namespace {

const char* const equations = "Newton–Euler equations, evaluated independently";
const char* const everything_subject = "scene with one of each element";
const char* const solved =
    "rounding of a solution, 1e-16, "
    "times the greatest force of the mechanism over the greatest on the body, up "
    "to 1e5, margin of ten";

struct Bounds {
  double anew;
  const char* why_anew;
  double impulse;
  const char* why_impulse;
};

void report(Findings& f, const std::string& scheme, const BalanceWatch& watch, const Result& result,
            Bounds b) {
  const auto name = [&](const char* quantity) { return claim_name(everything_subject, quantity, scheme); };
  f.at_most(name("balance of forces and moments, greatest residual over greatest term"), "", watch.worst.own,
            1e-10, equations, solved);
  f.at_most(name("balance with moments from F, m and lever arms, greatest residual over greatest term"), "",
            watch.worst.anew, b.anew, equations, b.why_anew);
  f.at_most(name("change of momentum less impulses, over greatest momentum"), "", watch.linear(), b.impulse,
            "m Δv = Δt m g + Σ impulses", b.why_impulse);
  f.at_most(name("change of angular momentum less impulses, over greatest angular momentum"), "",
            watch.angular(), b.impulse, "J Δω = Σ impulses of moments", b.why_impulse);
  double drive = 0, load = 0;
  const auto& m = everything().mechanism;
  for (std::size_t i = 0; i < watch.elements().size(); ++i) {
    const auto& e = watch.elements()[i];
    if (e.kind == ForceElement::Kind::drive) drive += watch.total.elements[i].power;
    for (const auto& l : m.loads) {
      if (const auto* force = std::get_if<ForceLoad>(&l); force && force->name == e.name)
        load += watch.total.elements[i].power;
      if (const auto* torque = std::get_if<TorqueLoad>(&l); torque && torque->name == e.name)
        load += watch.total.elements[i].power;
    }
  }
  const double scale = result.ledger.scale();
  f.at_most(name("integrated power of drives less their work in the energy balance, over its greatest term"),
            "", std::abs(drive - result.ledger.drive) / scale, b.impulse, "∫ power dt", b.why_impulse);
  f.at_most(name("integrated power of force and torque loads less their work, over the greatest energy term"),
            "", std::abs(load - result.ledger.load) / scale, b.impulse, "∫ power dt", b.why_impulse);
}

}  // namespace

void balance(Findings& f) {
  const auto start = start_of_everything();
  using I = Integrator;
  using S = Stabilisation;
  using F = FrictionLaw;
  using C = ContactLaw;
  const Way ways[] = {
      {"rk4, Baumgarte", I::rk4, S::baumgarte, F::ambrosio, C::hertz, 2e-3},
      {"Adams–Bashforth–Moulton, no stabilisation", I::adams_bashforth_moulton, S::none, F::threlfall,
       C::exact, 4e-3},
      {"Bulirsch–Stoer, projection", I::bulirsch_stoer, S::projection, F::brown_mcphee, C::flores, 4e-3},
      {"Bulirsch–Stoer, Baumgarte", I::bulirsch_stoer, S::baumgarte, F::bengisu_akay, C::lankarani_nikravesh,
       4e-3},
      {"dopri5, projection", I::dopri5, S::projection, F::ambrosio, C::exact},
      {"Adams–Bashforth–Moulton, Baumgarte", I::adams_bashforth_moulton, S::baumgarte, F::ambrosio, C::exact},
      {"rosenbrock4, no stabilisation", I::rosenbrock4, S::none, F::lugre, C::hunt_crossley, 6e-4},
  };
  for (const auto& way : ways) {
    auto scene = penalty(way);
    if (way.integrator == I::rk4) {  // values that a fixed step of 1 µs resolves
      scene.mechanism.lubricants[0].viscosity = 4e-4;
      scene.penalty.friction_v0 = 1e-2;
      scene.penalty.friction_v1 = 1e-1;
    }
    BalanceWatch watch(scene.mechanism, false, way.duration / 100, 7);
    const auto result = run(scene, Family::penalty, {&watch}, start);
    report(f, std::string("penalty, ") + way.name, watch, result, {1e-9, drift, 1e-6, hertz});
  }
  {
    const auto scene = nonsmooth(Scheme::event_driven);
    BalanceWatch watch(scene.mechanism, false, 1e-4);
    const auto result = run(scene, Family::nonsmooth, {&watch}, start);
    report(f, "event-driven", watch, result, {1e-9, drift, 1e-8, "tolerance 1e-10 per step, 165 steps"});
  }
  {
    const auto scene = nonsmooth(Scheme::moreau_jean);
    BalanceWatch watch(scene.mechanism, true, 1e-4);
    const auto result = run(scene, Family::nonsmooth, {&watch}, start);
    report(
        f, "Moreau–Jean, h = 1e-5 s", watch, result,
        {2e-8,
         "the points of a joint are (ω h)²/2 of their lever arm apart at the middle of a step, ω = 20 rad/s",
         1e-12, "rounding: a step is defined by its impulses"});
  }
}

/// The error of the interval means decreases with the tolerance as that of the method.
void tolerances(Findings& f) {
  const auto start = start_of_everything();
  for (const bool events : {false, true}) {
    std::vector<double> tolerance, linear;
    for (const double requested : {1e-6, 1e-8, 1e-10}) {
      auto scene = events ? nonsmooth(Scheme::event_driven)
                          : penalty({"", Integrator::dopri5, Stabilisation::projection, FrictionLaw::ambrosio,
                                     ContactLaw::exact, 4e-3});
      scene.penalty.tolerance = scene.nonsmooth.tolerance = requested;
      BalanceWatch watch(scene.mechanism, false, 4e-5, 1 << 30);
      run(scene, events ? Family::nonsmooth : Family::penalty, {&watch}, start);
      tolerance.push_back(requested);
      linear.push_back(watch.linear());
    }
    f.between(
        claim_name(everything_subject, "exponent of the tolerance in the change of momentum less impulses",
                   events ? "event-driven" : "penalty, dopri5, projection"),
        "", test::observed_order(tolerance, linear), 0.5, 1.3,
        "1, of the dense output; (3/2 + 1)/5 at the onset of Hertz's force",
        "steps are shortened at events and output rows");
  }
}

namespace {

std::vector<double> row_of(const test::Columns& table, std::size_t row, const Layout& layout,
                           std::initializer_list<const char*> names) {
  std::vector<double> out;
  for (const auto& body : layout.bodies)
    for (const char* name : names) out.push_back(table.at(row, body + "." + name));
  return out;
}

/// Claims on the columns of forces.csv and trajectory.csv, with the data of the scene alone.
void columns(Findings& f, const char* subject, const char* scheme, const Scene& scene, Family family,
             const State& start, bool whole, double instant, const char* why_instant, double mean,
             const char* why_mean) {
  const auto out = files(scene, family, start);
  const ForceBalance balance(scene.mechanism, out.layout);
  const auto& list = out.layout.forces;
  double worst = 0, left = 0;
  std::vector<ContactPlace> gaps(out.layout.contacts.size());
  std::vector<double> momentum(out.layout.bodies.size()), missing(out.layout.bodies.size());
  for (std::size_t i = 0; i < out.forces.rows(); ++i) {
    auto q = row_of(out.trajectory, i, out.layout, {"x", "y", "theta"});
    const auto v = row_of(out.trajectory, i, out.layout, {"vx", "vy", "omega"});
    for (std::size_t k = 0; k < gaps.size(); ++k)
      gaps[k].gap = out.trajectory.at(i, out.layout.contacts[k] + ".gap");
    if (!whole)
      worst = greatest(
          worst, balance.residual_anew(q, elements_of(out.forces, i, list),
                                       row_of(out.forces, i, out.layout, {"ax", "ay", "alpha"}), gaps, {}));
    if (i + 1 == out.forces.rows()) break;
    const double h = out.forces.at(i + 1, "t") - out.forces.at(i, "t");
    auto impulses = elements_of(out.forces, i + 1, list, "_mean");
    for (auto& e : impulses) e.fx *= h, e.fy *= h, e.m *= h;
    auto change = row_of(out.trajectory, i + 1, out.layout, {"vx", "vy", "omega"});
    for (std::size_t c = 0; c < v.size(); ++c) change[c] -= v[c];
    if (whole) {
      for (std::size_t c = 0; c < v.size(); ++c) q[c] += 0.5 * h * v[c];
      worst = greatest(worst, balance.residual_anew(q, impulses, change, gaps, {h, v}));
    }
    Forces sums{impulses, {}};
    const auto rest = balance.momentum_left(sums, change, h);
    for (std::size_t b = 0; b < momentum.size(); ++b) {
      missing[b] = greatest(missing[b], std::hypot(rest[3 * b], rest[3 * b + 1]));
      momentum[b] =
          std::max(momentum[b], scene.mechanism.bodies[b].mass * std::hypot(v[3 * b], v[3 * b + 1]));
    }
  }
  for (std::size_t b = 0; b < momentum.size(); ++b)
    if (missing[b] > 0) left = greatest(left, missing[b] / momentum[b]);
  f.at_most(
      claim_name(subject,
                 whole ? "balance of mean F, m of each step with Δv, Δω, greatest residual over greatest term"
                       : "balance of F, m with a, α, greatest residual over greatest term",
                 scheme),
      "", worst, instant, "Newton–Euler equations from the columns", why_instant);
  f.at_most(
      claim_name(subject, "change of momentum less integrated mean forces, over greatest momentum", scheme),
      "", left, mean, "m Δv = Δt (m g + Σ means)", why_mean);
}

}  // namespace

void csv(Findings& f) {
  const auto start = start_of_everything();
  const char* const subject = "forces.csv, one of each element";
  auto scene = penalty(
      {"", Integrator::dopri5, Stabilisation::projection, FrictionLaw::ambrosio, ContactLaw::exact, 4e-3});
  scene.run.output_step = 2e-5;
  columns(f, subject, "penalty", scene, Family::penalty, start, false, 1e-9, drift, 1e-6, hertz);
  scene = nonsmooth(Scheme::event_driven);
  scene.run.output_step = 4e-5;
  columns(f, subject, "event-driven", scene, Family::nonsmooth, start, false, 1e-9, drift, 1e-8,
          "tolerance 1e-10 per step, 165 steps");
  scene = nonsmooth(Scheme::moreau_jean);
  for (auto& surface : scene.mechanism.surfaces)
    surface.friction.reset();  // the moment of friction depends on the gap within the step
  scene.run.output_step = *scene.nonsmooth.step;
  scene.run.duration = 6e-3;
  columns(f, "forces.csv, one of each element, no friction", "Moreau–Jean, h = 1e-5 s", scene,
          Family::nonsmooth, start, true, 2e-8,
          "the points of a joint are (ω h)²/2 of their lever arm apart at the middle of a step, ω = 20 rad/s",
          1e-12, "rounding: a step is defined by its impulses");
}

}  // namespace freeplay::verification::force_claims
