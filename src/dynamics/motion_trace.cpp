// Traces the functions of right-hand sides (system_functions.hpp). The operations and their order are
// those of System, SaddlePoint and the event-driven scheme's ModeMotion.
#include "dynamics/system_functions.hpp"
#include "dynamics/system_tracer.hpp"

namespace freeplay {

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
  const auto q = coordinates(trace, 1, at_.q, true);
  v = coordinates(trace, 2, at_.v, false);
  const auto z = trace.inputs(3, at_.z);
  const auto fresh = system_.make_evaluation<Traced>();
  auto e = fresh;
  system_.place(t, q.data(), e);
  system_.rate(q.data(), v.data(), e);
  system_.forces(t, q.data(), v.data(), z.data(), e);
  List ratios;
  std::vector<int> counts;
  step_F_ = saddle.trace_factors(e.G, ratios, counts);
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
  put_changed(trace, 10, step_F_, List(step_F_.size()));
  const Traced* ratio = ratios.data();
  for (std::size_t block = 0; block < counts.size(); ++block) {
    Traced least(1);
    for (int i = 0; i < counts[block]; ++i, ++ratio)
      least = select(holds(*ratio, Relation::less, least), *ratio, least);
    trace.output(11, static_cast<int>(block), least);
  }
  put_changed(trace, 12, e.G, fresh.G);
  step_G_ = e.G;
  step_phi_t_ = e.phi_t;
  return e;
}

void SystemTracer::motion(TracedObject& object, const SaddlePoint& saddle) {
  auto all = object;
  {
    Trace trace(all, "motion");
    List v, a, lambda;
    const auto e = whole_state(trace, saddle, v);
    saddle.trace_solution(e.G, step_F_, e.force, e.gamma, a, lambda);
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
  const auto F = inputs_like(trace, 0, step_F_), G = inputs_like(trace, 1, step_G_);
  // `motion` has checked the coordinates that stay.
  const auto q = known_coordinates(trace, 2, at_.q, true), v = known_coordinates(trace, 3, at_.v, false);
  auto e = system_.make_evaluation<Traced>();
  orient(trace, 4, e);
  auto a = trace.inputs(6, std::vector<double>(n, 1)), lambda = trace.inputs(7, std::vector<double>(m, 1));
  const auto factor = trace.input(8, 0, -0.1);
  auto drive = trace.input(9, 0, 1);
  const auto phi_t = inputs_like(trace, 10, step_phi_t_);
  ContactRowOf<Traced> row;
  system_.contact(contact, q.data(), v.data(), e, row);
  trace.output(0, 0, row.gap);
  put_row(trace, 1, row.normal);
  put_row(trace, 2, row.tangent);
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
