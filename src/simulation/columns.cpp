#include "simulation/columns.hpp"

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
      const bool load = a->kind == ForceElement::Kind::force || a->kind == ForceElement::Kind::torque;
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

}  // namespace freeplay
