// Forces that come out: they balance, they are those of closed forms, and their time integrals are impulses
// and work.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "freeplay.hpp"
#include "io/csv.hpp"
#include "verification/claims/claim.hpp"
#include "verification/claims/force_balance.hpp"
#include "verification/references/bearing_load.hpp"
#include "verification/references/impulses.hpp"
#include "verification/references/slider_crank_forces.hpp"
#include "verification/support.hpp"

namespace freeplay::verification {
namespace {

using Point = reference::Planar<double>;

Result run(const Scene& scene, Family family, std::vector<Observer*> observers,
           const std::optional<State>& start = {}) {
  Simulation simulation(scene, test::name_of(family), {.start = start});
  auto result = simulation.run({.observers = std::move(observers)});
  if (result.ending.status != Ending::Status::finished)
    throw std::runtime_error(fmt::format("{}: {}", result.formulation, result.ending.reason));
  return result;
}

Scene everything() { return read_scene(test::scene_file("forces")); }

/// The nonsmooth formulation has no film.
Scene without_film(Scene scene) {
  for (auto& joint : scene.mechanism.joints)
    if (auto* pin = std::get_if<RevoluteJoint>(&joint); pin && pin->clearance) pin->clearance->lubricant = -1;
  return scene;
}

Scene nonsmooth(Scheme scheme) {
  auto scene = without_film(everything());
  scene.nonsmooth.scheme = scheme;
  scene.nonsmooth.step = 1e-5;
  return scene;
}

// Newton and Euler, at instants and over intervals.

const char* const equations = "Newton and Euler, summed anew";
const char* const solved =
    "rounding of a solve, 1e-16, times the greatest force of the mechanism over the greatest on the body, up "
    "to "
    "1e5, and room of ten";
const char* const drift = "points of an ideal joint lie its drift apart: 1e-11 m over arms of 1 cm";
const char* const hertz =
    "Hertz's force begins with the power 3/2, on which three points err by 1e-4 of a step that carries 1e-3 "
    "of the "
    "impact at most, and room of ten";

struct Bounds {
  double anew;
  const char* why_anew;
  double impulse;
  const char* why_impulse;
};

void report(Findings& f, const std::string& way, const BalanceWatch& watch, const Result& result, Bounds b) {
  f.at_most("Newton and Euler, greatest residual over greatest term: " + way, "", watch.worst.own, 1e-10,
            equations, solved);
  f.at_most("the same, moments from F and m on the second body by arms of the scene", "", watch.worst.anew,
            b.anew, equations, b.why_anew);
  f.at_most("momentum between rows less impulses, over its greatest", "", watch.linear(), b.impulse,
            "m Δv = Δt m g + Σ impulses", b.why_impulse);
  f.at_most("angular momentum, likewise", "", watch.angular(), b.impulse, "J Δω = Σ impulses of moments",
            b.why_impulse);
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
  f.at_most("power of the drives over the run less the ledger's work, over its greatest term", "",
            std::abs(drive - result.ledger.drive) / scale, b.impulse, "∫ power dt", b.why_impulse);
  f.at_most("power of force and torque loads, likewise", "", std::abs(load - result.ledger.load) / scale,
            b.impulse, "∫ power dt", b.why_impulse);
}

struct Way {
  const char* name;
  Integrator integrator;
  Stabilisation stabilisation;
  FrictionLaw friction;
  ContactLaw contact;
  double duration = 0.012;  // s
};
Scene penalty(const Way& way) {
  auto scene = everything();
  scene.penalty.integrator = way.integrator;
  scene.penalty.stabilisation = way.stabilisation;
  scene.penalty.friction = way.friction;
  scene.penalty.contact = way.contact;
  scene.penalty.step = 1e-6;
  scene.run.duration = way.duration;
  return scene;
}

void balance(Findings& f, const State& start) {
  using I = Integrator;
  using S = Stabilisation;
  using F = FrictionLaw;
  using C = ContactLaw;
  const Way ways[] = {
      {"rk4, Baumgarte", I::rk4, S::baumgarte, F::ambrosio, C::hertz, 2e-3},
      {"adams_bashforth_moulton, none", I::adams_bashforth_moulton, S::none, F::threlfall, C::exact, 4e-3},
      {"fehlberg78, projection", I::fehlberg78, S::projection, F::brown_mcphee, C::flores, 4e-3},
      {"bulirsch_stoer, Baumgarte", I::bulirsch_stoer, S::baumgarte, F::bengisu_akay, C::lankarani_nikravesh,
       4e-3},
      {"dopri5, projection", I::dopri5, S::projection, F::ambrosio, C::exact},
      {"adams_bashforth_moulton, Baumgarte", I::adams_bashforth_moulton, S::baumgarte, F::ambrosio, C::exact},
      {"rosenbrock4, none", I::rosenbrock4, S::none, F::lugre, C::hunt_crossley, 6e-4},
  };
  for (const auto& way : ways) {
    auto scene = penalty(way);
    if (way.integrator == I::rk4) {  // what a fixed step of 1 µs resolves
      scene.mechanism.lubricants[0].viscosity = 4e-4;
      scene.penalty.friction_v0 = 1e-2;
      scene.penalty.friction_v1 = 1e-1;
    }
    BalanceWatch watch(scene.mechanism, false, way.duration / 100, 7);
    const auto result = run(scene, Family::penalty, {&watch}, start);
    Bounds bounds{1e-9, drift, 1e-6, hertz};
    if (way.integrator == I::fehlberg78)
      bounds = {1e-9, drift, 1e-3,
                "its steps take up to a third of an impact, where the cubic between their ends errs by "
                "(π/3)⁴/384 of the "
                "depth, 3e-3, and a third of that in the mean"};
    report(f, std::string("penalty, ") + way.name, watch, result, bounds);
  }
  {
    const auto scene = nonsmooth(Scheme::event_driven);
    BalanceWatch watch(scene.mechanism, false, 1e-4);
    const auto result = run(scene, Family::nonsmooth, {&watch}, start);
    report(f, "event-driven", watch, result, {1e-9, drift, 1e-8, "tolerance 1e-10 a step, 165 steps"});
  }
  {
    const auto scene = nonsmooth(Scheme::moreau_jean);
    BalanceWatch watch(scene.mechanism, true, 1e-4);
    const auto result = run(scene, Family::nonsmooth, {&watch}, start);
    report(f, "Moreau–Jean, each step", watch, result,
           {2e-8, "points of a joint lie (ω h)²/2 of their arm apart at the middle of a step, ω = 20 rad/s",
            1e-12, "a step is its impulses: rounding"});
  }
}

/// The interval means' error is the method's own.
void tolerances(Findings& f, const State& start) {
  for (const bool events : {false, true}) {
    std::vector<double> tolerance, linear;
    for (const double asked : {1e-6, 1e-8, 1e-10}) {
      auto scene = events ? nonsmooth(Scheme::event_driven)
                          : penalty({"", Integrator::dopri5, Stabilisation::projection, FrictionLaw::ambrosio,
                                     ContactLaw::exact, 4e-3});
      scene.penalty.tolerance = scene.nonsmooth.tolerance = asked;
      BalanceWatch watch(scene.mechanism, false, 4e-5, 1 << 30);
      run(scene, events ? Family::nonsmooth : Family::penalty, {&watch}, start);
      tolerance.push_back(asked);
      linear.push_back(watch.linear());
    }
    f.between(std::string("exponent of the tolerance, momentum less impulses: ") +
                  (events ? "event-driven" : "penalty, dopri5, projection"),
              "", test::observed_order(tolerance, linear), 0.5, 1.3,
              "1: the dense output's error; (3/2 + 1)/5 where Hertz's force begins",
              "steps are cut at events and rows");
  }
}

// forces.csv.

struct Files {
  Table trajectory, forces;
  Result result;
  Layout layout;
};
Files files(const Scene& scene, Family family, const std::optional<State>& start = {}) {
  test::TemporaryFolder folder;
  TrajectoryCsv trajectory(folder.path() / "trajectory.csv");
  ForcesCsv forces(folder.path() / "forces.csv");
  Simulation simulation(scene, test::name_of(family), {.start = start});
  auto result = simulation.run({.observers = {&trajectory, &forces}});
  if (result.ending.status != Ending::Status::finished) throw std::runtime_error(result.ending.reason);
  trajectory.commit();
  forces.commit();
  return {Table(folder.path() / "trajectory.csv"), Table(folder.path() / "forces.csv"), std::move(result),
          simulation.layout()};
}

std::vector<double> row_of(const Table& table, std::size_t row, const Layout& layout,
                           std::initializer_list<const char*> names) {
  std::vector<double> out;
  for (const auto& body : layout.bodies)
    for (const char* name : names) out.push_back(table.at(row, body + "." + name));
  return out;
}

/// What the columns say alone, with the scene's facts and the rows of trajectory.csv.
void columns(Findings& f, const std::string& way, const Scene& scene, Family family, const State& start,
             bool whole, double instant, const char* why_instant, double mean, const char* why_mean) {
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
  f.at_most("forces.csv, " + way +
                (whole ? ": F, m means of each step against Δv, ω by trajectory.csv" : ": F, m against a, α"),
            "", worst, instant, "Newton and Euler from the columns alone", why_instant);
  f.at_most("its means against the change of momentum of trajectory.csv, over the greatest", "", left, mean,
            "m Δv = Δt (m g + Σ means)", why_mean);
}

void csv(Findings& f, const State& start) {
  auto scene = penalty(
      {"", Integrator::dopri5, Stabilisation::projection, FrictionLaw::ambrosio, ContactLaw::exact, 4e-3});
  scene.run.output_step = 2e-5;
  columns(f, "penalty", scene, Family::penalty, start, false, 1e-9, drift, 1e-6, hertz);
  scene = nonsmooth(Scheme::event_driven);
  scene.run.output_step = 4e-5;
  columns(f, "event-driven", scene, Family::nonsmooth, start, false, 1e-9, drift, 1e-8,
          "tolerance 1e-10 a step, 165 steps");
  scene = nonsmooth(Scheme::moreau_jean);
  for (auto& surface : scene.mechanism.surfaces)
    surface.friction.reset();  // its moment needs the gap in the step
  scene.run.output_step = scene.nonsmooth.step;
  scene.run.duration = 6e-3;
  columns(f, "Moreau–Jean, without friction", scene, Family::nonsmooth, start, true, 2e-8,
          "points of a joint lie (ω h)²/2 of their arm apart at the middle of a step, ω = 20 rad/s", 1e-12,
          "a step is its impulses: rounding");
}

// Closed forms.

Scene slider_crank(const reference::LoadedSliderCrank<double>& s) {
  Scene scene;
  auto& m = scene.mechanism;
  const Vec2 c{s.slider_centre.x, s.slider_centre.y};
  m.gravity = {s.gravity.x, s.gravity.y};
  const double a = s.crank_centre, b = s.rod_centre, x = s.crank_length + s.rod_length;
  m.bodies.push_back({"crank", s.crank_mass, s.crank_inertia, {a, 0}, 0, {0, 0}, s.speed});
  m.bodies.push_back({"rod", s.rod_mass, s.rod_inertia, {s.crank_length + b, 0}, 0, {0, 0}, 0});
  m.bodies.push_back({"slider", s.slider_mass, 1e-3, Vec2{x, 0} + c, 0, {0, 0}, 0});
  m.joints.push_back(RevoluteJoint{"main", {ground, 0}, {Vec2{0, 0}, Vec2{-a, 0}}, {}});
  m.joints.push_back(RevoluteJoint{"big_end", {0, 1}, {Vec2{s.crank_length - a, 0}, Vec2{-b, 0}}, {}});
  m.joints.push_back(RevoluteJoint{"gudgeon", {1, 2}, {Vec2{s.rod_length - b, 0}, -c}, {}});
  m.joints.push_back(TranslationalJoint{"guide", {ground, 2}, {Vec2{0, 0}, -c}, {1, 0}, 0, {}});
  m.drives.push_back(SpeedDrive{"motor", 0, s.speed, 0});
  m.loads.push_back(ForceLoad{"push", 2, {0, 0}, {s.load.x, s.load.y}});
  scene.run.duration = 2 * std::numbers::pi / std::abs(s.speed);
  scene.run.start = RunOptions::Start::ideal;
  scene.penalty.integrator = Integrator::dopri5;
  scene.penalty.stabilisation = Stabilisation::projection;
  scene.penalty.tolerance = 1e-10;
  return scene;
}

reference::LoadedSliderCrank<double> rig() {
  reference::LoadedSliderCrank<double> s;
  s.crank_length = 0.05;
  s.rod_length = 0.3;
  s.crank_mass = 17.9;
  s.crank_inertia = 0.460327;
  s.rod_mass = 1.13;
  s.rod_centre = 0.15;
  s.rod_inertia = 0.0153;
  s.slider_mass = 1.013;
  s.speed = reference::from_rpm(200.0);
  return s;
}

reference::LoadedSliderCrank<double> loaded() {
  auto s = rig();
  s.crank_centre = 0.02;
  s.rod_centre = 0.11;
  s.slider_centre = {0.03, -0.012};
  s.gravity = {0, -9.81};
  s.load = {-60, 25};
  return s;
}

std::size_t find(const Layout& layout, const std::string& name) {
  for (std::size_t i = 0; i < layout.forces.size(); ++i)
    if (layout.forces[i].name == name) return i;
  throw std::runtime_error("no force element " + name);
}

/// Greatest error of forces (over the greatest force) and of moments (over the greatest torque) during a
/// turn.
std::array<double, 2> off_reference(const reference::LoadedSliderCrank<double>& s, const Scene& scene,
                                    Family family) {
  double force = 0, moment = 0, force_off = 0, moment_off = 0;
  Simulation simulation(scene, test::name_of(family));
  const auto& layout = simulation.layout();
  const auto main = find(layout, "main"), big_end = find(layout, "big_end"),
             gudgeon = find(layout, "gudgeon"), guide = find(layout, "guide"), motor = find(layout, "motor");
  Forces now{std::vector<ElementForce>(layout.forces.size()), std::vector<double>(9)};
  test::Listener listener;
  listener.want.forces = true;
  const bool stepping = family == Family::nonsmooth && scene.nonsmooth.scheme == Scheme::moreau_jean;
  listener.on_step = [&](const Step& step) {
    // A time step's velocities are h² off the constraints' own, alike from step to step: where they begin,
    // and in a shorter last step, that is an error of h in the force.
    if (stepping && (step.t0 == 0 || step.t1 >= scene.run.duration)) return;
    for (const double share : {0.5, 1.0}) {
      if (stepping && share != 0.5) continue;
      const double t = share < 1 ? step.t0 + share * (step.t1 - step.t0) : step.t1;
      step.forces(t, now);
      const auto exact = reference::slider_crank_forces(s, s.speed * t);
      const auto compare = [&](std::size_t element, const Point& expected) {
        const auto& e = now.elements[element];
        force = std::max(force, std::hypot(expected.x, expected.y));
        force_off = greatest(force_off, std::hypot(e.fx - expected.x, e.fy - expected.y));
      };
      compare(main, exact.ground_on_crank);
      compare(big_end, exact.crank_on_rod);
      compare(gudgeon, exact.rod_on_slider);
      compare(guide, exact.guide.force);
      moment = std::max({moment, std::abs(exact.torque), std::abs(exact.guide.moment)});
      for (const auto& [element, expected] : {std::pair{motor, exact.torque},
                                              {guide, exact.guide.moment},
                                              {main, 0.0},
                                              {big_end, 0.0},
                                              {gudgeon, 0.0}})
        moment_off = greatest(moment_off, std::abs(now.elements[element].m - expected));
    }
  };
  const auto result = simulation.run({.observers = {&listener}});
  if (result.ending.status != Ending::Status::finished) throw std::runtime_error(result.ending.reason);
  return {force_off / force, moment_off / moment};
}

void slider_cranks(Findings& f) {
  const char* const source = "references/slider_crank_forces";
  for (const auto& [name, s] :
       {std::pair{"the ideal rig", rig()},
        {"with weight, an eccentric crank, an offset slider and a load on it", loaded()}}) {
    auto scene = slider_crank(s);
    const auto claim = [&](const std::string& way, const std::array<double, 2>& off, double bound,
                           const char* why) {
      f.at_most(fmt::format("slider-crank, {}, {}: reactions, greatest error over greatest force", name, way),
                "", off[0], bound, source, why);
      f.at_most("its torque and moments, likewise", "", off[1], bound, source, why);
    };
    claim("penalty", off_reference(s, scene, Family::penalty), 1e-8,
          "tolerance 1e-10 in a step, room of a hundred");
    scene.nonsmooth.scheme = Scheme::event_driven;
    claim("event-driven", off_reference(s, scene, Family::nonsmooth), 1e-8,
          "tolerance 1e-10 in a step, room of a hundred");
    scene.nonsmooth.scheme = Scheme::moreau_jean;
    std::vector<double> steps, errors;
    std::array<double, 2> last{};
    for (const double h : {4e-5, 2e-5, 1e-5}) {
      scene.nonsmooth.step = h;
      last = off_reference(s, scene, Family::nonsmooth);
      steps.push_back(h);
      errors.push_back(last[0]);
    }
    claim("Moreau–Jean at 1e-5 s", last, 1e-6, "(ω h)² = 4e-8, and room of twenty");
    f.between("the order of its reactions in h", "", test::observed_order(steps, errors), 1.9, 2.1,
              "2: θ = ½", "the next order at h = 4e-5 s");
  }
  // Means of the two formulations.
  auto scene = slider_crank(rig());
  scene.run.output_step = 1e-3;
  scene.nonsmooth.step = 1e-5;
  const auto penalty = files(scene, Family::penalty), steps = files(scene, Family::nonsmooth);
  double apart = 0, most = 0;
  for (std::size_t i = 1; i < penalty.forces.rows(); ++i) {
    const double x = penalty.forces.at(i, "gudgeon.fx_mean"), y = penalty.forces.at(i, "gudgeon.fy_mean");
    most = std::max(most, std::hypot(x, y));
    apart = greatest(apart, std::hypot(x - steps.forces.at(i, "gudgeon.fx_mean"),
                                       y - steps.forces.at(i, "gudgeon.fy_mean")));
  }
  f.at_most("the ideal rig's gudgeon: means over 1 ms, penalty less Moreau–Jean, over the greatest", "",
            apart / most, 1e-6, "equality", "(ω h)² = 4e-8, and room of twenty");
}

/// A rotor under a torque, with a body welded on; a slider that its weight and a load move.
void bearings(Findings& f) {
  Scene scene;
  auto& m = scene.mechanism;
  m.gravity = {0.7, -9.81};
  const reference::Rotor<double> rotor{2.0, 0.03, 0.02};
  const reference::WeldedBody<double> tool{0.4, 1e-3, {0.1, 0.04}, {0.02, -0.03}};
  const reference::GuidedBody<double> slider{0.8, 0.4, {0.02, 0.01}, {3, -2}, {-0.03, 0.02}};
  m.bodies.push_back({"rotor", rotor.mass, rotor.inertia, {0.03, 0}, 0, {0, 0}, 5});
  m.bodies.push_back({"tool", tool.mass, tool.inertia, {0.12, 0.01}, 0.3, {0, 0}, 5});
  m.bodies.push_back({"slider", slider.mass, 1e-3, {1.02, 0.01}, 0, {0, 0}, 0});
  m.joints.push_back(RevoluteJoint{"bearing", {ground, 0}, {Vec2{0, 0}, Vec2{-0.03, 0}}, {}});
  const Vec2 d{std::cos(0.3) * 0.02 + std::sin(0.3) * -0.03, -std::sin(0.3) * 0.02 + std::cos(0.3) * -0.03};
  m.joints.push_back(RigidJoint{"weld", {0, 1}, {Vec2{0.07, 0.04}, -d}, 0.3});
  m.joints.push_back(TranslationalJoint{
      "guide", {ground, 2}, {Vec2{1, 0}, Vec2{-0.02, -0.01}}, {std::cos(0.4), std::sin(0.4)}, 0, {}});
  m.drives.push_back(TorqueDrive{"motor", 0, TorqueDrive::Against::time, {{0.0, 1.5}}});
  m.loads.push_back(ForceLoad{"pull", 2, {-0.05, 0.01}, {3, -2}});
  scene.run.duration = 0.2;
  scene.penalty.integrator = Integrator::dopri5;
  scene.penalty.stabilisation = Stabilisation::projection;
  scene.nonsmooth.scheme = Scheme::event_driven;
  scene.nonsmooth.tolerance = scene.penalty.tolerance = 1e-10;
  const Point g{0.7, -9.81};
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    Simulation simulation(scene, test::name_of(family));
    Forces now{std::vector<ElementForce>(simulation.layout().forces.size()), std::vector<double>(9)};
    double off[3] = {0, 0, 0};
    std::vector<double> q(9), v(9);
    test::Listener listener;
    listener.want.forces = true;
    listener.on_step = [&](const Step& step) {
      step.state(step.t1, q, v);
      step.forces(step.t1, now);
      const reference::Turning<double> at{q[2], v[2], now.acceleration[2]};
      const auto own = reference::rotor_load(rotor, at, g);
      const auto weld = reference::weld_load(tool, at, g);
      const auto sliding = reference::guide_load(slider, reference::guided_acceleration(slider, g), g);
      const auto e = reference::direction(q[2]);
      const Point joint = tool.joint.x * e + tool.joint.y * reference::quarter_turn(e);
      const auto& f_bearing = now.elements[0];
      const auto& f_weld = now.elements[1];
      const auto& f_guide = now.elements[2];
      const auto& motor = now.elements[3];
      const auto apart = [](const ElementForce& f, const Point& force, double moment) {
        return std::max({std::abs(f.fx - force.x), std::abs(f.fy - force.y), std::abs(f.m - moment)});
      };
      off[0] = greatest(off[0], apart(f_bearing, own.reaction + weld.force, 0));
      off[0] = greatest(off[0], std::abs(motor.m - own.torque - weld.moment - cross(joint, weld.force)));
      off[1] = greatest(off[1], apart(f_weld, weld.force, weld.moment));
      off[2] = greatest(off[2], apart(f_guide, sliding.joint.force, sliding.joint.moment));
    };
    simulation.run({.observers = {&listener}});
    const char* what[] = {"rotor under a torque with a body welded on: bearing and torque", "its weld",
                          "slider on an inclined guide with a load"};
    for (int i = 0; i < 3; ++i)
      f.at_most(fmt::format("{}, {}", what[i], family == Family::penalty ? "penalty" : "event-driven"),
                "N, N m", off[i], 1e-11, "references/bearing_load at the state and its α",
                "rounding of some 50 N");
  }
}

// Instruments.

Scene journal() {
  Scene scene;
  auto& m = scene.mechanism;
  m.gravity = {0, -9.81};
  Surface surface;
  surface.name = "steel";
  surface.young = 207e9;
  surface.poisson = 0.3;
  surface.restitution = 0.5;
  m.surfaces.push_back(surface);
  m.bodies.push_back({"journal", 0.3, 1e-4, {0, 0}, 0, {0, 0}, 0});
  RevoluteJoint joint{"bearing", {ground, 0}, {Vec2{0, 0}, Vec2{0, 0}}, {}};
  joint.clearance = Clearance{1e-2, 5e-2, 0, std::nullopt, -1};
  m.joints.push_back(joint);
  Instrument cell;
  cell.kind = Instrument::Kind::load_cell;
  cell.name = "cell";
  cell.joint = 0;
  cell.axis = {0, 1};
  cell.bandwidth = 1000;
  cell.sampling = 1e5;
  scene.instruments.push_back(cell);
  scene.run.duration = 0.053;
  scene.run.start = RunOptions::Start::given;
  scene.penalty.contact = ContactLaw::exact;
  scene.nonsmooth.step = 1e-5;
  return scene;
}

void load_cell(Findings& f) {
  const double h = 1e-2, g = 9.81, mass = 0.3, bandwidth = 1000, sampling = 1e5;
  const double P = reference::drop_impulse(mass, h, 0.5, g);
  const double w = 2 * std::numbers::pi * bandwidth;
  const char* const source = "references/impulses, m (1 + e) √(2 g h)";
  const struct {
    const char* name;
    Family family;
    Scheme scheme;
    double impulse;
    const char* why;
  } ways[] = {{"event-driven", Family::nonsmooth, Scheme::event_driven, 1e-9, "tolerance 1e-10"},
              {"Moreau–Jean at 1e-5 s", Family::nonsmooth, Scheme::moreau_jean, 4e-4,
               "the touch falls in a step: g h over 0.44 m/s, with e twice"},
              {"penalty", Family::penalty, Scheme::moreau_jean, 1e-6, hertz}};
  for (const auto& way : ways) {
    auto scene = journal();
    scene.nonsmooth.scheme = way.scheme;
    BalanceWatch watch(scene.mechanism, false, 1e-3, 1 << 30);
    std::vector<double> samples;
    test::Listener listener;
    listener.want.samples = true;
    listener.on_sample = [&](std::size_t, double, double value) { samples.push_back(value); };
    const auto result = run(scene, way.family, {&watch, &listener});
    const auto hit = test::touch(result, 0);
    double expected = P;
    if (way.family == Family::penalty)
      expected = reference::drop_impulse(mass, h, hit.v_n_plus / -hit.v_n_minus, g) + mass * g * hit.duration;
    f.relative(
        fmt::format("a journal that falls 1 cm on its bearing, {}: time integral of its force", way.name),
        "N s", watch.total.elements[0].fy, expected, way.impulse,
        way.family == Family::penalty ? "the same with the e of its own speeds, and m g T" : source, way.why);
    f.relative("the impulse of its event", "N s", hit.impulse_n, watch.total.elements[0].fy,
               way.family == Family::penalty ? 1e-6 : 1e-12, "that integral",
               way.family == Family::penalty ? hertz : "the same number: rounding");
    double sum = 0;
    for (const double y : samples) sum += y / sampling;
    f.relative("the sum of its load cell's samples times their period", "N s", sum, expected,
               4e-4 + way.impulse, "∫ y dt = P for unit gain at rest",
               "(ω Δt)²/12 of a kink at the touch, and the impulse's own bound");
    if (way.family != Family::nonsmooth) continue;
    double off = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double t = static_cast<double>(i + 1) / sampling;
      double y = reference::low_pass2_response(bandwidth, hit.impulse_n, t - hit.t);
      if (way.scheme == Scheme::moreau_jean) {
        // Its impulse is spread over its step.
        const double step = scene.nonsmooth.step, from = std::floor(hit.t / step) * step;
        y = (reference::low_pass2_integral(bandwidth, hit.impulse_n, t - from) -
             reference::low_pass2_integral(bandwidth, hit.impulse_n, t - from - step)) /
            step;
      }
      off = greatest(off, std::abs(samples[i] - y));
    }
    f.at_most("its samples less the filter's response to that impulse, over ω P", "", off / (w * P), 1e-9,
              "references/impulses, low_pass2_response", "exact modes: rounding of 5,000 steps of them");
  }
}

