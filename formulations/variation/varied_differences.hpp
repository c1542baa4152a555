// Differences of VariedColumns (varied_columns.hpp): derivatives with respect to a parameter at a fixed
// state, and along a direction of the state at a fixed parameter. Each is a central difference of fourth
// order of a closed form (differences.hpp), with a spacing that is small against the lengths, speeds and
// ratios of rates on which it depends. varied_columns.cpp alone includes these definitions.
#pragma once

#include <fmt/format.h>

#include "formulations/variation/varied_columns.hpp"

namespace freeplay {

/// Adds dynamics at closer values, in the present mode; false if they would be lost in rounding.
template <class Dynamics>
bool VariedColumns<Dynamics>::displace_closer(std::size_t c) {
  constexpr double least_spacing = 2e-11;  // of the value: the four places keep five digits
  const auto& key = keys_[c];
  const double spacing = !closer_[c].empty()                ? closer_[c].back().spacing * ratio
                         : key.impact_spacing < key.spacing ? key.impact_spacing
                                                            : key.spacing * ratio;
  if (!twin_of_ || !key.system_at || spacing < least_spacing * std::abs(key.value)) return false;
  Closer next{spacing, {}};
  for (std::size_t i = 0; i < next.dynamics.size(); ++i) {
    next.dynamics[i] = twin_of_(*key.system_at(key.value + difference_places[i] * spacing));
  }
  closer_[c].push_back(std::move(next));
  return true;
}

/// f_p at a fixed state and mode. A parameter that changes no bit of f has no part. If the parameter moves
/// a kink of f past the state, the values on the other side of it are left out. The second differences about
/// −h, 0 and h of a smooth function lie on a line up to its fourth derivative, those of a kink do not.
template <class Dynamics>
void VariedColumns<Dynamics>::parameter_part(std::size_t c, const Vector& x, double t, const Vector& f,
                                             Vector& out) {
  // Relative changes of the slope and of the value, and of second differences about a line.
  constexpr double kink = 1e-5, rounding = 1e-13, bend = 0.02;
  out.assign(size_, 0);
  auto& list = displaced_[c];
  if (!list[0]) return;
  std::array<Vector, 4> values;
  for (const std::size_t i : {2U, 1U, 0U, 3U}) {
    values[i].resize(size_);
    (*list[i])(x, values[i], t);
    ++evaluations_;
    if (i == 2 && values[2] == f) return;
  }
  const double h = keys_[c].spacing;
  for (std::size_t k = 0; k < size_; ++k) {
    const double inner = values[2][k] - values[1][k], above = values[3][k] - 2 * values[2][k] + f[k],
                 below = values[0][k] - 2 * values[1][k] + f[k],
                 centre = values[2][k] - 2 * f[k] + values[1][k], least = rounding * std::abs(f[k]);
    if (std::abs(above - below) <= kink * std::abs(inner) + least ||
        std::abs(above + below - 2 * centre) <= bend * std::abs(above - below) + least)
      out[k] = (8 * inner - (values[3][k] - values[0][k])) / (12 * h);
    else if (std::abs(above) < std::abs(below))
      out[k] = (4 * values[2][k] - values[3][k] - 3 * f[k]) / (2 * h);
    else
      out[k] = (3 * f[k] - 4 * values[1][k] + values[0][k]) / (2 * h);
  }
}

/// The greatest step along (dx, dt) that is small against the lengths, speeds and times over which
/// functions of the state are curved; 0 if the direction vanishes. Functions are linear in works and
/// impulses: a direction of these alone takes steps of their own size.
template <class Dynamics>
double VariedColumns<Dynamics>::spacing(const Dynamics& f, const Vector& x, const Vector& dx, double dt,
                                        double speed) const {
  // Steps over the scales of time, of lengths and angles, of speeds, and of states.
  constexpr double of_time = 1e-5, of_length = 3e-3, of_speed = 1e-2, of_state = 1e-3;
  const auto& system = f.system;
  const int n = system.n();
  const double length = curved_length(f, x, length_);
  const double arm = std::max(system.longest_arm(), length);
  double most = std::abs(dt) / (of_time * duration_);
  for (int i = 0; i < n; ++i) {
    const double unit = system.is_angle(i) ? arm : 1;
    most = std::max({most, unit * std::abs(dx[i]) / (of_length * length),
                     unit * std::abs(dx[n + i]) / (of_speed * speed)});
    if (system.is_angle(i)) most = std::max(most, std::abs(dx[i]) / of_length);
  }
  for (int k = 0; k < system.states(); ++k)
    most = std::max(most, std::abs(dx[f.state_offset() + k]) / (of_state * system.state_scale(k)));
  most = std::max(most, further_spacing(f, x, dx));
  if (most == 0) {
    const auto size_of = [n](const Vector& y) {
      double greatest = 0;
      for (std::size_t i = 2 * static_cast<std::size_t>(n); i < y.size(); ++i)
        greatest = std::max(greatest, std::abs(y[i]));
      return greatest;
    };
    const double now = size_of(x);
    most = size_of(dx) / (now > 0 ? now : 1);
  }
  return most > 0 ? 1 / most : 0;
}

/// At most h, so that the rates of approaching contacts change by little: what an impact does depends on
/// their ratios.
template <class Dynamics>
double VariedColumns<Dynamics>::within_rates(double h, Dynamics& f, const Vector& x, double t,
                                             const Vector& dx, double dt) {
  if constexpr (requires { f.look(0, x, t).tangent; }) {
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
  }
  return h;
}

/// Of differences at decreasing spacings, none of which is smooth: the widest one whose violation is
/// rounding, else the last one.
inline Difference smooth_but_rounding(std::vector<Difference>& list, const std::vector<double>& spacings) {
  for (std::size_t i = 0; i + 1 < list.size(); ++i)
    if (is_rounding(list[i], list.back(), spacings[list.size() - 1] / spacings[i])) {
      list[i].smooth = true;
      return std::move(list[i]);
    }
  return std::move(list.back());
}

/// Derivative along (dx, dt) at constant p. If a kink is within the differences, closer ones are tried.
template <class Dynamics>
Difference VariedColumns<Dynamics>::along(Dynamics& f, const Function& value, const Vector& centre,
                                          const Vector& x, double t, const Vector& dx, double dt,
                                          double speed) {
  Difference d{Vector(centre.size()), true};
  double h = spacing(f, x, dx, dt, speed);
  if (h == 0) return d;
  h = within_rates(h, f, x, t, dx, dt);
  if constexpr (requires { f.pin(x, t); }) f.pin(x, t);
  Vector y, spacings;
  std::vector<Difference> list;
  for (int tries = 0; tries < 4; ++tries, h *= ratio) {
    spacings.push_back(h);
    list.push_back(difference(h, centre, [&](std::size_t i) {
      y = x;
      add_multiple(y, difference_places[i] * h, dx);
      return value(f, y, t + difference_places[i] * h * dt);
    }));
    if (list.back().smooth) break;
  }
  d = list.back().smooth ? std::move(list.back()) : smooth_but_rounding(list, spacings);
  if constexpr (requires { f.pin(x, t); }) f.unpin();
  return d;
}

/// Derivative with respect to p at a fixed state. If a kink is within the differences, closer ones are tried.
template <class Dynamics>
Difference VariedColumns<Dynamics>::across(std::size_t c, const Function& value, const Vector& centre,
                                           const Vector& x, double t) {
  if (!displaced_[c][0]) return {Vector(centre.size()), true};
  Vector spacings;
  std::vector<Difference> list;
  const auto at = [&](double spacing, const Displaced& displaced) {
    spacings.push_back(spacing);
    list.push_back(difference(spacing, centre, [&](std::size_t i) { return value(*displaced[i], x, t); }));
    return list.back().smooth;
  };
  if (!(twin_of_ && keys_[c].impact_spacing < keys_[c].spacing) && at(keys_[c].spacing, displaced_[c]))
    return list.back();
  for (std::size_t level = 0; level < 4; ++level) {
    if (level == closer_[c].size() && !displace_closer(c)) break;
    if (at(closer_[c][level].spacing, closer_[c][level].dynamics)) return list.back();
  }
  if (list.empty()) at(keys_[c].spacing, displaced_[c]);
  return smooth_but_rounding(list, spacings);
}

template <class Dynamics>
void VariedColumns<Dynamics>::set_times(EventMap& e, const Function& value, double rate,
                                        const SparseRow* normal, bool strict) {
  const auto centre = value(*probe_, e.x, e.t);
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (!open(c)) continue;
    const auto part = across(c, value, centre, e.x, e.t);
    const double slope = normal ? normal->dot(S_[c].data())
                                : along(*probe_, value, centre, e.x, e.t, S_[c], 0, e.speed).slope[0];
    e.dt[c] = -(slope + part.slope[0]) / rate;
    if ((strict && !part.smooth) || !std::isfinite(e.dt[c]))
      refuse(c, fmt::format("t = {:.9g} s: the time of this event has no derivative", e.t));
  }
}

