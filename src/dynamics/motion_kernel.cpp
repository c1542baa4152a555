#include "dynamics/motion_kernel.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/system_functions.hpp"
#include "dynamics/system_tracer.hpp"

namespace freeplay {

/// Collects the addresses; they are not usable if rows are eliminated otherwise.
bool MotionKernel::prepare(const System& system, SaddlePoint& saddle, Evaluation& e) {
  saddle_ = &saddle;
  e_ = &e;
  object_ = system.compiled().functions().object.get();
  const auto room = saddle.compiled_room();
  usable_ = room.usable;
  if (!usable_) return false;
  std::ranges::copy(e.G, room.G);  // the functions write entries that are not constant
  least_.assign(static_cast<std::size_t>(saddle.blocks()), 1);
  out_ = {e.cosine.data(), e.sine.data(),  e.phi.data(),   e.phi_t.data(), e.G.data(),
          e.gamma.data(),  e.force.data(), &e.power.drive, &e.power.load,  &e.power.damping,
          room.factors,    least_.data(),  room.G};
  return true;
}

[[gnu::always_inline]] inline bool MotionKernel::call(CompiledFunction function, const System& system,
                                                      SaddlePoint& saddle, Evaluation& e,
                                                      const double* const* in, double* first, double* second,
                                                      double* drive) {
  auto& functions = system.compiled().functions();
  if (saddle_ == &saddle && e_ == &e && object_ == functions.object.get()) {
    if (!usable_) return false;
  } else if (!prepare(system, saddle, e)) {
    return false;
  }
  out_[13] = first;
  out_[14] = second;
  out_[15] = drive;
  if (!functions.call(function, in, out_.data())) return false;
  saddle.take_compiled(least_.data());
  return true;
}

bool MotionKernel::motion(const System& system, SaddlePoint& saddle, Evaluation& e, const At& at, double* a,
                          double* lambda, double& drive) {
  const auto function = system.compiled().functions().motion.motion;
  if (!function) return false;
  const double* in[] = {&at.t, at.q, at.v, at.z};
  return call(function, system, saddle, e, in, a, lambda, &drive);
}

bool MotionKernel::state(const System& system, SaddlePoint& saddle, Evaluation& e, const At& at,
                         const double* terms, double* rate, double* r) {
  const auto function = system.compiled().functions().motion.state;
  if (!function) return false;
  const double* in[] = {&at.t, at.q, at.v, at.z, terms};
  return call(function, system, saddle, e, in, rate, r, nullptr);
}

bool MotionKernel::slide(const System& system, int k, const At& at, double factor, ContactRow& row, double* a,
                         double* lambda, Slide& found) {
  auto& functions = system.compiled().functions();
  const auto contact = static_cast<std::size_t>(k);
  const double* in[] = {out_[10], out_[12], at.q,    at.v,    out_[0], out_[1],
                        a,        lambda,   &factor, out_[7], out_[3]};
  double* out[] = {&row.gap, row.normal.value.data(), row.tangent.value.data(), &row.gamma_n, &row.gamma_t, a,
                   lambda,   &found.mobility};
  if (!functions.call(functions.motion.slides[contact], in, out)) return false;
  const auto& pattern = functions.contacts[contact].pattern;
  const auto take_shape = [](SparseRow& to, const SparseRow& from) {
    if (to.size == from.size) return;  // the columns of a pair never change
    to.size = from.size;
    to.column = from.column;
  };
  take_shape(row.normal, pattern.normal);
  take_shape(row.tangent, pattern.tangent);
  row.film.size = row.spin.size = 0;
  return true;
}

namespace {

/// All quantities at one state, in one order; `kernel`: by the compiled functions, else by the templates.
std::vector<double> motion_quantities(const System& system, const SystemFunctions& asked, const State& at,
                                      RowFacts facts, bool compiled) {
  SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic, facts);
  if (compiled) saddle.use(system.compiled().solve());
  std::vector<double> all;
  const auto put = [&](const auto& list) { all.insert(all.end(), list.begin(), list.end()); };
  const double *q = at.q.data(), *v = at.v.data();
  auto e = system.make_evaluation();
  const auto n = e.force.size(), m = e.gamma.size();
  std::vector<double> a(n), lambda(m), rate(m), r(m);
  constexpr std::array terms{10.0, 25.0};
  const double factor = -0.03;
  MotionKernel kernel;
  const MotionKernel::At place{at.t, q, v, at.z.data()};
  const auto put_state = [&] {
    for (const auto* list : {&e.cosine, &e.sine, &e.phi, &e.phi_t, &e.G, &e.gamma, &e.force}) put(*list);
    put(std::array{e.power.drive, e.power.load, e.power.damping, saddle.nearest_singular()});
  };
  const auto evaluate = [&] {
    system.place(at.t, q, e);
    system.rate(q, v, e);
    system.forces(at.t, q, v, at.z.data(), e);
    return saddle.factor(e.G.data());
  };
  if (asked.motion.state) {
    const bool known =
        compiled ? kernel.state(system, saddle, e, place, terms.data(), rate.data(), r.data()) : evaluate();
    if (!known && compiled) return {};
    if (!compiled)
      for (std::size_t k = 0; k < m; ++k) {
        rate[k] = row_dot(system.pattern(), e.G.data(), static_cast<int>(k), v) + e.phi_t[k];
        r[k] = e.gamma[k] - terms[0] * rate[k] - terms[1] * e.phi[k];
      }
    saddle.solve(e.force.data(), r.data(), a.data(), lambda.data());
    put_state();
    for (const auto* list : {&rate, &r, &a, &lambda}) put(*list);
  }
  if (!asked.motion.motion) return all;
  double drive = 0;
  const auto free = [&] {
    if (compiled) return kernel.motion(system, saddle, e, place, a.data(), lambda.data(), drive);
    if (!evaluate()) return false;
    saddle.solve(e.force.data(), e.gamma.data(), a.data(), lambda.data());
    drive = e.power.drive;
    for (std::size_t k = 0; k < m; ++k) drive += lambda[k] * e.phi_t[k];
    return true;
  };
  for (int k = -1; k < system.contacts(); ++k) {
    if (!free()) return {};
    if (k < 0) put_state();
    ContactRow row;
    MotionKernel::Slide slide{};
    if (k >= 0 && compiled) {
      if (!kernel.slide(system, k, place, factor, row, a.data(), lambda.data(), slide)) return {};
    } else if (k >= 0) {
      std::vector<double> x(n), reaction(m);
      system.contact(k, q, v, e, row);
      saddle.respond(row.normal, row.tangent.size > 0 ? &row.tangent : nullptr, factor, x.data(),
                     reaction.data());
      slide.mobility = row.normal.dot(x.data());
      slide.force = (row.gamma_n - row.normal.dot(a.data())) / slide.mobility;
      slide.drive = e.power.drive;
      for (std::size_t i = 0; i < n; ++i) a[i] += slide.force * x[i];
      for (std::size_t i = 0; i < m; ++i) {
        lambda[i] += slide.force * reaction[i];
        slide.drive += lambda[i] * e.phi_t[i];
      }
      slide.sliding = row.tangent.dot(v);
    }
    put(a);
    put(lambda);
    put(std::array{drive, row.gap, row.gamma_n, row.gamma_t, slide.mobility, slide.force, slide.drive,
                   slide.sliding});
    for (const auto* x : {&row.normal, &row.tangent})
      for (int i = 0; i < x->size; ++i) put(std::array{static_cast<double>(x->column[i]), x->value[i]});
  }
  return all;
}

}  // namespace

