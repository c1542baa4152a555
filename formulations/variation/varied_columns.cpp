#include "formulations/variation/varied_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "formulations/event_driven/variation.hpp"
#include "formulations/integrators/methods.hpp"
#include "formulations/penalty/extended_penalty.hpp"
#include "formulations/variation/varied_differences.hpp"
#include "numerics/bracketed_root.hpp"

namespace freeplay {
namespace {

/// y = x + h Σ weights[j] f(j) over the first `stages`, at most seven, in their order.
template <std::size_t count = 7, class Stage>
void combine(std::vector<double>& y, const std::vector<double>& x, double h, const double* weights,
             std::size_t stages, const Stage& f) {
  if constexpr (count > 0) {
    if (stages < count) return combine<count - 1>(y, x, h, weights, stages, f);
    using Array = Eigen::Map<const Eigen::ArrayXd>;
    const auto size = static_cast<Eigen::Index>(x.size());
    const auto sum = [&]<std::size_t... J>(std::index_sequence<J...>) {
      Eigen::Map<Eigen::ArrayXd>(y.data(), size) =
          (Array(x.data(), size) + ... + (h * weights[J] * Array(f(J).data(), size)));
    };
    y.resize(x.size());
    sum(std::make_index_sequence<count>());
  } else {
    y = x;
  }
}

}  // namespace

template <class Dynamics>
VariedColumns<Dynamics>::VariedColumns(std::unique_ptr<Dynamics> probe, std::vector<VariedKey> keys,
                                       const Displace& displace, std::vector<Column> integrands,
                                       double length, double duration)
    : DerivativeColumns(std::move(keys)),
      probe_(std::move(probe)),
      displaced_(keys_.size()),
      integrands_(std::move(integrands)),
      integrals_(integrands_.size()),
      integral_rates_(keys_.size(), Vector(integrands_.size())),
      length_(length),
      duration_(duration),
      size_(static_cast<std::size_t>(probe_->size())),
      shifts_(keys_.size()) {
  const int n = probe_->system.n();
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    const auto& key = keys_[c];
    reasons_[c] = key.refused;
    auto& column = S_.emplace_back(size_);
    for (std::size_t i = 0; i < displaced_[c].size(); ++i)
      if (key.systems[i]) displaced_[c][i] = displace(*probe_, key, i);
    if (!key.refused.empty()) continue;
    std::copy_n(key.start.begin(), 2 * n, column.begin());
    std::copy_n(key.start.begin() + 2 * n, probe_->system.states(), column.begin() + probe_->state_offset());
  }
  if (!probe_->system.reactive_frictions().empty())
    refuse(
        "joint friction depends on the joint's reaction or on the speed; derivatives of such friction are not "
        "available");
  if constexpr (requires { probe_->friction_of(0, nullptr); })
    for (int k = 0; k < probe_->system.contacts(); ++k)
      if (const auto& facts = probe_->system.contact_facts(k); facts.surface.friction_by_speed())
        refuse(fmt::format(
            "friction of {} depends on the sliding speed (surfaces.{}.static_friction); derivatives of such "
            "friction are not available in the nonsmooth formulation",
            facts.name, facts.surface.name));
  for (auto& f : f_) f.resize(size_);
  for (auto& list : slopes_) list.assign(keys_.size(), Vector(size_));
  last_slopes_ = slopes_[0];
  seeds_ = S_;
  closer_.resize(keys_.size());
}

template <class Dynamics>
void VariedColumns<Dynamics>::take_knot(const System& system, double t_old, double knot) {
  probe_->knot = knot;
  each_displaced([&](Dynamics& f) { f.knot = knot; });
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (keys_[c].systems[2] && keys_[c].systems[2]->next_knot(t_old) != system.next_knot(t_old))
      refuse(c, fmt::format("t = {:.9g} s: {} moves a knot of a table or curve in time; derivatives with "
                            "respect to such keys are not available",
                            t_old, keys_[c].name));
  }
}

