#include "formulations/time_stepping/step_data.hpp"

#include <algorithm>

#include "dynamics/system_functions.hpp"
#include "formulations/time_stepping/contact_set.hpp"

namespace freeplay {
namespace {

void take_shape(SparseRow& row, const SparseRow& pattern) {
  if (row.size == pattern.size) return;  // the columns of a pair never change
  row.size = pattern.size;
  row.column = pattern.column;
}

}  // namespace

/// Collects the arguments; step_ stays null if rows are eliminated otherwise.
void StepKernel::prepare(StepData& s, ContactSet& contacts) {
  const auto& f = s.system.compiled().functions();
  step_ = nullptr;
  const auto room = s.saddle.compiled_room();
  if (!room.usable) return;
  step_ = &s;
  contacts_ = contacts.all().data();
  functions_ = f.object.get();
  auto& e = s.middle;
  std::ranges::copy(e.G, room.G);  // the functions write entries that are not constant
  rates_.resize(contacts.all().size());
  auto& works = s.totals.integrals;
  middle_out_ = {s.q_mid.data(), e.cosine.data(), e.sine.data(),   e.phi_t.data(),
                 e.G.data(),     e.gamma.data(),  room.factors,    room.ratios,
                 s.force.data(), nullptr,         s.lambda.data(), room.G};
  end_in_ = {&s.t,
             &h_,
             s.q_mid.data(),
             nullptr,
             nullptr,
             s.lambda.data(),
             s.force.data(),
             e.phi_t.data(),
             e.G.data(),
             room.factors,
             e.cosine.data(),
             e.sine.data(),
             &works.drive,
             &works.stabilisation};
  end_out_ = {s.dq.data(),       nullptr,      s.lambda.data(),
              s.v_mean.data(),   &works.drive, &works.stabilisation,
              residuals_.data(), &sum_};
  reached_out_ = {residuals_.data()};
  for (std::size_t k = 0; k < rates_.size(); ++k) {
    auto& c = contacts.all()[k];
    for (double* x : {&c.row.gap, c.row.normal.value.data(), c.row.tangent.value.data(), &c.row.gamma_n,
                      &c.row.gamma_t, &rates_[k].normal})
      middle_out_.push_back(x);
    end_out_.push_back(&c.gap);
    reached_out_.push_back(&c.gap);
  }
  middle_out_.push_back(e.force.data());
}

bool StepKernel::middle(StepData& s, ContactSet& contacts) {
  auto& f = s.system.compiled().functions();
  if (!f.step.middle) return false;
  if (step_ != &s || contacts_ != contacts.all().data() || functions_ != f.object.get()) {
    prepare(s, contacts);
    if (!step_) return false;
  }
  pushed_ = -1;
  h_ = s.length();
  const double t = s.t_old + 0.5 * h_;
  const double* in[] = {&t, &h_, s.q_old.data(), s.v_old.data()};
  middle_out_[9] = s.v.data();
  if (!f.call(f.step.middle, in, middle_out_.data())) return false;
  for (std::size_t k = 0; k < rates_.size(); ++k) {
    auto& row = contacts[static_cast<int>(k)].row;
    const auto& pattern = f.contacts[k].pattern;
    take_shape(row.normal, pattern.normal);
    take_shape(row.tangent, pattern.tangent);
  }
  s.saddle.take_compiled();
  return true;
}

bool StepKernel::again(StepData& s, const ContactSet& contacts, const double* v_mean) {
  auto& f = s.system.compiled().functions();
  pushed_ = -1;
  const double t = s.t_old + 0.5 * h_;
  auto& e = s.middle;
  std::array<const double*, 11 + 2 * most_step_contacts> in{
      &t,         &h_,        s.q_mid.data(), s.v_old.data(),  v_mean,       e.phi_t.data(),
      e.G.data(), end_in_[9], e.gamma.data(), e.cosine.data(), e.sine.data()};
  std::array<double*, 4 + most_step_contacts> out{e.force.data(), s.force.data(), s.v.data(),
                                                  s.lambda.data()};
  for (std::size_t k = 0; k < rates_.size(); ++k) {
    const auto& row = contacts[static_cast<int>(k)].row;
    in[11 + 2 * k] = row.normal.value.data();
    in[12 + 2 * k] = row.tangent.value.data();
    out[4 + k] = &rates_[k].normal;
  }
  return f.call(f.step.again, in.data(), out.data());
}

const double* StepKernel::respond(const StepData& s, int contact, const Response& at) {
  const auto& f = s.system.compiled().functions();
  const double* in[] = {end_in_[9], end_in_[8], at.normal, at.tangent};
  double* out[] = {at.a_n, at.lambda_n, at.a_t, at.lambda_t, D_.data()};
  if (f.step.responses[static_cast<std::size_t>(contact)](f.solve.constants, in, out) != 0) return nullptr;
  return D_.data();
}

void StepKernel::push(StepData& s, int contact, const double* impulses, const Response& at) {
  const auto& f = s.system.compiled().functions();
  double *v = s.v.data(), *lambda = s.lambda.data(), *force = s.force.data();
  const double* in[] = {impulses,   at.a_n, at.lambda_n, at.a_t, at.lambda_t,   at.normal,
                        at.tangent, v,      lambda,      force,  s.v_old.data()};
  double* out[] = {v, lambda, force, &pushed_rates_.normal};
  f.step.pushes[static_cast<std::size_t>(contact)](f.solve.constants, in, out);
  pushed_ = contact;
}

bool StepKernel::end(StepData& s) {
  auto& f = s.system.compiled().functions();
  end_in_[3] = s.v_old.data();
  end_in_[4] = s.v.data();
  end_out_[1] = s.q.data();
  return f.call(f.step.end, end_in_.data(), end_out_.data());
}

bool StepKernel::reached(StepData& s) {
  auto& f = s.system.compiled().functions();
  const double* in[] = {&s.t, s.q.data(), s.q_mid.data(), s.middle.cosine.data(), s.middle.sine.data()};
  if (!f.call(f.step.reached, in, reached_out_.data())) return false;
  for (const double x : s.q) sum_ += x - x;
  return true;
}

StepData::StepData(const System& system, RowFacts facts)
    : system(system),
      saddle(system.mass(), system.pattern(), SolvePath::automatic, facts),
      middle(system.make_evaluation()),
      end(system.make_evaluation()) {
  saddle.use(system.compiled().solve());
  for (auto* x : {&q, &v, &q_old, &v_old, &q_mid, &v_mean, &force, &dq}) x->resize(system.n());
  for (auto* x : {&z, &z_old, &z_mid}) x->resize(system.states());
  for (auto* x : {&lambda, &r, &dlambda}) x->resize(system.rows());
  totals.extremes.penetration.assign(system.reported(), 0);
}

}  // namespace freeplay
