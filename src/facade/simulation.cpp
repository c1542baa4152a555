#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <string_view>

#include "compile/compile.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/meshing.hpp"
#include "dynamics/assembly/movable_rows.hpp"
#include "dynamics/system.hpp"
#include "facade/assess.hpp"
#include "facade/identify.hpp"
#include "facade/implementation.hpp"
#include "facade/simulation.hpp"
#include "formulations/make.hpp"
#include "formulations/time_stepping/lanes.hpp"
#include "io/files/digest.hpp"
#include "io/files/identity.hpp"
#include "io/scene/check_scene.hpp"
#include "io/scene/write_scene.hpp"
#include "mechanism/outside.hpp"
#include "mechanism/scene.hpp"
#include "simulation/clock.hpp"
#include "simulation/instrument.hpp"
#include "simulation/march.hpp"
#include "simulation/observer.hpp"
#include "simulation/trajectory.hpp"
#include "values/diagnostic.hpp"

namespace freeplay {
namespace {

/// Applies the rules of scenes to one built in code; invalid indices would otherwise be dereferenced.
Scene checked(Scene scene) {
  check_scene(scene);
  return scene;
}

State start_of(const Scene& scene, Family family, const System& system, const SimulationOptions& options,
               std::string& assumed) {
  if (!options.start) {
    // The compliance of contacts matters for an equilibrium only: other starts have no contact
    // load.
    const bool rests = scene.run.start == RunOptions::Start::equilibrium;
    auto start = assemble(scene.mechanism, scene.run.start, &assumed, options.stop,
                          rests ? compliances(family, scene, system) : Compliances{});
    require_mesh(scene.mechanism, start.q);
    return start;
  }
  const auto n = static_cast<std::size_t>(system.n()), states = static_cast<std::size_t>(system.states());
  if (options.start->q.size() != n || options.start->v.size() != n)
    throw ModelError("start", fmt::format("must have {} coordinates and as many rates, has {} and {}", n,
                                          options.start->q.size(), options.start->v.size()));
  if (!options.start->z.empty() && options.start->z.size() != states)
    throw ModelError("start",
                     fmt::format("must have {} first-order states, or none for initial values of 0, has {}",
                                 states, options.start->z.size()));
  return *options.start;
}

long peak_memory_kib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

}  // namespace

Simulation::Implementation::Implementation(Scene given, std::string_view formulation,
                                           const SimulationOptions& options)
    : scene(options.checked ? std::move(given) : checked(std::move(given))),
      family(family_of(formulation)),
      given_start(options.start),
      system(scene.mechanism),
      start(start_of(scene, family, system, options, assumed)),
      restitution(matched_restitution(family, options.matched, scene, system)),
      layout(layout_of(scene, system, start)),
      form(make_formulation(start)),
      sensors(scene.instruments, layout, start.q.size(), noise_of_run()),
      compile(compile_choice(options.compile)),
      structures(options.structures) {
  if (compile == Compile::always) compile_now(options.stop);
}

std::unique_ptr<Formulation> Simulation::Implementation::make_formulation(const State& at) const {
  return make(family, scene, system, at, restitution.value_or(std::vector<double>{}));
}

Identity Simulation::Implementation::identity() const {
  auto found = identify(scene, family, restitution);
  found.given = start_identity(given_start);
  return found;
}

/// Seed of the run's noise, from its identity without the program: equal runs of different
/// program versions have equal noise.
std::uint64_t Simulation::Implementation::noise_of_run() const {
  if (std::ranges::none_of(scene.instruments, [](const Instrument& i) { return i.noise.has_value(); }))
    return 0;
  auto all = identity();
  all.program.clear();
  return checksum(all.digest());
}

/// Finds the undetermined reactions once, when an observer first requests forces.
void Simulation::Implementation::find_undetermined() {
  if (searched) return;
  searched = true;
  for (const int e : undetermined_elements(system, start)) {
    layout.forces[e].determined = false;
    undetermined.push_back(layout.forces[e].name);
  }
}

RowFacts Simulation::Implementation::facts() {
  if (!redundant) redundant = !redundant_rows(system, start.q).empty();
  return {*redundant, scene.run.eliminate};
}

void Simulation::Implementation::compile_now(const StopToken& stop, bool only_known, double worth) {
  const auto& nonsmooth = scene.nonsmooth;
  auto scheme = TracedFor::penalty;
  if (family == Family::nonsmooth) {
    const bool fixed = nonsmooth.scheme_in_force() == Scheme::moreau_jean;
    scheme = !fixed ? TracedFor::event_driven : nonsmooth.step ? TracedFor::fixed_steps : TracedFor::any;
  }
  compiled = compile_system(system, start, facts(), stop, scheme, structures, only_known, worth);
  if (compiled) compiled->from = form->state().t;
}

void Simulation::Implementation::compile_if_long(const CompileObserver& run) {
  if (compiled || compile != Compile::automatic) return;
  const long rhs = form->work().rhs;
  if (rhs >= (structures ? compiles_study_after : compiles_after)) {
    // The other runs of a study use the functions, too.
    compile_now(run.token, false, structures ? longest_estimate : most_saved * run.left());
  } else if (!looked && structures && rhs >= attaches_after) {
    looked = true;
    if (structures->any()) compile_now(run.token, true);
  }
}

/// Restores into a new formulation and new sensors, which replace the current ones after everything
/// was read.
void Simulation::Implementation::load(const std::vector<std::byte>& memory) {
  MemoryReader m(memory);
  State begin = start;
  m(begin.t, begin.q, begin.v);
  if (begin.q.size() != start.q.size() || begin.v.size() != start.v.size())
    throw MemoryError("the snapshot belongs to another mechanism");
  const bool elsewhere = begin.t != start.t || begin.q != start.q || begin.v != start.v;
  auto there = elsewhere ? layout_of(scene, system, begin) : layout;
  auto loaded = make_formulation(begin);
  loaded->load(m);
  m.part("sensors");
  Sensors read = sensors;
  m(read);
  if (!m.at_end()) throw MemoryError("the snapshot is too long");
  if (elsewhere) {
    start = std::move(begin);
    layout = std::move(there);
    searched = false;
    redundant.reset();
    undetermined.clear();
  }
  form = std::move(loaded);
  sensors = std::move(read);
}

Result Simulation::Implementation::summary(const Ending& ending) const {
  Result r;
  r.formulation = name_of(family);
  r.ending = ending;
  r.final_state = form->state();
  r.t_end = r.final_state.t;
  r.observed = std::max(0.0, r.t_end - scene.run.discard);
  r.revolutions = r.observed * std::abs(layout.crank_speed) / (2 * std::numbers::pi);
  r.ledger = form->ledger();
  r.work = form->work();
  r.extremes = form->extremes();
  r.notes = form->notes();
  for (const auto& [load, force] : outside_of(scene).forces)
    r.notes.push_back(diagnostic<Diagnostic::own_load>(load, force->name, force->digest));
  r.assumed = assumed;
  r.undetermined = undetermined;
  if (compiled) {
    r.compiled = *compiled;
    r.compiled.refused = system.compiled().refused();
  } else {
    r.compiled.reason = compile == Compile::never
                            ? "not requested"
                            : fmt::format("fewer than {} right-hand sides",
                                          structures ? compiles_study_after : compiles_after);
  }
  const auto models = form->contact_models();
  for (int k = 0; k < system.reported(); ++k) {
    ContactSummary c;
    c.name = system.contact_facts(k).name;
    c.model = models[k];
    c.penetration = r.extremes.penetration[k];
    const auto& facts = system.contact_facts(k);
    c.measure = facts.has_clearance ? "clearance" : facts.radius > 0 ? "radius" : "arm";
    c.penetration_ratio = facts.measure() > 0 ? c.penetration / facts.measure() : 0;
    if (k >= system.contacts())  // a family of pairs has no share of the time
      c.flight_fraction = c.impact_fraction = c.lasting_fraction = NAN;
    r.contacts.push_back(c);
  }
  const auto finer = family == Family::penalty ? fineness_key(scene.penalty)
                                               : fineness_key(scene.nonsmooth, r.work.handovers > 0);
  warn(r, family, finer, rounding_energy(system, start, r.t_end));
  refuse_too_deep(r, family, finer);
  refuse_not_finite(r);
  return r;
}

void Simulation::Implementation::Running::refuse(bool flag) {
  if (flag) throw std::logic_error("an observer must not run or restore the simulation that it observes");
}

namespace {

/// The end of a run, s.
double end_of_run(const RunRequest& request, double duration, double now) {
  const double until = request.until.value_or(duration);
  if (!std::isfinite(until) || until < now)
    throw ModelError("until", fmt::format("must not be before the present time {} s, is {} s", now, until));
  return until;
}

}  // namespace

Simulation::Implementation::RunInProgress::RunInProgress(Implementation& s, const RunRequest& request)
    : simulation(s),
      until(end_of_run(request, s.scene.run.duration, s.form->state().t)),
      list(request.most_events),
      compiler(s, until, request.stop),
      watch(s.layout, s.sensors, observers_of(request), request.stop),
      running(s.running) {
  s.layout.end = until;
  wall = std::chrono::steady_clock::now();
  cpu = thread_seconds();
  watch.begin(s.form->state());
}

std::vector<Observer*> Simulation::Implementation::RunInProgress::observers_of(const RunRequest& request) {
  auto observers = request.observers;
  if (request.keep_events) observers.push_back(&list);
  if (std::ranges::any_of(observers, [&](const Observer* o) {
        return o->wants().forces || (o->wants().samples && simulation.sensors.wants_forces());
      }))
    simulation.find_undetermined();
  if (!simulation.compiled && simulation.compile == Compile::automatic) observers.push_back(&compiler);
  for (const auto* o : observers) {
    const auto wants = o->wants();
    const auto* some = dynamic_cast<const Occasional*>(o);
    // Instruments of motions follow steps in lanes; forces are known only in steps of their own.
    if (wants.forces || (wants.samples && simulation.sensors.wants_forces()) || (wants.steps && !some))
      every_step = true;
    if (wants.steps && some) occasional.push_back(some);
  }
  return observers;
}

double Simulation::Implementation::RunInProgress::next_shown() const {
  double next = INFINITY;
  if (every_step) return -next;
  for (const auto* o : occasional) next = std::min(next, o->next());
  return next;
}

std::function<void(const Step&)> Simulation::Implementation::RunInProgress::follow(
    const std::vector<Observer*>& followers) {
  const bool samples = watch.wants_samples();
  if (!samples && followers.empty()) return {};
  return [this, samples, followers](const Step& step) {
    if (samples) watch.sample(step);
    for (auto* o : followers) o->step(step);
  };
}

Result Simulation::Implementation::RunInProgress::finish(const Ending& ending) {
  auto& s = simulation;
  watch.end(ending, s.form->state().t, s.form->log());
  auto result = s.summary(ending);
  result.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count();
  result.cpu_seconds = thread_seconds() - cpu;
  result.peak_memory_kib = peak_memory_kib();
  result.events = std::move(list.events);
  result.events_seen = list.seen;
  return result;
}

Simulation::Simulation(Scene scene, std::string_view formulation, SimulationOptions options)
    : it_(std::make_unique<Implementation>(std::move(scene), formulation, options)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

Result Simulation::run(const RunRequest& request) {
  Implementation::RunInProgress run(*it_, request);
  auto& form = *it_->form;
  // Runs of a study share lanes with each other.
  if (run.every_step || it_->structures) return run.finish(form.run(run.until, run.watch));
  return run.finish(run_in_single_lane(
      form, run.until, run.watch, [&] { return run.next_shown(); }, run.follow()));
}

const Scene& Simulation::scene() const { return it_->scene; }
const Layout& Simulation::layout() const { return it_->layout; }
double Simulation::t() const { return it_->form->state().t; }
Identity Simulation::identity() const { return it_->identity(); }
State Simulation::state() const { return it_->form->state(); }
EnergyLedger Simulation::ledger() const { return it_->form->ledger(); }

Snapshot Simulation::snapshot() const {
  Snapshot s;
  s.t = t();
  auto identity = it_->identity();
  s.program = std::move(identity.program);
  s.formulation = std::move(identity.formulation);
  s.scene = std::move(identity.scene);
  MemoryWriter m(s.memory);
  it_->save(m);
  return s;
}

void Simulation::restore(const Snapshot& s) {
  Implementation::Running::refuse(it_->running);
  const auto refuse = [](const std::string& why) { throw SnapshotError("the snapshot " + why); };
  s.require_program();
  const auto own = identity();
  if (s.formulation != own.formulation)
    refuse("is of another formulation: " + first_difference(own.formulation, s.formulation));
  if (s.scene != own.scene) refuse("is of another scene: " + first_difference(own.scene, s.scene));
  try {
    it_->load(s.memory);
  } catch (const MemoryError& e) {
    throw SnapshotError(e.what());
  } catch (const ModelError& e) {
    refuse(fmt::format("is damaged: its state is impossible: {}", e.what()));
  } catch (const std::exception&) {
    refuse("is damaged: it has unknown content");  // an absurd size, or another start
  }
}

}  // namespace freeplay
