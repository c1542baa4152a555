// Traces the functions of steps in lanes (lane_functions.hpp). The operations and their order are those
// of formulations/time_stepping and formulations/contact/solvers.cpp for the steps that lanes do.
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "dynamics/lane_closed_forms.hpp"
#include "dynamics/lane_functions.hpp"
#include "dynamics/system_functions.hpp"
#include "dynamics/system_tracer.hpp"

namespace freeplay {

void SystemTracer::lanes(TracedObject& object, const SaddlePoint& saddle) {
  step_middle(object, saddle);
  step_end(object, saddle);
  for (int k = 0; k < system_.contacts(); ++k) lanes_contact(object, saddle, k);
  for (int k = 0; k < system_.contacts(); ++k) lanes_open(object, saddle, k);
  if (system_.frictions() > 0) lanes_slide(object, saddle);
}

void SystemTracer::lanes_middle(Trace& trace, const Traced& h, const List& ratios, const List& v) {
  const int after = 12 + 6 * system_.contacts();
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& row = step_rows_[static_cast<std::size_t>(k)];
    trace.output(after, k, row.gap + 0.5 * h * (row.normal.dot(v.data()) - 0.25 * h * row.gamma_n));
  }
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    const int at = static_cast<int>(i);
    trace.output(after + 1, at, least(trace.input(4, at, 1), ratios[i]));
  }
  put_row(trace, after + 2, step_slide_);
  if (step_slide_.size > 0) trace.output(after + 3, 0, step_slide_gamma_);
}

std::optional<SystemTracer::Slide> SystemTracer::slide_of(Trace& trace, int array, const Traced& h,
                                                          const SaddlePoint& saddle, const List& G,
                                                          const List& F) const {
  if (system_.frictions() == 0) return {};
  Slide s;
  s.row = step_slide_;
  s.last = trace.input(array + 2, 0, 1);
  for (int i = 0; i < s.row.size; ++i)
    if (auto& x = s.row.value[i]; !x.is_constant()) x = trace.input(array, i, x.value);
  const auto gamma = step_slide_gamma_.is_constant() ? step_slide_gamma_
                                                     : trace.input(array + 1, 0, step_slide_gamma_.value);
  s.bias = -0.5 * h * gamma;
  s.bound = h * system_.friction_facts(0).bound;
  s.response.resize(static_cast<std::size_t>(system_.n()));
  s.reaction.resize(static_cast<std::size_t>(system_.rows()));
  response(saddle, G, F, s.row, s.response, s.reaction);
  return s;
}

/// The gap of a contact at the end with velocities v. Its arrays: gaps, normal rows, γ_n of all contacts.
Traced SystemTracer::reach_of(Trace& trace, int contact, int gaps, const Traced& h, const List& v) const {
  const auto& pattern = step_rows_[static_cast<std::size_t>(contact)].normal;
  const auto of_all = [&](int array, int k) { return trace.input(array, k, 1); };
  Traced rate;
  for (int i = 0; i < pattern.size; ++i)
    rate +=
        of_all(gaps + 1, SparseRow::max_size * contact + i) * v[static_cast<std::size_t>(pattern.column[i])];
  return of_all(gaps, contact) + 0.5 * h * (rate - 0.25 * h * of_all(6, contact));
}