/// Right-hand side at stage_, and slopes of the columns seeds_ there.
template <class Dynamics>
std::vector<double> VariedColumns<Dynamics>::slopes_at(double t, std::vector<Vector>& slopes) {
  Vector f;
  if constexpr (requires { probe_->directional(stage_, t, seeds_, shifts_, slopes); })
    f = probe_->directional(stage_, t, seeds_, shifts_, slopes);
  else
    f = probe_->directional(stage_, t, seeds_, slopes);
  evaluations_ += 1 + static_cast<long>(keys_.size());
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (!open(c) || !displaced_[c][0] || probe_->includes_parameter(c)) continue;
    parameter_part(c, stage_, t, f, part_);
    add_multiple(slopes[c], 1, part_);
  }
  return f;
}

/// Greatest error of coordinates, rates and states in a step, over the greatest derivative of their kind, by
/// the weights of an embedded formula.
template <class Dynamics>
template <std::size_t stages>
double VariedColumns<Dynamics>::error_of(const double (&weights)[stages], double h, double speed) {
  constexpr double negligible = 1e-6;  // of lengths and speeds, by a significant change of the key
  const auto n = static_cast<std::size_t>(probe_->system.n()),
             states = static_cast<std::size_t>(probe_->system.states()),
             offset = static_cast<std::size_t>(probe_->state_offset());
  double greatest = 0;
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (!open(c)) continue;
    part_.assign(size_, 0);
    combine(
        part_, part_, 1, weights,
        stages, [&](std::size_t i) -> auto& { return (i < slopes_.size() ? slopes_[i] : last_slopes_)[c]; });
    const double share = negligible / keys_[c].scale();
    const auto &S = S_[c], &slope = slopes_[0][c];
    double error[2] = {}, size[2] = {share * length_, share * speed};
    for (std::size_t k = 0; k < 2 * n; ++k) {
      const auto rate = static_cast<std::size_t>(k >= n);
      error[rate] = std::max(error[rate], std::abs(h * part_[k]));
      size[rate] = std::max({size[rate], std::abs(S[k]), std::abs(h * slope[k])});
    }
    size[0] = std::max(size[0], std::abs(h) * size[1]);
    greatest = std::max({greatest, error[0] / size[0], error[1] / size[1]});
    for (std::size_t k = offset; k < offset + states; ++k) {
      const double least = share * probe_->system.state_scale(static_cast<int>(k - offset));
      greatest = std::max(greatest,
                          std::abs(h * part_[k]) / std::max({least, std::abs(S[k]), std::abs(h * slope[k])}));
    }
  }
  return greatest;
}

/// Whether the columns vary faster than the step resolves, as about a rest or at a kink of the forces.
template <class Dynamics>
bool VariedColumns<Dynamics>::varies_fast(const Vector& x_old, double t_old, double h) {
  using Stages = DormandPrince;
  constexpr double accepted = 1e-9;
  const double speed = curved_speed(*probe_, x_old);
  if (error_of(Stages::third, h, speed) <= accepted) return false;
  combine(
      stage_, x_old, h, Stages::b, 6, [&](std::size_t i) -> auto& { return f_[i]; });
  for (std::size_t c = 0; c < keys_.size(); ++c)
    combine(
        seeds_[c], S_[c], h, Stages::b,
        open(c) ? 6 : 0, [&](std::size_t i) -> auto& { return slopes_[i][c]; });
  last_f_ = slopes_at(t_old + h, last_slopes_);
  ends_ = !(error_of(Stages::fourth, h, speed) > accepted);
  return !ends_;
}

