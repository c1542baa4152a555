#include "formulations/event_driven/variation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace freeplay {
namespace {

/// Dormand and Prince's coefficients of the six stages of the result of fifth order.
constexpr double dopri_c[6] = {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1};
constexpr double dopri_a[6][5] = {
    {},
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {44.0 / 45, -56.0 / 15, 32.0 / 9},
    {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
    {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
};
constexpr double dopri_b[6] = {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84};

/// Ratio of the spacings of differences that are tried in turn.
constexpr double closer = 0.03;

void add_multiple(std::vector<double>& y, double factor, const std::vector<double>& x) {
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += factor * x[i];
}

}  // namespace

Variation::Variation(const EventDynamics& d, std::vector<VariedKey> keys, std::vector<Column> integrands,
                     double length, double duration)
    : keys_(std::move(keys)),
      probe_(d.twin()),
      after_(d.twin()),
      reasons_(keys_.size()),
      loss_(keys_.size()),
      integrands_(std::move(integrands)),
      integrals_(integrands_.size()),
      integral_rates_(keys_.size(), Vector(integrands_.size())),
      length_(length),
      duration_(duration),
      size_(static_cast<std::size_t>(d.size())) {
  const int n = d.system.n();
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    const auto& key = keys_[c];
    reasons_[c] = key.refused;
    auto& displaced = displaced_.emplace_back();
    if (key.systems[0]) {
      auto& first = displaced.emplace_back();
      first.spacing = key.spacing;
      for (std::size_t i = 0; i < first.dynamics.size(); ++i) first.dynamics[i] = d.twin_of(*key.systems[i]);
    }
    auto& column = S_.emplace_back(size_);
    if (!key.refused.empty()) continue;
    std::copy_n(key.start.begin(), 2 * n, column.begin());
    std::copy(key.start.begin() + 2 * n, key.start.end(), column.begin() + d.state_offset());
  }
  if (d.coupled.size() > 0)
    refuse("joint friction depends on the joint's reaction; derivatives of such friction are not available");
  for (auto& f : f_) f.resize(size_);
  for (auto& list : slopes_) list.assign(keys_.size(), Vector(size_));
  seeds_ = S_;
}

void Variation::refuse(const std::string& reason) {
  for (std::size_t c = 0; c < keys_.size(); ++c) refuse(c, reason);
}

void Variation::refuse(std::size_t c, const std::string& reason) {
  if (!open(c)) return;
  reasons_[c] = reason;
  std::ranges::fill(S_[c], 0.0);
}

/// Copies the mode to all objects. Contacts at rest without load are open, because they have no force.
void Variation::take_mode(const EventDynamics& d) {
  const auto take = [&](EventDynamics& f) {
    f.take_mode(d);
    for (auto& c : f.contacts) c.resting = false;
  };
  take(*probe_);
  for (auto& list : displaced_)
    for (auto& level : list)
      for (auto& f : level.dynamics) take(*f);
  mode_known_ = true;
}

/// Adds dynamics at closer values, in the present mode; false if they would be lost in rounding.
bool Variation::displace_closer(std::size_t c) {
  const auto& key = keys_[c];
  const double spacing = displaced_[c].size() == 1 && key.impact_spacing < key.spacing
                             ? key.impact_spacing
                             : displaced_[c].back().spacing * closer;
  if (!key.system_at || spacing < 1e-9 * std::abs(key.value)) return false;
  Displaced next{spacing, {}};
  for (std::size_t i = 0; i < next.dynamics.size(); ++i) {
    next.dynamics[i] = probe_->twin_of(*key.system_at(key.value + difference_places[i] * spacing));
    next.dynamics[i]->take_mode(*probe_);
    next.dynamics[i]->knot = probe_->knot;
  }
  displaced_[c].push_back(std::move(next));
  return true;
}

void Variation::advance(const EventDynamics& d, double t_old, const Vector& x_old, double t) {
  const double h = t - t_old;
  const bool all_closed = std::ranges::none_of(reasons_, [](const auto& r) { return r.empty(); });
  if (!(h > 0) || (all_closed && integrands_.empty())) return;
  if (!mode_known_) take_mode(d);
  probe_->knot = d.knot;
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    for (auto& level : displaced_[c])
      for (auto& f : level.dynamics) f->knot = d.knot;
    if (keys_[c].systems[2] && keys_[c].systems[2]->next_knot(t_old) != d.system.next_knot(t_old))
      refuse(c, fmt::format("t = {:.9g} s: {} moves a knot of a table or curve in time; derivatives with "
                            "respect to such keys are not available",
                            t_old, keys_[c].name));
  }
  for (std::size_t i = 0; i < f_.size(); ++i) {
    const double at = t_old + dopri_c[i] * h;
    stage_ = x_old;
    for (std::size_t j = 0; j < i; ++j) add_multiple(stage_, h * dopri_a[i][j], f_[j]);
    for (std::size_t c = 0; c < keys_.size(); ++c) {
      seeds_[c] = S_[c];
      if (!open(c)) continue;
      for (std::size_t j = 0; j < i; ++j) add_multiple(seeds_[c], h * dopri_a[i][j], slopes_[j][c]);
    }
    f_[i] = probe_->directional(stage_, at, seeds_, slopes_[i]);
    evaluations_ += 1 + static_cast<long>(keys_.size());
    for (std::size_t c = 0; c < keys_.size(); ++c) {
      if (!open(c)) continue;
      parameter_part(c, stage_, at, f_[i], part_);
      add_multiple(slopes_[i][c], 1, part_);
    }
    if (!integrands_.empty() && dopri_b[i] != 0) integrate(h * dopri_b[i], stage_, at);
  }
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (!open(c)) continue;
    for (std::size_t i = 0; i < f_.size(); ++i) add_multiple(S_[c], h * dopri_b[i], slopes_[i][c]);
    if (!is_finite(S_[c])) refuse(c, fmt::format("t = {:.9g} s: the derivative is no longer finite", t));
  }
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

