#include "tables.hpp"

namespace freeplay::python {
namespace {

std::vector<std::string> names_of(const std::vector<Column>& columns) {
  std::vector<std::string> names;
  for (const auto& c : columns) names.push_back(c.name());
  return names;
}

}  // namespace

void Words::add(const std::string& word) {
  const auto [at, fresh] = known_.emplace(word, static_cast<std::int32_t>(names.size()));
  if (fresh) names.push_back(word);
  codes.push_back(at->second);
}

void TrajectoryTable::begin(const Layout& layout, const State& state) {
  table.names = names_of(trajectory_columns(layout));
  rows_.begin(layout, state, true, *this);
}

void ForcesTable::begin(const Layout& layout, const State& state) {
  table.names = names_of(force_columns(layout));
  rows_.begin(layout, state, true);
}

void EventsTable::event(const Event& e) {
  joint.add(e.joint);
  kind.add(name_of(e.kind));
  const double row[] = {e.t,        e.crank_angle, e.v_n_minus, e.v_n_plus, e.v_t_minus,
                        e.v_t_plus, e.impulse_n,   e.impulse_t, e.duration, e.t_uncertainty};
  table.add(row);
}

void SignalsTable::begin(const Layout& layout, const State&) {
  names_ = layout.channels;
  crank_start_ = layout.crank_start;
  crank_speed_ = layout.crank_speed;
}

void SignalsTable::sample(std::size_t which, double t, double value) {
  channel.add(names_[which]);
  const double row[] = {t, crank_start_ + crank_speed_ * t, value};
  table.add(row);
}

}  // namespace freeplay::python