long differing_motions(System& system, const SystemFunctions& functions, const State& near, RowFacts facts,
                       int states) {
  if (!functions.motion.motion && !functions.motion.state) return 0;
  const auto still = still_coordinates(system, near);
  long differing = 0;
  // At the start itself a journal may be concentric, where no function is used.
  for (unsigned seed = 1; seed <= static_cast<unsigned>(states); ++seed) {
    auto at = moved(system, near, still, seed);
    at.z.resize(static_cast<std::size_t>(system.states()));
    system.compiled().attach({});
    const auto expected = motion_quantities(system, functions, at, facts, false);
    system.compiled().attach(functions);
    const auto found = motion_quantities(system, functions, at, facts, true);
    if (found.empty()) continue;  // a guard failed
    differing += differing_numbers(found, expected);
  }
  system.compiled().attach({});
  return differing;
}

// Traces the functions of right-hand sides (system_functions.hpp). The operations and their order are
// those of System, SaddlePoint and the event-driven scheme's ModeMotion.

bool SystemTracer::points(const System& system) { return system.phases() == 0 && !system.has_motions(); }

bool SystemTracer::motions(const System& system) {
  if (!points(system)) return false;
  for (int k = 0; k < system.contacts(); ++k)
    if (system.contact_facts(k).lubricant) return false;
  return system.frictions() == 0;
}

