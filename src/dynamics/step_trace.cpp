// Traces the functions of a step of the midpoint rule (system_functions.hpp). The operations and
// their order are those of formulations/time_stepping; inputs that nothing changes are constants.
#include "dynamics/system_functions.hpp"
#include "dynamics/system_tracer.hpp"

namespace freeplay {
namespace {

/// Number of contact rows up to which a step has one dense contact problem.
constexpr int most_rows = 24;
static_assert(most_step_contacts >= most_rows);

}  // namespace

void SystemTracer::put_changed(Trace& trace, int array, const List& x, const List& fresh) {
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!x[i].is_constant() || x[i].value != fresh[i].value) trace.output(array, static_cast<int>(i), x[i]);
}

void SystemTracer::put_row(Trace& trace, int array, const SparseRowOf<Traced>& row) {
  for (int i = 0; i < row.size; ++i) trace.output(array, i, row.value[i]);
}

bool SystemTracer::iterates(const System& system) {
  return system.has_velocity_forces() || system.curves().sweeps;
}

bool SystemTracer::steps(const System& system) {
  int rows = system.frictions();
  for (int k = 0; k < system.contacts(); ++k) {
    if (system.contact_facts(k).lubricant) return false;
    rows += system.has_friction(k) ? 2 : 1;
  }
  const bool frictions =
      system.frictions() == 0 || (system.reactive_frictions().empty() && !iterates(system));
  return system.n() > 0 && rows <= most_rows && system.states() == 0 && frictions &&
         system.families().empty() && !system.has_motions();
}

void SystemTracer::step(TracedObject& object, const SaddlePoint& saddle) {
  auto all = object;  // a part that cannot be traced leaves no other part behind
  step_middle(all, saddle);
  if (iterates(system_)) step_again(all, saddle);
  step_end(all, saddle);
  step_reached(all);
  for (int k = 0; k < system_.contacts(); ++k) step_response(all, saddle, k);
  object = std::move(all);
}

/// The entries of a list as inputs, except its constants.
std::vector<Traced> SystemTracer::inputs_like(Trace& trace, int array, const List& known) const {
  auto list = known;
  for (std::size_t i = 0; i < list.size(); ++i)
    if (!list[i].is_constant()) list[i] = trace.input(array, static_cast<int>(i), list[i].value);
  return list;
}

void SystemTracer::step_middle(TracedObject& object, const SaddlePoint& saddle) {
  Trace trace(object, "step_middle");
  const auto t = trace.input(0, 0, at_.t), h = trace.input(1, 0, 1e-5);
  const auto q = coordinates(trace, 2, at_.q, true), v = coordinates(trace, 3, at_.v, false);
  const auto n = q.size();
  List middle(n), f(n), r(static_cast<std::size_t>(system_.rows())), ratios, a, lambda;
  for (std::size_t i = 0; i < n; ++i) middle[i] = q[i] + 0.5 * h * v[i];
  const auto fresh = system_.make_evaluation<Traced>();
  auto e = fresh;
  system_.place(t, middle.data(), e);
  system_.rate(middle.data(), v.data(), e);
  std::vector<int> counts;
  step_F_ = saddle.trace_factors(e.G, ratios, counts);
  const SweepOf<Traced> sweep{h, v.data(), v.data()};
  system_.forces(t, middle.data(), v.data(), nullptr, e, {&sweep});
  for (std::size_t i = 0; i < n; ++i) f[i] = system_.mass()[i] * v[i] + h * e.force[i];
  for (std::size_t k = 0; k < r.size(); ++k) r[k] = -e.phi_t[k] + 0.5 * h * e.gamma[k];
  saddle.trace_solution(e.G, step_F_, f, r, a, lambda);
  const bool lanes = object.lanes() > 0;
  trace.outputs(0, middle);
  trace.outputs(1, e.cosine);
  trace.outputs(2, e.sine);
  put_changed(trace, 3, e.phi_t, fresh.phi_t);
  put_changed(trace, 4, e.G, fresh.G);
  put_changed(trace, 5, e.gamma, fresh.gamma);
  put_changed(trace, 6, step_F_, List(step_F_.size()));
  if (!lanes) trace.outputs(7, ratios);
  trace.outputs(8, f);
  trace.outputs(9, a);
  trace.outputs(10, lambda);
  if (!lanes) put_changed(trace, 11, e.G, fresh.G);
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& row = step_rows_.emplace_back();
    system_.contact(k, middle.data(), v.data(), e, row);
    const int array = 12 + 6 * k;
    trace.output(array, 0, row.gap);
    put_row(trace, array + 1, row.normal);
    put_row(trace, array + 2, row.tangent);
    trace.output(array + 3, 0, row.gamma_n);
    trace.output(array + 4, 0, row.gamma_t);
    const List rates{row.normal.dot(a.data()), row.tangent.dot(a.data()), row.normal.dot(v.data()),
                     row.tangent.dot(v.data())};
    trace.outputs(array + 5, rates);
  }
  if (lanes && system_.frictions() > 0)
    step_slide_gamma_ = system_.friction(0, middle.data(), v.data(), e, step_slide_);
  if (lanes) lanes_middle(trace, h, ratios, a);
  lane_ratios_ = std::move(counts);
  if (!lanes && iterates(system_)) trace.outputs(12 + 6 * system_.contacts(), e.force);
  step_gamma_ = e.gamma;
  step_G_ = e.G;
  step_phi_t_ = e.phi_t;
}