void SystemTracer::lanes_slide(TracedObject& object, const SaddlePoint& saddle) {
  const auto n = static_cast<std::size_t>(system_.n()), m = static_cast<std::size_t>(system_.rows());
  Trace trace(object, "lanes_slide");
  const auto h = trace.input(0, 0, 1e-5);
  const auto F = inputs_like(trace, 1, step_F_), G = inputs_like(trace, 2, step_G_);
  const auto slide = slide_of(trace, 3, h, saddle, G, F);
  const auto lambda = trace.inputs(11, std::vector<double>(m, 1));
  auto v = trace.inputs(10, at_.v), f = trace.inputs(12, std::vector<double>(n, 1));
  const auto v_old = trace.inputs(13, at_.v);
  const auto asked = less(0, trace.input(14, 0, 1)), tolerance = trace.input(15, 0, 1e-10);
  const auto totals = trace.inputs(16, std::vector<double>(lane_total_size, 1));
  const auto s = sliding(slide->row.dot(slide->response.data()), slide->row.dot(v.data()) + slide->bias,
                         slide->bound, tolerance);
  for (const auto& condition : s.conditions) trace.require(condition);
  const auto v_free = v;
  for (std::size_t i = 0; i < n; ++i) v[i] += s.slide * slide->response[i];
  Traced alone = asked;
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto reach = reach_of(trace, k, 7, h, v);
    trace.output(5, k, reach);
    alone = both(alone, less(0, reach));
  }
  const auto put = [&](int array, int i, const Traced& condition, const Traced& x, const Traced& before) {
    if (x.node != before.node) trace.output(array, i, select(condition, x, before));
  };
  List mean(n);
  for (std::size_t i = 0; i < n; ++i) {
    put(0, static_cast<int>(i), alone, v[i], v_free[i]);
    mean[i] = 0.5 * (v_old[i] + v[i]);
  }
  for (std::size_t k = 0; k < m; ++k)
    put(1, static_cast<int>(k), alone, lambda[k] + s.slide * slide->reaction[k], lambda[k]);
  const auto force = f;
  slide->row.add_to(f.data(), s.slide);
  for (std::size_t i = 0; i < n; ++i) put(2, static_cast<int>(i), alone, f[i], force[i]);
  const auto& loss = totals[lane_friction_loss];
  put(3, lane_friction_loss, alone, loss - s.slide * slide->row.dot(mean.data()), loss);
  for (const auto& [which, x] :
       {std::pair{lane_lcp_residual, s.residual}, {lane_lcp_residual_rate, s.residual_rate}})
    put(3, which, asked, max(totals[which], x), totals[which]);
  put(4, 0, alone, s.slide, slide->last);
}