Variation::Function Variation::integrands() const {
  return [this](EventDynamics& f, const Vector& x, double t) {
    Vector list;
    for (const auto& c : integrands_) list.push_back(observed(c, f, x, t));
    return list;
  };
}

/// Adds a stage of the quadrature of the integrands and of their derivatives along seeds_.
void Variation::integrate(double weight, const Vector& x, double t) {
  const auto value = integrands();
  const double speed = std::max(probe_->greatest(x.data() + probe_->system.n()), probe_->speed_scale());
  add_multiple(integrals_, weight, value(*probe_, x, t));
  for (std::size_t c = 0; c < keys_.size(); ++c)
    if (open(c)) add_multiple(integral_rates_[c], weight, total(c, value, x, t, seeds_[c], 0, speed));
}

/// d(I/T) = dI/T + (c(T) − I/T) dT/T, with T the length of the run.
Variation::Vector Variation::mean_derivatives(std::size_t i, const EventDynamics& d, const Vector& x,
                                              double begin, double end) {
  take_mode(d);
  mode_known_ = false;
  const double length = end - begin, now = observed(integrands_[i], *probe_, x, end);
  Vector list;
  for (std::size_t c = 0; c < keys_.size(); ++c)
    list.push_back(open(c)
                       ? (integral_rates_[c][i] + (now - integrals_[i] / length) * keys_[c].end_rate) / length
                       : NAN);
  return list;
}

/// f_p at a fixed state and mode. A parameter that changes no digit of f has no part.
void Variation::parameter_part(std::size_t c, const Vector& x, double t, const Vector& f, Vector& out) {
  out.assign(size_, 0);
  if (displaced_[c].empty()) return;
  auto& list = displaced_[c].front().dynamics;
  std::array<Vector, 4> values;
  for (const std::size_t i : {2U, 1U, 0U, 3U}) {
    values[i].resize(size_);
    (*list[i])(x, values[i], t);
    ++evaluations_;
    if (i == 2 && values[2] == f) return;
  }
  const double h = keys_[c].spacing;
  for (std::size_t k = 0; k < size_; ++k)
    out[k] = (8 * (values[2][k] - values[1][k]) - (values[3][k] - values[0][k])) / (12 * h);
}

/// The greatest step along (dx, dt) that is small against the lengths, speeds and times over which
/// functions of the state are curved; 0 if the direction vanishes.
double Variation::spacing(const EventDynamics& f, const Vector& dx, double dt, double speed) const {
  const auto& system = f.system;
  const int n = system.n();
  const double arm = std::max(system.longest_arm(), length_);
  double most = std::abs(dt) / (1e-5 * duration_);
  for (int i = 0; i < n; ++i) {
    const double unit = system.is_angle(i) ? arm : 1;
    most = std::max(
        {most, unit * std::abs(dx[i]) / (3e-3 * length_), unit * std::abs(dx[n + i]) / (1e-2 * speed)});
    if (system.is_angle(i)) most = std::max(most, std::abs(dx[i]) / 3e-3);
  }
  for (int k = 0; k < system.states(); ++k)
    most = std::max(most, std::abs(dx[f.state_offset() + k]) / (1e-3 * system.state_scale(k)));
  return most > 0 ? 1 / most : 0;
}