template <class Dynamics>
std::vector<double> VariedColumns<Dynamics>::advance_stages(double t_old, const Vector& x_old, double h,
                                                            int halvings) {
  using Stages = DormandPrince;
  constexpr int most_halvings = 24;  // a kink of the forces then has an error of 1e-7 of that of the step
  if (halvings == 0) begun_ = false;
  const auto integrals = integrals_;
  const auto rates = integrals_.empty() ? std::vector<Vector>() : integral_rates_;
  for (std::size_t i = 0; i < f_.size(); ++i) {
    const double at = t_old + Stages::c[i] * h;
    combine(
        stage_, x_old, h, Stages::a[i], i, [&](std::size_t j) -> auto& { return f_[j]; });
    for (std::size_t c = 0; c < keys_.size(); ++c)
      combine(
          seeds_[c], S_[c], h, Stages::a[i],
          open(c) ? i : 0, [&](std::size_t j) -> auto& { return slopes_[j][c]; });
    if (!std::exchange(begun_, false)) f_[i] = slopes_at(at, slopes_[i]);
    if (!integrands_.empty() && Stages::b[i] != 0) integrate(h * Stages::b[i], i, stage_, at);
  }
  ends_ = false;
  if (halvings < most_halvings && varies_fast(x_old, t_old, h)) {
    integrals_ = integrals;
    if (!rates.empty()) integral_rates_ = rates;
    begun_ = true;
    const auto middle = advance_stages(t_old, x_old, 0.5 * h, halvings + 1);
    return advance_stages(t_old + 0.5 * h, middle, 0.5 * h, halvings + 1);
  }
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (!open(c)) continue;
    combine(
        S_[c], S_[c], h, Stages::b, 6, [&](std::size_t i) -> auto& { return slopes_[i][c]; });
    if (!std::ranges::all_of(S_[c], [](double s) { return std::isfinite(s); }))
      refuse(c, fmt::format("t = {:.9g} s: the derivative is no longer finite", t_old + h));
  }
  Vector x;
  combine(
      x, x_old, h, Stages::b, 6, [&](std::size_t i) -> auto& { return f_[i]; });
  if (peaks_.any()) peaks_.advance(h, f_, slopes_);
  if ((begun_ = ends_)) {
    std::swap(f_[0], last_f_);
    std::swap(slopes_[0], last_slopes_);
  }
  return x;
}

template <class Dynamics>
std::vector<double> VariedColumns<Dynamics>::flow(const Vector& x, double t, double h) {
  using Stages = DormandPrince;
  for (std::size_t i = 0; i < trial_.size(); ++i) {
    combine(
        stage_, x, h, Stages::a[i], i, [&](std::size_t j) -> auto& { return trial_[j]; });
    trial_[i].resize(x.size());
    (*probe_)(stage_, trial_[i], t + Stages::c[i] * h);
  }
  evaluations_ += static_cast<long>(trial_.size());
  Vector y;
  combine(
      y, x, h, Stages::b, 6, [&](std::size_t i) -> auto& { return trial_[i]; });
  return y;
}

/// Adds a stage of the quadrature of the integrands and of their derivatives along seeds_. A kink of a
/// continuous integrand at an instant does not change the derivative of its integral.
template <class Dynamics>
void VariedColumns<Dynamics>::integrate(double weight, std::size_t stage, const Vector& x, double t) {
  using Of = Column::Of;
  const auto n = static_cast<std::size_t>(probe_->system.n());
  const auto value = integrands();
  const double speed = curved_speed(*probe_, x);
  add_multiple(integrals_, weight, value(*probe_, x, t));
  const auto in_column = [](const Column& c) {
    return c.of == Of::position || c.of == Of::velocity || c.of == Of::acceleration;
  };
  const bool differs = !std::ranges::all_of(integrands_, in_column);
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (!open(c)) continue;
    auto slope =
        differs ? total(c, value, x, t, seeds_[c], shifts_[c], speed, false) : Vector(integrands_.size());
    for (std::size_t i = 0; i < integrands_.size(); ++i) {
      const auto& of = integrands_[i];
      if (in_column(of))
        slope[i] = of.of == Of::acceleration ? slopes_[stage][c][n + of.index]
                                             : seeds_[c][of.index + (of.of == Of::velocity ? n : 0)];
    }
    add_multiple(integral_rates_[c], weight, slope);
  }
}

/// d(I/T) = dI/T + (c(T) − I/T) dT/T, with T the length of the run.
template <class Dynamics>
std::vector<double> VariedColumns<Dynamics>::mean_derivatives(std::size_t i, const Present& d,
                                                              const Vector& x, double begin, double end) {
  take_mode(d);
  const double length = end - begin, now = observed(integrands_[i], *probe_, x, end);
  Vector list;
  for (std::size_t c = 0; c < keys_.size(); ++c)
    list.push_back(open(c)
                       ? (integral_rates_[c][i] + (now - integrals_[i] / length) * keys_[c].end_rate) / length
                       : NAN);
  return list;
}