void SystemTracer::lanes_contact(TracedObject& object, const SaddlePoint& saddle, int contact) {
  const auto& sample = step_rows_[static_cast<std::size_t>(contact)];
  const auto n = static_cast<std::size_t>(system_.n()), m = static_cast<std::size_t>(system_.rows());
  Trace trace(object, "lanes_contact_" + std::to_string(contact));
  const auto h = trace.input(0, 0, 1e-5);
  const auto F = inputs_like(trace, 1, step_F_), G = inputs_like(trace, 2, step_G_);
  const auto normal = row_of(trace, sample.normal, 3), tangent = row_of(trace, sample.tangent, 4);
  const bool rubs = tangent.size > 0;
  const auto rates = trace.inputs(5, std::vector<double>(3, 1));  // normal and tangential at v, normal at v₀
  const auto of_all = [&](int array, int k) { return trace.input(array, k, 1); };
  auto v = trace.inputs(10, at_.v), lambda = trace.inputs(11, std::vector<double>(m, 1)),
       f = trace.inputs(12, std::vector<double>(n, 1));
  const auto v_old = trace.inputs(13, at_.v);
  const auto acts = less(0, trace.input(14, 0, 1));
  const auto restitution = trace.input(15, 0, 0.5), tolerance = trace.input(15, 1, 1e-10);
  const auto record = trace.inputs(16, std::vector<double>(lane_record_size, 1)),
             totals = trace.inputs(17, std::vector<double>(lane_total_size, 1));

  List a(n), a_reaction(m), b(n), b_reaction(m);
  response(saddle, G, F, normal, a, a_reaction);
  const Traced nn = normal.dot(a.data());
  std::array<Traced, 3> D{nn, 0, 0};
  if (rubs) {
    D[1] = tangent.dot(a.data());
    response(saddle, G, F, tangent, b, b_reaction);
    D[2] = tangent.dot(b.data());
  }
  const Traced bias_n = 0.5 * h * of_all(6, contact), bias_t = 0.5 * h * of_all(7, contact);
  const Traced u_n_minus = rates[2] + bias_n, target = -restitution * u_n_minus;
  const Traced bn = rates[0] + -bias_n;
  const auto& facts = system_.contact_facts(contact).surface;
  const auto slide = slide_of(trace, 18, h, saddle, G, F);
  LaneImpulses s;
  if (slide) {
    const auto& row = slide->row;
    LaneMode mode{.nn = nn,
                  .nt = D[1],
                  .tt = D[2],
                  .ns = row.dot(a.data()),
                  .ts = row.dot(b.data()),
                  .ss = row.dot(slide->response.data()),
                  .bn = bn,
                  .bt = rubs ? rates[1] + -bias_t : Traced(0),
                  .bs = row.dot(v.data()) + slide->bias,
                  .friction = {},
                  .target = target,
                  .bound = slide->bound,
                  .last_n = record[lane_last_n],
                  .last_t = record[lane_last_t],
                  .last_s = slide->last};
    if (rubs) mode.friction = *facts.friction;
    s = with_slide(mode, tolerance);
  } else {
    s = rubs ? with_friction(D, bn, rates[1] + -bias_t, target, *facts.friction, tolerance)
             : frictionless(nn, bn, target, tolerance);
  }
  for (const auto& condition : s.conditions) trace.require(condition);

  const auto put = [&](int array, const List& before, const List& x) {
    for (std::size_t i = 0; i < x.size(); ++i)
      if (x[i].node != before[i].node)
        trace.output(array, static_cast<int>(i), select(acts, x[i], before[i]));
  };
  const auto v_before = v, lambda_before = lambda, f_before = f;
  for (std::size_t i = 0; i < n; ++i) v[i] = v[i] + s.normal * a[i] + s.tangent * b[i];
  for (std::size_t k = 0; k < m; ++k)
    lambda[k] = lambda[k] + s.normal * a_reaction[k] + s.tangent * b_reaction[k];
  normal.add_to(f.data(), s.normal);
  tangent.add_to(f.data(), s.tangent);
  if (slide) {
    for (std::size_t i = 0; i < n; ++i) v[i] += s.slide * slide->response[i];
    for (std::size_t k = 0; k < m; ++k) lambda[k] += s.slide * slide->reaction[k];
    slide->row.add_to(f.data(), s.slide);
  }
  put(0, v_before, v);
  put(1, lambda_before, lambda);
  put(2, f_before, f);
  List mean(n);
  for (std::size_t i = 0; i < n; ++i) mean[i] = 0.5 * (v_old[i] + v[i]);

  // No other contact may act then.
  for (int k = 0; k < system_.contacts(); ++k)
    if (k != contact) trace.require(less(0, reach_of(trace, k, 8, h, v)));

  auto now = record, sums = totals;
  now[lane_impulse_n] += s.normal;
  now[lane_last_n] = s.normal;
  now[lane_u_n_minus] = u_n_minus;
  now[lane_u_n_plus] = normal.dot(v.data()) - bias_n;
  now[lane_bias_n] = bias_n;
  now[lane_bias_t] = bias_t;
  sums[lane_contact_loss] -= s.normal * normal.dot(mean.data());
  if (rubs) {
    now[lane_impulse_t] += s.tangent;
    now[lane_last_t] = s.tangent;
    now[lane_u_t_plus] = tangent.dot(v.data()) - bias_t;
    sums[lane_friction_loss] -= s.tangent * tangent.dot(mean.data());
  }
  if (slide) {
    sums[lane_friction_loss] -= s.slide * slide->row.dot(mean.data());
    trace.output(5, 0, select(acts, s.slide, slide->last));
  }
  sums[lane_lcp_residual] = max(sums[lane_lcp_residual], s.residual);
  sums[lane_lcp_residual_rate] = max(sums[lane_lcp_residual_rate], s.residual_rate);
  put(3, record, now);
  put(4, totals, sums);
}

void SystemTracer::lanes_end(Trace& trace, const List& q, const List& v, const Traced& drive,
                             const Traced& sum, const EvaluationOf<Traced>& e) {
  Traced open(1);
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto gap = gap_at(k, q, e);
    trace.output(8 + k, 0, gap);
    open = both(open, at_most(0, gap));
  }
  trace.require(holds(zero_if_finite(sum), Relation::equal, 0));
  const auto totals = trace.inputs(14, std::vector<double>(lane_total_size, 1));
  const int array = 8 + system_.contacts();
  const auto worst = residuals(e);
  for (const int i : {0, 1}) {
    const auto& most = totals[lane_constraint_length + i];
    trace.output(array, lane_constraint_length + i, select(open, max(most, worst[i]), most));
  }
  Traced kinetic;
  for (std::size_t i = 0; i < v.size(); ++i) kinetic += Traced(0.5 * system_.mass()[i]) * v[i] * v[i];
  trace.output(array, lane_passed, max(max(totals[lane_passed], kinetic), abs(drive)));
}

Traced SystemTracer::gap_at(int contact, const List& q, const EvaluationOf<Traced>& e) const {
  const List rest(q.size());
  ContactRowOf<Traced> row;
  system_.contact(contact, q.data(), rest.data(), e, row);
  return row.gap;
}

