#include "formulations/time_stepping/step_kernel.hpp"

#include "dynamics/system_functions.hpp"
#include "formulations/time_stepping/contact_set.hpp"
#include "formulations/time_stepping/step_data.hpp"

namespace freeplay {
namespace {

void take_shape(SparseRow& row, const SparseRow& pattern) {
  if (row.size == pattern.size) return;  // the columns of a pair never change
  row.size = pattern.size;
  row.column = pattern.column;
}

bool refuse(SystemFunctions& f) {
  ++f.refused;
  return false;
}

}  // namespace

bool StepKernel::middle(StepData& s, ContactSet& contacts) {
  auto& f = s.system.functions();
  if (!f.step.middle) return false;
  const auto room = s.saddle.compiled_room();
  if (!room.factors) return false;
  const double h = s.length(), t = s.t_old + 0.5 * h;
  auto& e = s.middle;
  const double* in[] = {&t, &h, s.q_old.data(), s.v_old.data()};
  const auto count = static_cast<std::size_t>(s.system.contacts());
  out_.resize(11 + 5 * count);
  double** out = out_.data();
  for (double* x : {s.q_mid.data(), e.cosine.data(), e.sine.data(), e.phi_t.data(), e.G.data(), e.gamma.data(),
                    room.factors, room.ratios, s.force.data(), s.v.data(), s.lambda.data()})
    *out++ = x;
  for (auto& c : contacts.all()) {
    *out++ = &c.row.gap;
    *out++ = c.row.normal.value.data();
    *out++ = c.row.tangent.value.data();
    *out++ = &c.row.gamma_n;
    *out++ = &c.row.gamma_t;
  }
  if (f.step.middle(f.solve.constants, in, out_.data()) != 0) return refuse(f);
  for (std::size_t k = 0; k < count; ++k) {
    auto& row = contacts[static_cast<int>(k)].row;
    const auto& pattern = f.contacts[k].pattern;
    take_shape(row.normal, pattern.normal);
    take_shape(row.tangent, pattern.tangent);
  }
  s.saddle.take_compiled(e.G.data());
  return true;
}

const double* StepKernel::respond(const StepData& s, int contact, const Response& at) {
  const auto& f = s.system.functions();
  const double* in[] = {s.saddle.compiled_factors(), s.middle.G.data(), at.normal, at.tangent};
  double* out[] = {at.a_n, at.lambda_n, at.a_t, at.lambda_t, D_};
  if (f.step.responses[static_cast<std::size_t>(contact)](f.solve.constants, in, out) != 0) return nullptr;
  return D_;
}

bool StepKernel::end(StepData& s, ContactSet& contacts) {
  auto& f = s.system.functions();
  const double h = s.length();
  auto& works = s.totals.integrals;
  const auto& e = s.middle;
  const double* in[] = {&s.t,
                        &h,
                        s.q_mid.data(),
                        s.v_old.data(),
                        s.v.data(),
                        s.lambda.data(),
                        s.force.data(),
                        e.phi_t.data(),
                        e.G.data(),
                        s.saddle.compiled_factors(),
                        e.cosine.data(),
                        e.sine.data(),
                        &works.drive,
                        &works.stabilisation};
  out_.clear();
  for (double* x : {s.dq.data(), s.q.data(), s.lambda.data(), s.v_mean.data(), &works.drive,
                    &works.stabilisation, s.end.phi.data()})
    out_.push_back(x);
  for (auto& c : contacts.all()) out_.push_back(&c.gap);
  return f.step.end(f.solve.constants, in, out_.data()) == 0 || refuse(f);
}

bool StepKernel::reached(StepData& s, ContactSet& contacts) {
  auto& f = s.system.functions();
  const double* in[] = {&s.t, s.q.data(), s.q_mid.data(), s.middle.cosine.data(), s.middle.sine.data()};
  out_.clear();
  out_.push_back(s.end.phi.data());
  for (auto& c : contacts.all()) out_.push_back(&c.gap);
  return f.step.reached(f.solve.constants, in, out_.data()) == 0 || refuse(f);
}

}  // namespace freeplay