/// Inputs 0 to 3 and outputs 0 to 12, which `motion` and `state` have in common.
EvaluationOf<Traced> SystemTracer::whole_state(Trace& trace, const SaddlePoint& saddle, List& v) {
  const auto t = trace.input(0, 0, at_.t);
  const auto q = coordinates(trace, 1, true);
  v = coordinates(trace, 2, false);
  const auto z = trace.inputs(3, at_.z);
  const auto fresh = system_.make_evaluation<Traced>();
  auto e = fresh;
  system_.place(t, q.data(), e);
  system_.rate(q.data(), v.data(), e);
  system_.forces(t, q.data(), v.data(), z.data(), e);
  List ratios;
  std::vector<int> counts;
  whole_F_ = saddle.trace_factors(e.G, ratios, counts);
  trace.outputs(0, e.cosine);
  trace.outputs(1, e.sine);
  trace.outputs(2, e.phi);
  put_changed(trace, 3, e.phi_t, fresh.phi_t);
  put_changed(trace, 4, e.G, fresh.G);
  put_changed(trace, 5, e.gamma, fresh.gamma);
  trace.outputs(6, e.force);
  trace.output(7, 0, e.power.drive);
  trace.output(8, 0, e.power.load);
  trace.output(9, 0, e.power.damping);
  put_changed(trace, 10, whole_F_, List(whole_F_.size()));
  const Traced* ratio = ratios.data();
  for (std::size_t block = 0; block < counts.size(); ++block) {
    Traced least(1);
    for (int i = 0; i < counts[block]; ++i, ++ratio)
      least = select(holds(*ratio, Relation::less, least), *ratio, least);
    trace.output(11, static_cast<int>(block), least);
  }
  put_changed(trace, 12, e.G, fresh.G);
  whole_G_ = e.G;
  whole_phi_t_ = e.phi_t;
  return e;
}

void SystemTracer::motion(TracedObject& object, const SaddlePoint& saddle) {
  auto all = object;
  {
    Trace trace(all, "motion");
    List v, a, lambda;
    const auto e = whole_state(trace, saddle, v);
    saddle.trace_solution(e.G, whole_F_, e.force, e.gamma, a, lambda);
    saddle.trace_finish(e.G, e.force, a, lambda);
    trace.outputs(13, a);
    trace.outputs(14, lambda);
    auto drive = e.power.drive;
    for (std::size_t k = 0; k < lambda.size(); ++k) drive += lambda[k] * e.phi_t[k];
    trace.output(15, 0, drive);
  }
  for (int k = 0; k < system_.contacts(); ++k) slide(all, saddle, k);
  object = std::move(all);
}

void SystemTracer::state(TracedObject& object, const SaddlePoint& saddle) {
  Trace trace(object, "state");
  List v;
  const auto e = whole_state(trace, saddle, v);
  const auto terms = trace.inputs(4, std::vector<double>{10, 25});
  const auto m = e.phi.size();
  List rate(m), r(m);
  for (std::size_t k = 0; k < m; ++k) {
    rate[k] = row_dot(system_.pattern(), e.G.data(), static_cast<int>(k), v.data()) + e.phi_t[k];
    r[k] = e.gamma[k] - terms[0] * rate[k] - terms[1] * e.phi[k];
  }
  trace.outputs(13, rate);
  trace.outputs(14, r);
}

void SystemTracer::slide(TracedObject& object, const SaddlePoint& saddle, int contact) const {
  Trace trace(object, "slide_" + std::to_string(contact));
  const auto n = static_cast<std::size_t>(system_.n()), m = static_cast<std::size_t>(system_.rows());
  const auto F = inputs_like(trace, 0, whole_F_), G = inputs_like(trace, 1, whole_G_);
  // `motion` has checked the coordinates that stay.
  const auto q = known_coordinates(trace, 2, true), v = known_coordinates(trace, 3, false);
  auto e = system_.make_evaluation<Traced>();
  orient(trace, 4, e);
  auto a = trace.inputs(6, std::vector<double>(n, 1)), lambda = trace.inputs(7, std::vector<double>(m, 1));
  const auto factor = trace.input(8, 0, -0.1);
  auto drive = trace.input(9, 0, 1);
  const auto phi_t = inputs_like(trace, 10, whole_phi_t_);
  ContactRowOf<Traced> row;
  system_.contact(contact, q.data(), v.data(), e, row);
  trace.output(0, 0, row.gap);
  for (int i = 0; i < row.normal.size; ++i) trace.output(1, i, row.normal.value[i]);
  for (int i = 0; i < row.tangent.size; ++i) trace.output(2, i, row.tangent.value[i]);
  trace.output(3, 0, row.gamma_n);
  trace.output(4, 0, row.gamma_t);
  List f(n), x, reaction;
  row.normal.add_to(f.data(), Traced(1));
  row.tangent.add_to(f.data(), factor);
  saddle.trace_solution(G, F, f, List(m), x, reaction);
  saddle.trace_finish(G, f, x, reaction);
  const auto mobility = row.normal.dot(x.data());
  if (!(mobility > Traced(0))) throw NotTraceable("a contact beyond a pole of its force at the start");
  const auto force = (row.gamma_n - row.normal.dot(a.data())) / mobility;
  for (std::size_t i = 0; i < n; ++i) a[i] += force * x[i];
  for (std::size_t k = 0; k < m; ++k) {
    lambda[k] += force * reaction[k];
    drive += lambda[k] * phi_t[k];
  }
  trace.outputs(5, a);
  trace.outputs(6, lambda);
  trace.outputs(7, List{mobility, force, drive, row.tangent.dot(v.data())});
}

}  // namespace freeplay