/// The demand is at the limit within rounding, which decides the side of an evaluation there; both sides are
/// therefore extrapolated.
template <class Dynamics>
void VariedColumns<Dynamics>::take_sides_of_limit(EventMap& e, Dynamics& next, int k, const Vector& x_after) {
  const double t = e.t, h = 1e-3 * spacing(*probe_, e.x, e.before.f, 1, curved_speed(*probe_, e.x));
  const auto beside = [&](Dynamics& f, Vector y, const Side& here, double way) {
    add_multiple(y, way, here.f);
    auto s = side(f, y, t + way);
    add_multiple(y, way, here.f);
    const auto far = side(f, y, t + 2 * way);
    for (std::size_t i = 0; i < s.f.size(); ++i) s.f[i] = 2 * s.f[i] - far.f[i];
    for (std::size_t i = 0; i < s.integrands.size(); ++i)
      s.integrands[i] = 2 * s.integrands[i] - far.integrands[i];
    return s;
  };
  e.before = beside(*probe_, e.x, Side(e.before), -h);
  e.after = beside(next, x_after, Side(e.after), h);
  const auto rate = [&](const Side& s) {
    auto y = e.x, z = e.x;
    add_multiple(y, h, s.f);
    add_multiple(z, -h, s.f);
    return demand(*probe_, k, y, t + h) - demand(*probe_, k, z, t - h);
  };
  if (rate(e.before) * rate(e.after) < 0)
    refuse(fmt::format(
        "t = {:.9g} s: the demand of a controller stays at its limit; derivatives along such motions "
        "are not available",
        t));
}

