// Traces the functions of steps in lanes (lane_functions.hpp).
#include <string>
#include <utility>
#include <vector>

#include "formulations/time_stepping/lane_impulses.hpp"
#include "formulations/time_stepping/lane_tracer.hpp"

namespace freeplay {
namespace {

constexpr int row_size = SparseRow::max_size;

}  // namespace

void LaneTracer::middle() {
  Function f(object_, "middle");
  const auto& at = tracer_.at();
  const auto t = f.in(t_middle, 0, at.t), h = f.in(LaneArray::h, 0, 1e-5);
  const auto q0 = tracer_.coordinates(f.trace, static_cast<int>(q_old), true),
             v0 = tracer_.coordinates(f.trace, static_cast<int>(v_old), false);
  List q_m(n()), sum(n()), r(m()), all_ratios, a, reactions;
  half_step(n(), h, q0.data(), v0.data(), q_m.data());
  const auto fresh = system_.make_evaluation<Traced>();
  auto e = fresh;
  system_.place(t, q_m.data(), e);
  system_.rate(q_m.data(), v0.data(), e);
  F_ = saddle_.trace_factors(e.G, all_ratios, ratios_);
  const SweepOf<Traced> sweep{h, v0.data(), v0.data()};
  system_.forces<Traced>(t, q_m.data(), v0.data(), nullptr, e, {&sweep});
  const MidpointTermsOf<Traced> terms{system_.n(),    system_.rows(), system_.mass().data(),
                                      e.force.data(), e.phi_t.data(), e.gamma.data()};
  terms.sides(h, v0.data(), sum.data(), r.data());
  saddle_.trace_solution(e.G, F_, sum, r, a, reactions);
  f.out(q_middle, q_m);
  f.out(cosine, e.cosine);
  f.out(sine, e.sine);
  const auto put_changed = [&](LaneArray array, const List& x, const List& before) {
    SystemTracer::put_changed(f.trace, static_cast<int>(array), x, before);
  };
  put_changed(phi_t, e.phi_t, fresh.phi_t);
  put_changed(G, e.G, fresh.G);
  put_changed(gamma, e.gamma, fresh.gamma);
  put_changed(factors, F_, List(F_.size()));
  f.out(momentum, sum);
  f.out(v, a);
  f.out(lambda, reactions);
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& row = rows_.emplace_back();
    system_.contact(k, q_m.data(), v0.data(), e, row);
    f.out(middle_gap, k, row.gap);
    f.out(normal, row.normal, row_size * k);
    f.out(tangent, row.tangent, row_size * k);
    f.out(gamma_n, k, row.gamma_n);
    f.out(gamma_t, k, row.gamma_t);
    const Traced rate = row.normal.dot(a.data());
    f.out(rates, List{rate, row.tangent.dot(a.data()), row.normal.dot(v0.data())}, lane_rate_size * k);
    f.out(reach, k, gap_at_end(row, rate, h));
  }
  for (std::size_t i = 0; i < all_ratios.size(); ++i) {
    const int place = static_cast<int>(i);
    f.out(LaneArray::ratios, place, least(f.in(LaneArray::ratios, place), all_ratios[i]));
  }
  if (ordinary_ && system_.frictions() > 0) {
    slide_gamma_ = system_.friction(0, q_m.data(), v0.data(), e, slide_row_);
    f.out(LaneArray::slide_row, slide_row_);
    f.out(slide_gamma, 0, slide_gamma_);
  }
  G_ = e.G;
  phi_t_ = e.phi_t;
}

std::optional<LaneTracer::Slide> LaneTracer::slide_of(Function& f, const Traced& h, const List& G,
                                                      const List& F) const {
  if (system_.frictions() == 0) return {};
  Slide s;
  s.row = slide_row_;
  for (int i = 0; i < s.row.size; ++i)
    if (auto& x = s.row.value[i]; !x.is_constant()) x = f.in(LaneArray::slide_row, i, x.value);
  const auto gamma =
      slide_gamma_.is_constant() ? slide_gamma_ : f.in(LaneArray::slide_gamma, 0, slide_gamma_.value);
  s.last = f.in(slide_impulse);
  s.bias = -rate_bias(gamma, h);
  s.bound = h * system_.friction_facts(0).bound;
  respond(G, F, s.row, s.response, s.reaction);
  return s;
}