template <class Dynamics>
std::vector<double> VariedColumns<Dynamics>::end_derivatives(const Present& d, const Vector& x, double t,
                                                             const Function& value, double& now,
                                                             std::vector<std::string>& reasons) {
  take_mode(d);
  reasons = reasons_;
  now = value(*probe_, x, t)[0];
  Vector f(size_);
  (*probe_)(x, f, t);
  const double speed = curved_speed(*probe_, x);
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

// Search for peaks of signals along the steps (varied_peaks.hpp). A step is divided into parts that the
// low-passes need. Where the rate of a signal changes its sign within a part and the peak may be the
// greatest, the part is repeated to end there.

template <class Dynamics>
std::vector<double> VariedColumns<Dynamics>::advance_watched(double t, const Vector& x_old, double h) {
  if (!peaks_.any()) return advance_stages(t, x_old, h);
  const double parts = std::max(2.0, std::ceil(std::abs(h) / peaks_.longest()));
  auto x = x_old;
  for (double i = 0; i < parts; ++i) x = advance_part(t + i / parts * h, x, h / parts);
  return x;
}

template <class Dynamics>
std::vector<double> VariedColumns<Dynamics>::advance_part(double t, const Vector& x, double h) {
  Vector slope(size_);
  const auto rate_at = [&](std::size_t i, const Vector& y, double at) {
    (*probe_)(y, slope, at);
    return peaks_.rate(i, y, slope);
  };
  const auto begin = place();
  const auto y = advance_stages(t, x, h);
  const auto end = place();
  const Vector still(keys_.size());
  for (std::size_t i = 0; i < peaks_.size(); ++i) {
    const double after = rate_at(i, y, t + h);
    go_back(begin);
    const double before = peaks_.begins(i) ? 0 : rate_at(i, x, t), value = peaks_.value(i, x),
                 side = value < 0 ? -1 : 1;
    const double last = std::exchange(peaks_.last_rates[i], after);
    const bool possible = h > 0 && peaks_.counts(i, std::abs(value) + std::abs(before * h));
    if (possible && side * before < 0 && !(side * last < 0)) add_peak(i, t, x, 0, still);
    if (possible && side * before > 0 && side * after < 0) {
      const double root = bracketed_root(
          [&](double length) {
            go_back(begin);
            const auto at = advance_stages(t, x, length);
            return rate_at(i, at, t + length);
          },
          0.0, h, before, after);
      go_back(begin);
      const auto at = advance_stages(t, x, root);
      add_peak(i, t + root, at, 0, still);
    }
    go_back(end);
  }
  return y;
}

template <class Dynamics>
void VariedColumns<Dynamics>::add_peak(std::size_t i, double t, const Vector& x, double rate,
                                       const Vector& dt) {
  VariedPeaks::Peak peak{t, peaks_.value(i, x), {}, reasons_};
  for (std::size_t c = 0; c < keys_.size(); ++c)
    peak.slope.push_back(open(c) ? peaks_.slope(i, c, S_[c]) + rate * dt[c] : NAN);
  peaks_.add(i, std::move(peak));
}

template <class Dynamics>
void VariedColumns<Dynamics>::add_event_peaks(double t, const Vector& x, const Vector& f, const Vector& after,
                                              const Vector& f_after, const Vector& dt) {
  const auto modes = peaks_.modes;
  for (std::size_t i = 0; i < peaks_.size(); ++i) {
    const double before = peaks_.rate(i, x, f), side = peaks_.value(i, x) < 0 ? -1 : 1;
    peaks_.jump(x, after);
    const double rate = peaks_.rate(i, after, f_after);
    peaks_.modes = modes;
    peaks_.last_rates[i] = rate;
    if (side * before > 0 && side * rate <= 0) add_peak(i, t, x, before, dt);
  }
}

template <class Dynamics>
VariedPeaks::Peak VariedColumns<Dynamics>::peak(std::size_t i, const Present& d, const Vector& x, double t) {
  take_mode(d);
  Vector f(size_), end_rates;
  (*probe_)(x, f, t);
  for (const auto& key : keys_) end_rates.push_back(key.end_rate);
  const double rate = peaks_.rate(i, x, f);
  if (rate * peaks_.value(i, x) >= 0) add_peak(i, t, x, rate, end_rates);
  return peaks_.greatest(i);
}

template class VariedColumns<EventDynamics>;
template class VariedColumns<ExtendedPenalty>;

}  // namespace freeplay