/// Derivative along (dx, dt) and p together. The two parts alone are larger by length over clearance if a key
/// displaces a journal that the motion then carries back, and their errors with them. Nothing if the
/// displaced values of p are farther apart than the state may move.
template <class Dynamics>
std::optional<Difference> VariedColumns<Dynamics>::together(std::size_t c, const Function& value,
                                                            const Vector& centre, const Vector& x, double t,
                                                            const Vector& dx, double dt, double speed) {
  constexpr std::size_t levels = 2;
  if constexpr (requires { probe_->pin(x, t); }) return {};
  if (!displaced_[c][0]) return {};
  double most = spacing(*probe_, x, dx, dt, speed);
  if (most == 0) return {};
  most = within_rates(most, *probe_, x, t, dx, dt);
  Vector y;
  const auto at = [&](double h, const Displaced& displaced) {
    return difference(h, centre, [&](std::size_t i) {
      y = x;
      add_multiple(y, difference_places[i] * h, dx);
      return value(*displaced[i], y, t + difference_places[i] * h * dt);
    });
  };
  if (!(twin_of_ && keys_[c].impact_spacing < keys_[c].spacing) && keys_[c].spacing <= most)
    if (auto d = at(keys_[c].spacing, displaced_[c]); d.smooth) return d;
  for (std::size_t level = 0; level < levels; ++level) {
    if (level == closer_[c].size() && !displace_closer(c)) break;
    if (closer_[c][level].spacing > most) continue;
    if (auto d = at(closer_[c][level].spacing, closer_[c][level].dynamics); d.smooth) return d;
  }
  return {};
}

template <class Dynamics>
std::vector<double> VariedColumns<Dynamics>::total(std::size_t c, const Function& value, const Vector& x,
                                                   double t, const Vector& dx, double dt, double speed,
                                                   bool strict) {
  const auto centre = value(*probe_, x, t);
  auto d = along(*probe_, value, centre, x, t, dx, dt, speed);
  const auto p = across(c, value, centre, x, t);
  constexpr double cancelled = 30;
  for (std::size_t k = 0; k < centre.size(); ++k)
    if (std::abs(d.slope[k]) + std::abs(p.slope[k]) > cancelled * std::abs(d.slope[k] + p.slope[k])) {
      if (auto both = together(c, value, centre, x, t, dx, dt, speed)) return std::move(both->slope);
      break;
    }
  if (strict && (!d.smooth || !p.smooth))
    refuse(c, fmt::format("t = {:.9g} s: the impact law or a constraint has a kink there, so the one-sided "
                          "derivatives differ",
                          t));
  add_multiple(d.slope, 1, p.slope);
  return d.slope;
}

}  // namespace freeplay