/// The gap of a contact at the end with velocities v.
Traced LaneTracer::reach_of(Function& f, int k, const Traced& h, const List& v) const {
  ContactRowOf<Traced> row;
  row.normal = f.row(normal, rows_[static_cast<std::size_t>(k)].normal, row_size * k);
  row.gap = f.in(middle_gap, k);
  row.gamma_n = f.in(gamma_n, k);
  return gap_at_end(row, row.normal.dot(v.data()), h);
}

void LaneTracer::slide() {
  Function f(object_, "slide");
  const auto h = f.in(LaneArray::h, 0, 1e-5);
  const auto F = like(f, factors, F_), G = like(f, LaneArray::G, G_);
  const auto s = *slide_of(f, h, G, F);
  const auto before = motion(f);
  const auto asked = is_below(0, f.in(slide_asked)), tolerance = f.in(LaneArray::tolerance, 0, 1e-10);
  const auto sums = f.list(totals, lane_total_size);
  const Traced D = s.row.dot(s.response.data()), b = s.row.dot(before.v.data()) + s.bias;
  const auto found = slide_alone(D, b, s.bound, tolerance);
  for (const auto& condition : found.conditions) f.trace.require(condition);
  auto now = before;
  add(now, found.slide, s.row, s.response, s.reaction);
  Traced alone = asked;
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto gap = reach_of(f, k, h, now.v);
    f.out(slide_reach, k, gap);
    alone = both(alone, is_below(0, gap));
  }
  change(f, alone, before, now);
  auto next = sums;
  next[lane_friction_loss] -= found.slide * s.row.dot(mean(now).data());
  f.out(totals, lane_friction_loss, select(alone, next[lane_friction_loss], sums[lane_friction_loss]));
  for (const auto& [which, x] :
       {std::pair{lane_lcp_residual, found.residual}, {lane_lcp_residual_rate, found.residual_rate}})
    f.out(totals, which, select(asked, max(sums[which], x), sums[which]));
  f.out(slide_impulse, 0, select(alone, found.slide, s.last));
}

void LaneTracer::contact(int k) {
  Function f(object_, "contact_" + std::to_string(k));
  const auto& sample = rows_[static_cast<std::size_t>(k)];
  const auto h = f.in(LaneArray::h, 0, 1e-5);
  const auto F = like(f, factors, F_), G = like(f, LaneArray::G, G_);
  const auto w = f.row(normal, sample.normal, row_size * k),
             w_t = f.row(tangent, sample.tangent, row_size * k);
  const bool rubs = w_t.size > 0;
  const auto at_v = f.list(rates, lane_rate_size, lane_rate_size * k);
  const auto before = motion(f);
  const auto where = is_below(0, f.in(acts, k));
  const auto e = f.in(restitution, k, 0.5), tolerance = f.in(LaneArray::tolerance, 0, 1e-10);
  const int first = lane_record_size * k;
  const auto old = f.list(record, lane_record_size, first), sums = f.list(totals, lane_total_size);

  List a, a_reaction, b, b_reaction;
  respond(G, F, w, a, a_reaction);
  const Traced bias_n = rate_bias(f.in(gamma_n, k), h), bias_t = rate_bias(f.in(gamma_t, k), h),
               u_n_minus = at_v[rate_n_old] + bias_n;
  SingleContact<Traced> c{.nn = w.dot(a.data()),
                          .nt = 0,
                          .tt = 0,
                          .bn = at_v[rate_n] + -bias_n,
                          .bt = 0,
                          .target_n = -e * u_n_minus};
  b.resize(n());
  b_reaction.resize(m());
  if (rubs) {
    c.nt = w_t.dot(a.data());
    respond(G, F, w_t, b, b_reaction);
    c.tt = w_t.dot(b.data());
    c.bt = at_v[rate_t] + -bias_t;
    c.friction = *system_.contact_facts(k).surface.friction;
  }
  const auto joint = slide_of(f, h, G, F);
  const auto found =
      !joint
          ? alone(c, rubs, tolerance)
          : with_slide(c, rubs,
                       {joint->row.dot(a.data()), joint->row.dot(b.data()),
                        joint->row.dot(joint->response.data()), joint->row.dot(before.v.data()) + joint->bias,
                        joint->bound, old[lane_last_n], old[lane_last_t], joint->last},
                       tolerance);
  for (const auto& condition : found.conditions) f.trace.require(condition);

  auto now = before;
  push(n(), found.normal, a.data(), found.tangent, b.data(), now.v.data());
  push(m(), found.normal, a_reaction.data(), found.tangent, b_reaction.data(), now.lambda.data());
  w.add_to(now.momentum.data(), found.normal);
  w_t.add_to(now.momentum.data(), found.tangent);
  if (joint) add(now, found.slide, joint->row, joint->response, joint->reaction);
  change(f, where, before, now);
  // No other contact may act then.
  for (int other = 0; other < system_.contacts(); ++other)
    if (other != k) f.trace.require(is_below(0, reach_of(f, other, h, now.v)));

  const auto mean_v = mean(now);
  auto next = old, total = sums;
  next[lane_impulse_n] += found.normal;
  next[lane_last_n] = found.normal;
  next[lane_u_n_minus] = u_n_minus;
  next[lane_u_n_plus] = w.dot(now.v.data()) - bias_n;
  next[lane_bias_n] = bias_n;
  next[lane_bias_t] = bias_t;
  total[lane_contact_loss] -= found.normal * w.dot(mean_v.data());
  if (rubs) {
    next[lane_impulse_t] += found.tangent;
    next[lane_last_t] = found.tangent;
    next[lane_u_t_plus] = w_t.dot(now.v.data()) - bias_t;
    total[lane_friction_loss] -= found.tangent * w_t.dot(mean_v.data());
  }
  if (joint) {
    total[lane_friction_loss] -= found.slide * joint->row.dot(mean_v.data());
    f.out(slide_impulse, 0, select(where, found.slide, joint->last));
  }
  total[lane_lcp_residual] = max(total[lane_lcp_residual], found.residual);
  total[lane_lcp_residual_rate] = max(total[lane_lcp_residual_rate], found.residual_rate);
  f.change(record, where, old, next, first);
  f.change(totals, where, sums, total);
}