void SystemTracer::step_again(TracedObject& object, const SaddlePoint& saddle) {
  Trace trace(object, "step_again");
  const auto t = trace.input(0, 0, at_.t), h = trace.input(1, 0, 1e-5);
  const auto middle = known_coordinates(trace, 2, at_.q, true),
             v_old = known_coordinates(trace, 3, at_.v, false), mean = coordinates(trace, 4, at_.v, false);
  const auto phi_t = inputs_like(trace, 5, step_phi_t_), G = inputs_like(trace, 6, step_G_),
             F = inputs_like(trace, 7, step_F_), gamma = inputs_like(trace, 8, step_gamma_);
  auto e = system_.make_evaluation<Traced>();
  orient(trace, 9, e);
  const SweepOf<Traced> sweep{h, v_old.data(), mean.data()};
  system_.forces(t, middle.data(), mean.data(), nullptr, e, {&sweep});
  List f(middle.size()), r(gamma.size()), a, lambda;
  for (std::size_t i = 0; i < f.size(); ++i) f[i] = system_.mass()[i] * v_old[i] + h * e.force[i];
  for (std::size_t k = 0; k < r.size(); ++k) r[k] = -phi_t[k] + 0.5 * h * gamma[k];
  saddle.trace_solution(G, F, f, r, a, lambda);
  trace.outputs(0, e.force);
  trace.outputs(1, f);
  trace.outputs(2, a);
  trace.outputs(3, lambda);
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& sample = step_rows_[static_cast<std::size_t>(k)];
    const auto normal = row_of(trace, sample.normal, 11 + 2 * k),
               tangent = row_of(trace, sample.tangent, 12 + 2 * k);
    trace.outputs(4 + k, List{normal.dot(a.data()), tangent.dot(a.data())});
  }
}

SystemTracer::List SystemTracer::residuals(const EvaluationOf<Traced>& e) const {
  List worst(2);
  for (std::size_t k = 0; k < e.phi.size(); ++k) {
    auto& x = worst[system_.is_angle_row(static_cast<int>(k)) ? 1 : 0];
    x = max(x, abs(e.phi[k]));
  }
  return worst;
}

void SystemTracer::put_end(Trace& trace, int array, int gaps, const List& q, const EvaluationOf<Traced>& e) {
  trace.outputs(array, residuals(e));
  for (int k = 0; k < system_.contacts(); ++k) trace.output(gaps + k, 0, gap_at(k, q, e));
}

void SystemTracer::step_end(TracedObject& object, const SaddlePoint& saddle) {
  Trace trace(object, "step_end");
  // A while after the start: the angle of a driven crank is not exactly 0.
  const auto t = trace.input(0, 0, at_.t + 1e-6), h = trace.input(1, 0, 1e-5);
  // step_middle has checked the coordinates that stay.
  const auto middle = known_coordinates(trace, 2, at_.q, true),
             v_old = known_coordinates(trace, 3, at_.v, false), v = coordinates(trace, 4, at_.v, false);
  const auto n = middle.size(), m = static_cast<std::size_t>(system_.rows());
  auto lambda = trace.inputs(5, std::vector<double>(m, 1));
  const auto f = trace.inputs(6, std::vector<double>(n, 1));
  const auto phi_t = inputs_like(trace, 7, step_phi_t_), G = inputs_like(trace, 8, step_G_),
             F = inputs_like(trace, 9, step_F_);
  auto from = system_.make_evaluation<Traced>();
  orient(trace, 10, from);
  saddle.trace_finish(G, f, v, lambda);
  List q(n), mean(n);
  for (std::size_t i = 0; i < n; ++i) q[i] = middle[i] + 0.5 * h * v[i];
  for (std::size_t i = 0; i < n; ++i) mean[i] = 0.5 * (v_old[i] + v[i]);
  auto drive = trace.input(12, 0, 0), stabilisation = trace.input(13, 0, 0);
  const auto& pattern = system_.pattern();
  for (std::size_t k = 0; k < m; ++k) {
    drive += lambda[k] * phi_t[k];
    stabilisation -= lambda[k] * (row_dot(pattern, G.data(), static_cast<int>(k), mean.data()) + phi_t[k]);
  }
  trace.outputs(0, q);
  auto e = system_.make_evaluation<Traced>();
  system_.place_near(t, q.data(), middle.data(), from, e);
  if (m > 0) {
    List r(m), dq, ignored;
    for (std::size_t k = 0; k < m; ++k) r[k] = -e.phi[k];
    saddle.trace_solution(G, F, List(n), r, dq, ignored);
    for (std::size_t i = 0; i < n; ++i) q[i] += dq[i];
    system_.place_near(t, q.data(), middle.data(), from, e);
  }
  trace.outputs(1, q);
  if (object.lanes() == 0) {
    for (auto& x : lambda) x /= h;
    trace.outputs(2, lambda);
    trace.outputs(3, mean);
  }
  trace.output(4, 0, drive);
  trace.output(5, 0, stabilisation);
  Traced sum;
  for (std::size_t i = 0; i < n; ++i) sum += q[i] + v[i];
  if (object.lanes() > 0) return lanes_end(trace, q, v, drive, sum, e);
  trace.output(7, 0, sum);
  put_end(trace, 6, 8, q, e);
}