void torque_sensor(Findings& f) {
  Scene scene;
  auto& m = scene.mechanism;
  m.bodies.push_back({"rotor", 1.0, 0.01, {0, 0}, 0, {0, 0}, 10});
  m.joints.push_back(RevoluteJoint{"bearing", {ground, 0}, {Vec2{0, 0}, Vec2{0, 0}}, {}});
  m.drives.push_back(SpeedDrive{"motor", 0, 10, 0});
  m.loads.push_back(TorqueLoad{"brake", 0, -0.7});
  Instrument sensor;
  sensor.kind = Instrument::Kind::torque;
  sensor.name = "sensor";
  sensor.drive = "motor";
  sensor.bandwidth = 500;
  sensor.sampling = 5e3;
  scene.instruments.push_back(sensor);
  scene.run.duration = 0.02;
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    double last = NAN;
    test::Listener listener;
    listener.on_sample = [&](std::size_t, double, double value) { last = value; };
    run(scene, family, {&listener});
    f.relative(
        std::string("a torque sensor's steady value on a rotor under a brake, ") + test::name_of(family),
        "N m", last, 0.7, 1e-9, "the brake's 0.7 N m", "rounding of a hundred steps");
  }
}

// Watching, and what cannot be known.

long differing(const Result& a, const Result& b) {
  long n = a.events.size() != b.events.size();
  const auto differ = [&](const auto& x, const auto& y) { n += !(x == y); };
  differ(a.t_end, b.t_end);
  differ(a.final_state.q, b.final_state.q);
  differ(a.final_state.v, b.final_state.v);
  for (std::size_t i = 0; i < std::min(a.events.size(), b.events.size()); ++i) {
    const auto &x = a.events[i], &y = b.events[i];
    for (const auto field :
         {&Event::t, &Event::v_n_minus, &Event::v_n_plus, &Event::v_t_minus, &Event::v_t_plus,
          &Event::impulse_n, &Event::impulse_t, &Event::duration, &Event::t_uncertainty})
      differ(x.*field, y.*field);
    differ(x.joint, y.joint);
    n += x.kind != y.kind;
  }
  for (const auto field : {&Work::steps, &Work::rejected, &Work::rhs, &Work::jacobians, &Work::factorisations,
                           &Work::lcp_solves, &Work::lcp_retries, &Work::pivots, &Work::events})
    differ(a.work.*field, b.work.*field);
  for (const auto field :
       {&EnergyLedger::kinetic, &EnergyLedger::potential, &EnergyLedger::drive, &EnergyLedger::load,
        &EnergyLedger::contact, &EnergyLedger::friction, &EnergyLedger::stabilisation})
    differ(a.ledger.*field, b.ledger.*field);
  return n;
}