void LaneTracer::put_residuals(Function& f, const Traced& where, const EvaluationOf<Traced>& e) const {
  List worst(2);
  for (std::size_t k = 0; k < e.phi.size(); ++k) {
    auto& x = worst[system_.is_angle_row(static_cast<int>(k)) ? 1 : 0];
    x = max(x, abs(e.phi[k]));
  }
  for (const int i : {0, 1}) {
    const auto most = f.in(totals, lane_constraint_length + i);
    f.out(totals, lane_constraint_length + i, select(where, max(most, worst[i]), most));
  }
}

void LaneTracer::end() {
  Function f(object_, "end");
  // A while after the start: the angle of a driven crank is not exactly 0.
  const auto t = f.in(t_end, 0, tracer_.at().t + 1e-6), h = f.in(LaneArray::h, 0, 1e-5);
  const auto q_m = coordinates(f, q_middle, true), v0 = coordinates(f, v_old, false);
  const auto v1 = tracer_.coordinates(f.trace, static_cast<int>(v), false);
  auto multipliers = f.list(lambda, system_.rows());
  const auto sum = f.list(momentum, system_.n());
  const auto driven = like(f, phi_t, phi_t_), G = like(f, LaneArray::G, G_), F = like(f, factors, F_);
  const auto from = oriented(f);
  saddle_.trace_finish(G, sum, v1, multipliers);
  List q1(n()), mean_v(n());
  half_step(n(), h, q_m.data(), v1.data(), q1.data());
  mean_of(n(), v0.data(), v1.data(), mean_v.data());
  auto work = f.in(drive, 0, 0), rest = f.in(stabilisation, 0, 0);
  for (int k = 0; k < system_.rows(); ++k) {
    const auto of = row_work(system_.pattern(), G.data(), k, mean_v.data(),
                             multipliers[static_cast<std::size_t>(k)], driven[static_cast<std::size_t>(k)]);
    work += of.driven;
    rest -= of.rest;
  }
  f.out(q_free, q1);
  auto e = system_.make_evaluation<Traced>();
  system_.place_near(t, q1.data(), q_m.data(), from, e);
  if (m() > 0) {
    List r(m()), dq, ignored;
    for (std::size_t k = 0; k < m(); ++k) r[k] = -e.phi[k];
    saddle_.trace_solution(G, F, List(n()), r, dq, ignored);
    for (std::size_t i = 0; i < n(); ++i) q1[i] += dq[i];
    system_.place_near(t, q1.data(), q_m.data(), from, e);
  }
  f.out(q, q1);
  f.out(lambda, multipliers);
  f.out(LaneArray::v_mean, mean_v);
  f.out(drive, 0, work);
  f.out(stabilisation, 0, rest);
  Traced finite, kinetic, open(1);
  for (std::size_t i = 0; i < n(); ++i) {
    finite += q1[i] + v1[i];
    kinetic += Traced(0.5 * system_.mass()[i]) * v1[i] * v1[i];
  }
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto gap_now = gap_at(k, q1, e);
    f.out(gap, k, gap_now);
    open = both(open, is_at_most(0, gap_now));
  }
  f.trace.require(is_equal(zero_if_finite(finite), 0));
  put_residuals(f, open, e);
  f.out(totals, lane_passed, max(max(f.in(totals, lane_passed), kinetic), abs(work)));
}