void SystemTracer::step_reached(TracedObject& object) {
  Trace trace(object, "step_reached");
  const auto t = trace.input(0, 0, at_.t);
  const auto q = coordinates(trace, 1, at_.q, true), middle = known_coordinates(trace, 2, at_.q, true);
  auto from = system_.make_evaluation<Traced>(), e = from;
  orient(trace, 3, from);
  system_.place_near(t, q.data(), middle.data(), from, e);
  put_end(trace, 0, 1, q, e);
}

/// The response to a row.
void SystemTracer::response(const SaddlePoint& saddle, const List& G, const List& F,
                            const SparseRowOf<Traced>& row, List& a, List& lambda) const {
  List f(static_cast<std::size_t>(system_.n()));
  row.add_to(f.data(), Traced(1));
  saddle.trace_solution(G, F, f, List(static_cast<std::size_t>(system_.rows())), a, lambda);
}

/// A row whose entries are inputs.
SparseRowOf<Traced> SystemTracer::row_of(Trace& trace, const SparseRowOf<Traced>& row, int array) {
  auto x = row;
  for (int i = 0; i < x.size; ++i) x.value[i] = trace.input(array, i, row.value[i].value);
  return x;
}

void SystemTracer::step_response(TracedObject& object, const SaddlePoint& saddle, int contact) {
  const auto& sample = step_rows_[static_cast<std::size_t>(contact)];
  const auto n = static_cast<std::size_t>(system_.n()), m = static_cast<std::size_t>(system_.rows());
  List a(n), a_reaction(m), b(n), b_reaction(m);
  {
    Trace trace(object, "step_response_" + std::to_string(contact));
    const auto F = inputs_like(trace, 0, step_F_), G = inputs_like(trace, 1, step_G_);
    const auto respond = [&](const SparseRowOf<Traced>& row, int array, List& x, List& lambda) {
      response(saddle, G, F, row, x, lambda);
      trace.outputs(array, x);
      trace.outputs(array + 1, lambda);
    };
    const auto normal = row_of(trace, sample.normal, 2), tangent = row_of(trace, sample.tangent, 3);
    respond(normal, 0, a, a_reaction);
    trace.output(4, 0, normal.dot(a.data()));
    if (tangent.size > 0) {
      respond(tangent, 2, b, b_reaction);
      trace.output(4, 1, tangent.dot(a.data()));
      trace.output(4, 2, tangent.dot(b.data()));
    }
  }
  Trace trace(object, "step_push_" + std::to_string(contact));
  const auto P = trace.inputs(0, std::vector<double>(2, 1));
  a = inputs_like(trace, 1, a);
  a_reaction = inputs_like(trace, 2, a_reaction);
  b = inputs_like(trace, 3, b);
  b_reaction = inputs_like(trace, 4, b_reaction);
  const auto normal = row_of(trace, sample.normal, 5), tangent = row_of(trace, sample.tangent, 6);
  auto v = trace.inputs(7, at_.v), lambda = trace.inputs(8, std::vector<double>(m, 1)),
       f = trace.inputs(9, std::vector<double>(n, 1));
  const auto v_old = trace.inputs(10, at_.v);
  const auto put = [&](int array, const List& before, const List& x) {
    for (std::size_t i = 0; i < x.size(); ++i)
      if (x[i].node != before[i].node) trace.output(array, static_cast<int>(i), x[i]);
  };
  const auto v_before = v, lambda_before = lambda, f_before = f;
  for (std::size_t i = 0; i < n; ++i) v[i] = v[i] + P[0] * a[i] + P[1] * b[i];
  for (std::size_t k = 0; k < m; ++k) lambda[k] = lambda[k] + P[0] * a_reaction[k] + P[1] * b_reaction[k];
  normal.add_to(f.data(), P[0]);
  tangent.add_to(f.data(), P[1]);
  put(0, v_before, v);
  put(1, lambda_before, lambda);
  put(2, f_before, f);
  List mean(n);
  for (std::size_t i = 0; i < n; ++i) mean[i] = 0.5 * (v_old[i] + v[i]);
  trace.outputs(3, List{normal.dot(v.data()), tangent.dot(v.data()), normal.dot(mean.data()),
                        tangent.dot(mean.data())});
}

}  // namespace freeplay