/// PositionCorrection::open_gaps() of the contact that acts.
void SystemTracer::lanes_open(TracedObject& object, const SaddlePoint& saddle, int contact) {
  const auto& sample = step_rows_[static_cast<std::size_t>(contact)];
  Trace trace(object, "lanes_open_" + std::to_string(contact));
  const auto t = trace.input(0, 0, at_.t);
  const auto middle = known_coordinates(trace, 1, at_.q, true);
  auto from = system_.make_evaluation<Traced>(), e = from;
  orient(trace, 2, from);
  const auto F = inputs_like(trace, 4, step_F_), G = inputs_like(trace, 5, step_G_);
  const auto normal = row_of(trace, sample.normal, 6);
  const auto q_before = known_coordinates(trace, 7, at_.q, true);
  const auto gap = trace.input(8, contact, -1e-12);
  const auto opens = less(0, trace.input(9, 0, 1));
  const auto totals = trace.inputs(10, std::vector<double>(lane_total_size, 1));
  const auto deepest = trace.input(11, lane_penetration, 0), tolerance = trace.input(12, 1, 1e-10);
  List a, ignored;
  response(saddle, G, F, normal, a, ignored);
  const Traced D = normal.dot(a.data()), P = -gap / D;
  trace.require(both(less(0, P), less(0, D)));
  const Traced x = least(abs(D) * P, gap + D * P);
  trace.require(at_most(max(0, abs(x)), tolerance * abs(gap)));
  auto q = q_before;
  for (std::size_t i = 0; i < q.size(); ++i) q[i] += P * a[i];
  system_.place_near(t, q.data(), middle.data(), from, e);
  for (std::size_t i = 0; i < q.size(); ++i)
    if (q[i].node != q_before[i].node) trace.output(0, static_cast<int>(i), select(opens, q[i], q_before[i]));
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto now = gap_at(k, q, e);
    trace.output(1, k, select(opens, now, trace.input(8, k, 1)));
    if (k == contact)
      trace.output(3, lane_penetration, select(opens, max(deepest, -now), deepest));
    else
      trace.require(at_most(0, now));
  }
  const auto worst = residuals(e);
  for (const int i : {0, 1}) {
    const auto& most = totals[lane_constraint_length + i];
    trace.output(2, lane_constraint_length + i, select(opens, max(most, worst[i]), most));
  }
}

LaneFunctions TracedLanes::functions(std::vector<LaneFunction> list) const {
  LaneFunctions f;
  f.lanes = object.lanes();
  f.factors = factors;
  f.ratios = ratios;
  const auto contacts = list.begin() + 2, opens = contacts + (list.end() - contacts) / 2,
             end = list.end() - (list.end() - contacts) % 2;
  f.middle = list[0];
  f.end = list[1];
  f.contacts.assign(contacts, opens);
  f.opens.assign(opens, end);
  f.slides.assign(end, list.end());
  return f;
}

LaneFunctions TracedLanes::compiled(const CompiledFunction* table) const {
  std::vector<LaneFunction> list;
  for (int i = 0; i < object.functions(); ++i) list.emplace_back(table[i]);
  return functions(std::move(list));
}

LaneFunctions TracedLanes::evaluated(int lanes) const {
  std::vector<LaneFunction> list;
  for (int i = 0; i < object.functions(); ++i)
    list.emplace_back(std::make_shared<LaneTape>(object.function(i), lanes));
  auto f = functions(std::move(list));
  f.lanes = lanes;
  return f;
}

TracedLanes trace_lanes(const System& system, const State& near, RowFacts facts, int lanes,
                        const TracedLanes* like) {
  TracedLanes found;
  found.object = TracedObject(lanes, like ? &like->object : nullptr);
  found.place = TracedObject(0, like ? &like->place : nullptr);
  if (facts.redundant || !SystemTracer::steps(system) || SystemTracer::iterates(system) ||
      system.has_loads() || system.frictions() > 1)
    return found;
  const SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic, facts);
  if (!saddle.dense()) return found;
  try {
    SystemTracer tracer(system, near, 1e-6);
    tracer.place(found.place);
    tracer.lanes(found.object, saddle);
    found.factors = tracer.lane_factors();
    found.ratios = tracer.lane_ratios();
    found.traced = true;
  } catch (const NotTraceable&) {
    found.traced = false;
  }
  return found;
}

int lanes_of_machine() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx512f") ? 8 : 4;
#else
  return 4;
#endif
}

}  // namespace freeplay