/// PositionCorrection::open_gaps() of the contact that acts.
void LaneTracer::open(int k) {
  Function f(object_, "open_" + std::to_string(k));
  const auto t = f.in(t_end, 0, tracer_.at().t);
  const auto q_m = coordinates(f, q_middle, true);
  const auto from = oriented(f);
  const auto F = like(f, factors, F_), G = like(f, LaneArray::G, G_);
  const auto w = f.row(normal, rows_[static_cast<std::size_t>(k)].normal, row_size * k);
  const auto before = coordinates(f, q, true);
  const auto depth = f.in(gap, k, -1e-12), where = is_below(0, f.in(opens, k)),
             tolerance = f.in(LaneArray::tolerance, 0, 1e-10);
  List a, ignored;
  respond(G, F, w, a, ignored);
  const Traced D = w.dot(a.data()), P = -depth / D;
  f.trace.require(both(is_below(0, P), is_below(0, D)));
  f.trace.require(is_at_most(max(0, abs(normal_residual(D, P, depth + D * P))), tolerance * abs(depth)));
  auto now = before;
  for (std::size_t i = 0; i < n(); ++i) now[i] += P * a[i];
  auto e = system_.make_evaluation<Traced>();
  system_.place_near(t, now.data(), q_m.data(), from, e);
  f.change(q, where, before, now);
  for (int i = 0; i < system_.contacts(); ++i) {
    const auto gap_now = gap_at(i, now, e);
    f.out(gap, i, select(where, gap_now, f.in(gap, i)));
    if (i == k) {
      const auto deepest = f.in(record, lane_record_size * k + lane_penetration, 0);
      f.out(record, lane_record_size * k + lane_penetration, select(where, max(deepest, -gap_now), deepest));
    } else {
      f.trace.require(is_at_most(0, gap_now));
    }
  }
  put_residuals(f, where, e);
}

TracedLanes trace_lanes(const System& system, const State& near, RowFacts facts, int lanes,
                        const TracedLanes* like) {
  TracedLanes found;
  found.object = TracedObject(lanes, like ? &like->object : nullptr);
  found.place = TracedObject(0, like ? &like->place : nullptr);
  found.contacts = system.contacts();
  if (facts.redundant || !has_ordinary_steps(system)) return found;
  const SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic, facts);
  if (!saddle.dense()) return found;
  try {
    const LaneTracer tracer(system, near, saddle, true, found.object, found.place);
    found.factors = tracer.factor_count();
    found.ratios = tracer.ratio_counts();
    found.traced = true;
  } catch (const NotTraceable&) {
  }
  return found;
}

int trace_steps(TracedObject& object, const System& system, const State& near, RowFacts facts) {
  if (!has_whole_steps(system)) return 0;
  const SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic, facts);
  for (const bool ordinary : {true, false}) {
    if (ordinary && !has_ordinary_steps(system)) continue;
    auto all = object;  // a part that cannot be traced leaves no other part behind
    TracedObject place(0, &object);
    try {
      const LaneTracer tracer(system, near, saddle, ordinary, all, place);
    } catch (const NotTraceable&) {
      continue;
    }
    const int count = all.functions() - object.functions();
    object = std::move(all);
    return count;
  }
  return 0;
}

}  // namespace freeplay
