#include "formulations/time_stepping/step_kernel.hpp"

#include <algorithm>

#include "dynamics/system_functions.hpp"
#include "formulations/time_stepping/contact_set.hpp"

namespace freeplay {
namespace {

void take_row(SparseRow& row, const SparseRow& pattern, const double* values) {
  if (row.size != pattern.size) {  // no row at concentric journals
    row.size = pattern.size;
    row.column = pattern.column;
  }
  std::copy_n(values, row.size, row.value.begin());
}

}  // namespace

/// Gives the arrays of the step to the functions.
bool StepKernel::connect(StepData& s, ContactSet& contacts) {
  using enum LaneArray;
  const auto& f = s.system.compiled().functions();
  step_ = nullptr;
  contacts_ = contacts.all().data();
  object_ = f.object.get();
  const auto room = s.saddle.compiled_room();
  if (!room.usable) return false;  // rows are eliminated otherwise
  LaneFunctions sizes;
  sizes.ratios = f.solve.ratios;
  auto& e = s.middle;
  auto& works = s.totals.integrals;
  table_ = {};
  at(q_middle) = s.q_mid.data();
  at(cosine) = e.cosine.data();
  at(sine) = e.sine.data();
  at(phi_t) = e.phi_t.data();
  at(G) = e.G.data();
  at(gamma) = e.gamma.data();
  at(factors) = room.factors;
  at(ratios) = room.ratios;
  at(momentum) = s.force.data();
  at(lambda) = s.lambda.data();
  at(q_free) = s.dq.data();
  at(LaneArray::v_mean) = s.v_mean.data();
  at(drive) = &works.drive;
  at(stabilisation) = &works.stabilisation;
  std::size_t all = 0;
  const auto own = [&](auto take) {
    for (std::size_t i = 0; i < table_.size(); ++i)
      if (!table_[i]) take(table_[i], sizes.size(static_cast<LaneArray>(i), s.system));
  };
  own([&](double*, int size) { all += static_cast<std::size_t>(size); });
  room_.assign(all, 0);
  double* next = room_.data();
  own([&](double*& array, int size) {
    array = next;
    next += size;
  });
  step_ = &s;
  return true;
}

bool StepKernel::middle(StepData& s, ContactSet& contacts) {
  using enum LaneArray;
  auto& f = s.system.compiled().functions();
  if (f.steps.empty()) return false;
  if (object_ == f.object.get() && contacts_ == contacts.all().data() && (!step_ || step_ == &s)) {
    if (!step_) return false;
  } else if (!connect(s, contacts)) {
    return false;
  }
  const auto room = s.saddle.compiled_room();
  std::fill(room.ratios, room.ratios + room.ratio_count, 1.0);
  *at(h) = s.length();
  *at(t_middle) = s.t_old + 0.5 * s.length();
  *at(t_end) = s.t;
  at(q_old) = s.q_old.data();
  at(v_old) = s.v_old.data();
  at(q) = s.q.data();
  at(v) = s.v.data();
  if (!f.call(f.steps[0], table_.data(), table_.data())) return false;
  std::ranges::copy(s.middle.G, room.G);
  for (std::size_t k = 0; k < contacts.all().size(); ++k) {
    auto& row = contacts[static_cast<int>(k)].row;
    const auto& pattern = f.contacts[k].pattern;
    const auto first = SparseRow::max_size * k;
    row.gap = at(middle_gap)[k];
    row.gamma_n = at(gamma_n)[k];
    row.gamma_t = at(gamma_t)[k];
    take_row(row.normal, pattern.normal, at(normal) + first);
    take_row(row.tangent, pattern.tangent, at(tangent) + first);
  }
  s.saddle.take_compiled();
  return true;
}

bool StepKernel::end(StepData& s, ContactSet& contacts) {
  using enum LaneArray;
  auto& f = s.system.compiled().functions();
  auto& extremes = s.totals.extremes;
  double* sums = at(totals);
  sums[lane_constraint_length] = extremes.constraint_length;
  sums[lane_constraint_angle] = extremes.constraint_angle;
  if (!f.call(f.steps[1], table_.data(), table_.data())) return false;
  extremes.constraint_length = sums[lane_constraint_length];
  extremes.constraint_angle = sums[lane_constraint_angle];
  for (std::size_t k = 0; k < contacts.all().size(); ++k) contacts[static_cast<int>(k)].gap = at(gap)[k];
  return true;
}

}  // namespace freeplay