/// At most h, so that the rates of approaching contacts change by little: what an impact does depends on
/// their ratios.
double Variation::within_rates(double h, EventDynamics& f, const Vector& x, double t, const Vector& dx,
                               double dt) {
  const int n = f.system.n();
  const auto rates = [&](int k, const Vector& y, double at) {
    const auto& row = f.look(k, y, at);
    return std::pair{row.normal.dot(y.data() + n), row.tangent.dot(y.data() + n)};
  };
  for (const int k : approaching_) {
    const auto [rate, sliding] = rates(k, x, t);
    const double most = 1e-2 * std::abs(rate), most_sliding = std::max(most, 1e-2 * std::abs(sliding));
    // Rates are nearly linear once their changes are small.
    for (int pass = 0; pass < 2; ++pass) {
      auto y = x;
      add_multiple(y, h, dx);
      const auto [there, sliding_there] = rates(k, y, t + h * dt);
      h /= std::max({1.0, std::abs(there - rate) / most, std::abs(sliding_there - sliding) / most_sliding});
    }
  }
  return h;
}

/// Derivative along (dx, dt) at constant p. If a kink is within the differences, closer ones are tried.
Difference Variation::along(EventDynamics& f, const Function& value, const Vector& centre, const Vector& x,
                            double t, const Vector& dx, double dt, double speed) {
  Difference d{Vector(centre.size()), true};
  double h = spacing(f, dx, dt, speed);
  if (h == 0) return d;
  h = within_rates(h, f, x, t, dx, dt);
  Vector y;
  for (int tries = 0; tries < 3; ++tries, h *= closer) {
    d = difference(h, centre, [&](std::size_t i) {
      y = x;
      add_multiple(y, difference_places[i] * h, dx);
      return value(f, y, t + difference_places[i] * h * dt);
    });
    if (d.smooth) break;
  }
  return d;
}

/// Derivative with respect to p at a fixed state. If a kink is within the differences, closer ones are tried.
Difference Variation::across(std::size_t c, const Function& value, const Vector& centre, const Vector& x,
                             double t) {
  auto& list = displaced_[c];
  Difference d{Vector(centre.size()), true};
  if (list.empty()) return d;
  const std::size_t first = keys_[c].impact_spacing < keys_[c].spacing ? 1 : 0;
  for (std::size_t level = first; level < first + 3; ++level) {
    if (level == list.size() && !displace_closer(c)) break;
    const auto& f = list[level].dynamics;
    d = difference(list[level].spacing, centre, [&](std::size_t i) { return value(*f[i], x, t); });
    if (d.smooth) break;
  }
  return d;
}

/// Total derivative of a function along column c; ends the column at a kink. Without kinks, rounding errors
/// of a function that nearly vanishes cannot pass for one.
Variation::Vector Variation::total(std::size_t c, const Function& value, const Vector& x, double t,
                                   const Vector& dx, double dt, double speed, bool may_have_kinks) {
  const auto centre = value(*probe_, x, t);
  auto d = along(*probe_, value, centre, x, t, dx, dt, speed);
  const auto p = across(c, value, centre, x, t);
  if (may_have_kinks && (!d.smooth || !p.smooth))
    refuse(c, fmt::format("t = {:.9g} s: the impact law or a constraint has a kink there, so the one-sided "
                          "derivatives differ",
                          t));
  add_multiple(d.slope, 1, p.slope);
  return d.slope;
}

std::vector<Variation::Vector> Variation::end_columns(const EventDynamics& d, const Vector& x, double t) {
  take_mode(d);
  mode_known_ = false;
  Vector f(size_);
  (*probe_)(x, f, t);
  auto columns = S_;
  for (std::size_t c = 0; c < keys_.size(); ++c)
    if (open(c)) add_multiple(columns[c], keys_[c].end_rate, f);
  return columns;
}

Variation::Vector Variation::end_derivatives(const EventDynamics& d, const Vector& x, double t,
                                             const Function& value, double& now,
                                             std::vector<std::string>& reasons) {
  take_mode(d);
  mode_known_ = false;
  reasons = reasons_;
  now = value(*probe_, x, t)[0];
  Vector f(size_);
  (*probe_)(x, f, t);
  const double speed = std::max(d.greatest(x.data() + d.system.n()), d.speed_scale());
  Vector list;
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    list.push_back(NAN);
    if (!open(c)) continue;
    auto dx = S_[c];
    add_multiple(dx, keys_[c].end_rate, f);
    list[c] = total(c, value, x, t, dx, keys_[c].end_rate, speed)[0];
    // A kink of one quantity does not end the column for the others.
    if (!open(c)) {
      reasons[c] = std::exchange(reasons_[c], "");
      list[c] = NAN;
    }
  }
  return list;
}

}  // namespace freeplay