void watching(Findings& f, const State& start) {
  const auto compare = [&](const std::string& way, const Scene& scene, Family family) {
    BalanceWatch watch(scene.mechanism, false, 1e-4, 5);
    const auto watched = run(scene, family, {&watch}, start), alone = run(scene, family, {}, start);
    f.within("numbers of a run (state, events, work, ledger) that watching its forces changes, " + way, "",
             double(differing(watched, alone)), 0, 0, "0", "bit for bit");
  };
  for (const auto integrator : {Integrator::dopri5, Integrator::adams_bashforth_moulton})
    compare(
        integrator == Integrator::dopri5 ? "penalty, dopri5, projection" : "penalty, adams_bashforth_moulton",
        penalty({"", integrator,
                 integrator == Integrator::dopri5 ? Stabilisation::projection : Stabilisation::baumgarte,
                 FrictionLaw::ambrosio, ContactLaw::exact, 4e-3}),
        Family::penalty);
  compare("event-driven", nonsmooth(Scheme::event_driven), Family::nonsmooth);
  compare("Moreau–Jean", nonsmooth(Scheme::moreau_jean), Family::nonsmooth);
}

void redundant(Findings& f, const State& start) {
  // Marked and not marked.
  auto scene = everything();
  scene.run.duration = 1e-5;
  BalanceWatch watch(scene.mechanism, false, 1e-5);
  auto found = run(scene, Family::penalty, {&watch}, start).undetermined;
  std::ranges::sort(found);
  f.within(
      "one of each: reactions marked that are not those of the two pins and the two guides, and the reverse",
      "", found == std::vector<std::string>{"guide", "guide_twin", "main", "main_twin"} ? 0 : 1, 0, 0,
      "their rows are the same twice; all others are independent", "exact");
  // Two pins at one place: their sum is the single pin's.
  const auto s = loaded();
  auto twice = slider_crank(s);
  twice.mechanism.joints.push_back(RevoluteJoint{"twin", {ground, 0}, {Vec2{0, 0}, Vec2{-0.02, 0}}, {}});
  // A door that two guides of one direction hold, a hand apart: their sum is the single guide's.
  Scene door;
  const reference::GuidedBody<double> body{6.0, 0.5 * std::numbers::pi, {0.3, -0.2}, {20, 5}, {0.5, 0.1}};
  door.mechanism.gravity = {0.4, -9.81};
  door.mechanism.bodies.push_back({"door", 6.0, 0.4, {0.3, -0.2}, 0, {0, 0}, 0});
  door.mechanism.joints.push_back(
      TranslationalJoint{"near", {ground, 0}, {Vec2{0, 0}, Vec2{-0.3, 0.2}}, {0, 1}, 0, {}});
  door.mechanism.joints.push_back(
      TranslationalJoint{"far", {ground, 0}, {Vec2{0.6, 0}, Vec2{0.3, 0.2}}, {0, 1}, 0, {}});
  door.mechanism.loads.push_back(ForceLoad{"hand", 0, {0.2, 0.3}, {20, 5}});
  door.run.duration = 0.05;
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    twice.nonsmooth.scheme = door.nonsmooth.scheme = Scheme::event_driven;
    const char* const name = family == Family::penalty ? "penalty" : "event-driven";
    const auto watch_forces = [&](const Scene& each, auto look) {
      Simulation simulation(each, test::name_of(family));
      Forces now{std::vector<ElementForce>(simulation.layout().forces.size()),
                 std::vector<double>(3 * each.mechanism.bodies.size())};
      double off = 0;
      test::Listener listener;
      listener.want.forces = true;
      listener.on_step = [&](const Step& step) {
        step.forces(step.t1, now);
        off = greatest(off, look(step.t1, now.elements, simulation.layout()));
      };
      auto list = simulation.run({.observers = {&listener}}).undetermined;
      std::ranges::sort(list);
      return std::pair{off, list};
    };
    const auto [pins, marked] = watch_forces(twice, [&](double t, const auto& e, const Layout& l) {
      const auto exact = reference::slider_crank_forces(s, s.speed * t);
      const auto &a = e[find(l, "main")], &b = e[find(l, "twin")], &c = e[find(l, "big_end")];
      return std::max(
          {std::hypot(a.fx + b.fx - exact.ground_on_crank.x, a.fy + b.fy - exact.ground_on_crank.y),
           std::hypot(c.fx - exact.crank_on_rod.x, c.fy - exact.crank_on_rod.y)});
    });
    f.at_most(fmt::format("a crank on two pins at one place: their sum, and the big end, {}", name), "N",
              pins, 1e-5, "references/slider_crank_forces",
              "tolerance 1e-10 of some 300 N, room of a hundred");
    f.within("reactions marked there that are not those of the pins, and the reverse", "",
             marked == std::vector<std::string>{"main", "twin"} ? 0 : 1, 0, 0, "two rows twice", "exact");
    const auto [guides, held] = watch_forces(door, [&](double, const auto& e, const Layout& l) {
      const Point g{0.4, -9.81};
      const auto exact = reference::guide_load(body, reference::guided_acceleration(body, g), g);
      const auto &a = e[find(l, "near")], &b = e[find(l, "far")];
      return std::max({std::abs(a.fx + b.fx - exact.joint.force.x),
                       std::abs(a.fy + b.fy - exact.joint.force.y),
                       std::abs(a.m + b.m + 0.6 * b.fy - exact.joint.moment)});
    });
    f.at_most(
        fmt::format("a door on two guides: the sum of their forces, and of moments about one, {}", name),
        "N, N m", guides, 1e-10, "references/bearing_load", "rounding of some 60 N, twice of other length");
    f.within("reactions marked there that are not those of the guides, and the reverse", "",
             held == std::vector<std::string>{"far", "near"} ? 0 : 1, 0, 0, "two rows twice", "exact");
  }
}

}  // namespace

Findings forces() {
  Findings f;
  const auto start = assemble(everything().mechanism, RunOptions::Start::assembled);
  balance(f, start);
  tolerances(f, start);
  csv(f, start);
  slider_cranks(f);
  bearings(f);
  load_cell(f);
  torque_sensor(f);
  watching(f, start);
  redundant(f, start);
  return f;
}

}  // namespace freeplay::verification
