#include "simulation/table_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "dynamics/planar.hpp"
#include "mechanism/error.hpp"

namespace freeplay {

std::string Column::name() const {
  if (of == Of::time) return "t";
  return fmt::format("{}.{}{}", owner, part, of == Of::mean ? "_mean" : "");
}

void ColumnData::begin(const Layout& layout, const State& state) {
  q.resize(state.q.size());
  v.resize(state.v.size());
  contacts.resize(layout.contacts.size());
  now.elements.resize(layout.forces.size());
  now.acceleration.resize(state.v.size());
  sum = now;
}

double ColumnData::value(const Column& c, double t) const {
  switch (c.of) {
    case Column::Of::time:
      return t;
    case Column::Of::position:
      return q[c.index];
    case Column::Of::velocity:
      return v[c.index];
    case Column::Of::contact:
      return contacts[c.index].*c.place;
    case Column::Of::force:
      return now.elements[c.index].*c.force;
    case Column::Of::mean:
      return sum.elements[c.index].*c.force;
    case Column::Of::acceleration:
      return now.acceleration[c.index];
  }
  throw std::logic_error("no such kind of column");
}

void ColumnData::row(const std::vector<Column>& columns, double t, std::vector<double>& row) const {
  row.clear();
  for (const auto& c : columns) row.push_back(value(c, t));
}

ForceParts force_parts(ForceElement::Kind kind) {
  using F = ElementForce;
  switch (kind) {
    case ForceElement::Kind::joint:
      return {{{"fx", &F::fx}, {"fy", &F::fy}, {"m", &F::m}}, {{"fx", &F::fx}, {"fy", &F::fy}, {"m", &F::m}}};
    case ForceElement::Kind::contact:
      return {{{"fx", &F::fx}, {"fy", &F::fy}, {"fn", &F::fn}, {"ft", &F::ft}, {"m", &F::m}},
              {{"fx", &F::fx}, {"fy", &F::fy}, {"m", &F::m}}};
    case ForceElement::Kind::force:
      return {{{"fx", &F::fx}, {"fy", &F::fy}}, {{"fx", &F::fx}, {"fy", &F::fy}}};
    case ForceElement::Kind::section:
      return {{{"fx", &F::fx}, {"fy", &F::fy}, {"N", &F::fn}, {"Q", &F::ft}, {"M", &F::bending}},
              {{"fx", &F::fx}, {"fy", &F::fy}, {"m", &F::m}}};
    case ForceElement::Kind::push:
      return {{{"fx", &F::fx}, {"fy", &F::fy}, {"power", &F::power}}, {{"fx", &F::fx}, {"fy", &F::fy}}};
    case ForceElement::Kind::drive:
    case ForceElement::Kind::torque:
      return {{{"torque", &F::m}, {"power", &F::power}}, {{"torque", &F::m}}};
  }
  throw std::logic_error("no such kind of element");
}

void refuse_shared_names(const Layout& layout) {
  for (auto a = layout.forces.begin(); a != layout.forces.end(); ++a)
    if (std::ranges::find(layout.forces.begin(), a, a->name, &ForceElement::name) != a) {
      const bool load = a->kind == ForceElement::Kind::force || a->kind == ForceElement::Kind::torque ||
                        a->kind == ForceElement::Kind::section;
      const bool drive = a->kind == ForceElement::Kind::drive || a->kind == ForceElement::Kind::push;
      throw ModelError(fmt::format("{}.{}",
                                   load    ? "loads"
                                   : drive ? "drives"
                                           : "joints",
                                   a->name),
                       "another joint, contact, drive or load has the same name, so forces.csv would be "
                       "ambiguous; rename one");
    }
}

std::vector<Column> trajectory_columns(const Layout& layout) {
  std::vector<Column> all(1);
  for (std::size_t b = 0; b < layout.bodies.size(); ++b)
    for (const bool rates : {false, true})
      for (int c = 0; c < planar::coordinates; ++c)
        all.push_back({layout.bodies[b],
                       (rates ? planar::rate_names : planar::names)[static_cast<std::size_t>(c)],
                       rates ? Column::Of::velocity : Column::Of::position,
                       planar::first(b) + static_cast<std::size_t>(c), nullptr, nullptr});
  for (std::size_t k = 0; k < layout.contacts.size(); ++k)
    for (const auto& [part, place] :
         {std::pair{"ex", &ContactPlace::ex}, {"ey", &ContactPlace::ey}, {"gap", &ContactPlace::gap}})
      all.push_back({layout.contacts[k], part, Column::Of::contact, k, place, nullptr});
  return all;
}

std::vector<Column> force_columns(const Layout& layout) {
  std::vector<Column> all(1);
  for (std::size_t i = 0; i < layout.forces.size(); ++i) {
    const auto parts = force_parts(layout.forces[i].kind);
    for (const auto& [part, force] : parts.now)
      all.push_back({layout.forces[i].name, part, Column::Of::force, i, nullptr, force});
    for (const auto& [part, force] : parts.mean)
      all.push_back({layout.forces[i].name, part, Column::Of::mean, i, nullptr, force});
  }
  for (std::size_t b = 0; b < layout.bodies.size(); ++b)
    for (int c = 0; c < planar::coordinates; ++c)
      all.push_back({layout.bodies[b], planar::acceleration_names[static_cast<std::size_t>(c)],
                     Column::Of::acceleration, planar::first(b) + static_cast<std::size_t>(c), nullptr,
                     nullptr});
  return all;
}

namespace {

std::vector<ColumnName> names_of(const std::vector<Column>& columns) {
  std::vector<ColumnName> names;
  for (const auto& c : columns) names.push_back({c.name()});
  return names;
}

}  // namespace

bool TableSink::open(std::vector<ColumnName> columns) {
  columns_ = std::move(columns);
  const bool fresh = std::exchange(fresh_, false);
  if (fresh) head();
  return fresh;
}

void TrajectoryRows::begin(const Layout& layout, const State& state) {
  columns_ = trajectory_columns(layout);
  data_.begin(layout, state);
  if (!sink_.open(names_of(columns_))) return grid_.go_on_to(layout.end);
  grid_.begin(state.t, layout.output_step, layout.end, layout.duration);
  data_.q = state.q;
  data_.v = state.v;
  data_.contacts = layout.start;
  data_.row(columns_, state.t, row_);
  sink_.put(row_, {});
}

void TrajectoryRows::step(const Step& step) {
  for (; grid_.next() <= step.t1 && !step.stopped(); grid_.advance()) {
    const double t = grid_.next();
    step.state(t, data_.q, data_.v);
    step.contacts(t, data_.q, data_.contacts);
    data_.row(columns_, t, row_);
    sink_.put(row_, {});
  }
}

void ForceRows::begin(const Layout& layout, const State& state) {
  columns_ = force_columns(layout);
  if (!sink_.open(names_of(columns_))) return grid_.go_on_to(layout.end);
  data_.begin(layout, state);
  since_ = state.t;
  grid_.begin(state.t, layout.output_step, layout.end, layout.duration);
}

void ForceRows::step(const Step& step) {
  auto& sum = data_.sum;
  if (!started_) {  // forces are known after the first step; the first row uses them as means
    started_ = true;
    step.forces(step.t0, data_.now);
    row(step.t0, data_.now, 1);
  }
  sum.add(1, step.before());
  double from = step.t0;
  const double h = step.t1 - step.t0;
  if (h == 0) sum.add(1, step.within());
  const auto up_to = [&](double t) {
    step.add_impulse(from, t, sum);
    if (h > 0) sum.add((t - from) / h, step.within());
    from = t;
  };
  for (; grid_.next() <= step.t1 && !step.stopped(); grid_.advance()) {
    const double t = grid_.next();
    up_to(t);
    step.forces(t, data_.now);
    row(t, sum, 1 / (t - since_));
    since_ = t;
    sum.clear();
  }
  up_to(step.t1);
}

void ForceRows::row(double t, const Forces& means, double share) {
  data_.row(columns_, t, row_);
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (const auto& c = columns_[i]; c.of == Column::Of::mean)
      row_[i] = share * (means.elements[c.index].*c.force);
  sink_.put(row_, {});
}

void EventRows::begin(const Layout&, const State&) {
  sink_.open({{"t"},
              {"joint", true},
              {"kind", true},
              {"crank_angle"},
              {"v_n_minus"},
              {"v_n_plus"},
              {"v_t_minus"},
              {"v_t_plus"},
              {"impulse_n"},
              {"impulse_t"},
              {"duration"},
              {"t_uncertainty"}});
}

void EventRows::event(const Event& e) {
  const double numbers[] = {e.t,        e.crank_angle, e.v_n_minus, e.v_n_plus, e.v_t_minus,
                            e.v_t_plus, e.impulse_n,   e.impulse_t, e.duration, e.t_uncertainty};
  const std::string_view texts[] = {e.joint, name_of(e.kind)};
  sink_.put(numbers, texts);
}

void SignalRows::begin(const Layout& layout, const State&) {
  names_ = layout.channels;
  crank_start_ = layout.crank_start;
  crank_speed_ = layout.crank_speed;
  sink_.open({{"channel", true}, {"t"}, {"crank_angle"}, {"value"}});
}

void SignalRows::sample(std::size_t channel, double t, double value) {
  const double numbers[] = {t, crank_start_ + crank_speed_ * t, value};
  const std::string_view texts[] = {names_[channel]};
  sink_.put(numbers, texts);
}

}  // namespace freeplay
