#include "formulations/event_driven/variation.hpp"

#include <utility>

namespace freeplay {

Variation::Variation(const EventDynamics& d, const std::vector<VariedKey>& keys,
                     std::vector<Column> integrands, double length, double duration)
    : VariedColumns(
          d.twin(), keys,
          [](EventDynamics& probe, const VariedKey& key, std::size_t i) {
            return probe.twin_of(*key.systems[i]);
          },
          std::move(integrands), length, duration),
      after_(d.twin()),
      loss_(keys.size()) {
  twin_of_ = [this](const System& system) {
    auto twin = probe_->twin_of(system);
    take_varied_mode(*twin, *probe_);
    twin->knot = probe_->knot;
    return twin;
  };
}

void Variation::advance(const EventDynamics& d, double t_old, const Vector& x_old, double t) {
  const double h = t - t_old;
  if (!(h > 0) || idle()) return;
  if (!mode_known_) take_mode(d);
  take_knot(d.system, t_old, d.knot);
  advance_watched(t_old, x_old, h);
}

void Variation::project_columns(const EventDynamics& d, const Vector& x, double t) {
  take_mode(d);
  mode_known_ = false;
  const Function projected = [](EventDynamics& f, const Vector& y, double at) {
    auto z = y;
    f.project(z, at);
    return z;
  };
  const double speed = curved_speed(*probe_, x);
  for (std::size_t c = 0; c < keys_.size(); ++c)
    if (open(c)) S_[c] = total(c, projected, x, t, S_[c], 0, speed, false);
}

double observed(const Column& column, EventDynamics& f, const std::vector<double>& x, double t) {
  using Of = Column::Of;
  const int n = f.system.n();
  switch (column.of) {
    case Of::time:
      return t;
    case Of::position:
      return x[column.index];
    case Of::velocity:
      return x[static_cast<std::size_t>(n) + column.index];
    case Of::contact: {
      const int k = static_cast<int>(column.index);
      f.place(x.data(), t);
      const auto e = f.system.eccentricity(k, x.data(), f.e);
      return ContactPlace{e.x(), e.y(), f.system.gap(k, x.data(), f.e)}.*column.place;
    }
    default:
      break;
  }
  auto forces = f.system.make_forces();
  f.report(x, t, forces);
  return column.of == Of::acceleration ? forces.acceleration[column.index]
                                       : forces.elements[column.index].*column.force;
}

}  // namespace freeplay
