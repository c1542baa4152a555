#include "formulations/variation/predicted_growth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/system.hpp"
#include "formulations/event_driven/event_driven.hpp"
#include "formulations/variation/differences.hpp"

namespace freeplay {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

/// Change of an approach rate in the differences of an impact law, relative.
constexpr double small_change = 1e-3;

/// ln|det A| as the sum of the logarithms of the lengths that orthogonalisation leaves; −∞ if a column
/// has collapsed into the span of those before it.
double log_volume(MatrixXd A) {
  double sum = 0;
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    for (int pass = 0; pass < 2; ++pass)
      for (Eigen::Index i = 0; i < j; ++i) {
        const double part = A.col(i).dot(A.col(j));
        A.col(j) -= part * A.col(i);
      }
    const double length = A.col(j).norm();
    if (!(length > collapsed_share)) return -INFINITY;
    sum += std::log(length);
    A.col(j) /= length;
  }
  return sum;
}

}  // namespace

bool reduces_coordinates(const EventDynamics& d) {
  return std::ranges::any_of(d.contacts, [](const auto& c) { return c.closed; }) ||
         std::ranges::any_of(d.preloaded, [](const auto& p) { return p.slip == 0; });
}

PredictedGrowth::PredictedGrowth(const OwnCoordinates& own, std::vector<double> restitution,
                                 const EventDriven& scheme, std::shared_ptr<SystemTangent> traced)
    : own_(own),
      restitution_(std::move(restitution)),
      probe_(scheme.dynamics().twin()),
      system_(probe_->system),
      dissipates_(system_.has_velocity_forces() || system_.states() > 0 || system_.has_velocity_flows() ||
                  probe_->films.any()) {
  probe_->use_tangent(std::move(traced));
  if (reduces_coordinates(scheme.dynamics()))
    leave_unknown("contacts last or joints stick, without own coordinates");
}

void PredictedGrowth::end_step(const EventDriven& scheme) {
  const double begin = scheme.t_old(), h = scheme.t() - begin;
  if (!dissipates_ || !(h > 0) || !logs_.unknown.empty()) return;
  // Gauss's rule of three points; the mode of the step is still present.
  take_varied_mode(*probe_, scheme.dynamics());
  const double off = std::sqrt(0.15) * h, middle = begin + 0.5 * h;
  double sum = 0;
  for (const auto& [t, weight] : {std::pair{middle - off, 5.0}, {middle, 8.0}, {middle + off, 5.0}})
    sum += weight * divergence(Vector(scheme.x_at(t)), t);
  logs_.flow += sum * h / 18;
}

/// tr(Zᵀ ∂F/∂v Z) + tr(∂ż/∂z), without tangent vectors.
double PredictedGrowth::divergence(const Vector& x, double t) {
  const auto Z = own_.motions(x, t);
  const int n = system_.n();
  const auto motions = static_cast<std::size_t>(Z.cols()),
             states = static_cast<std::size_t>(system_.states());
  const auto flows = static_cast<std::size_t>(probe_->state_offset());
  std::vector<Vector> along(motions + states, Vector(x.size()));
  for (int i = 0; i < n; ++i)
    for (std::size_t j = 0; j < motions; ++j)
      along[j][n + i] = Z(i, static_cast<Eigen::Index>(j)) / std::sqrt(system_.mass()[i]);
  for (std::size_t k = 0; k < states; ++k) along[motions + k][flows + k] = 1;
  auto change = along;
  probe_->directional(x, t, along, change);
  double sum = 0;
  for (std::size_t j = 0; j < motions; ++j)
    for (int i = 0; i < n; ++i)
      sum += Z(i, static_cast<Eigen::Index>(j)) * std::sqrt(system_.mass()[i]) * change[j][n + i];
  for (std::size_t k = 0; k < states; ++k) sum += change[motions + k][flows + k];
  return sum;
}

/// The contribution of an event. `probe_` has the mode before.
void PredictedGrowth::cross_event(const EventDynamics& d, const Variation::ProcessedEvent& p) {
  if (!logs_.unknown.empty()) return;
  std::vector<int> onsets;
  for (const int k : p.in_impact)
    if (!probe_->contacts[k].closed && p.impacts.rate(k) < -d.speed_tolerance()) onsets.push_back(k);
  if (reduces_coordinates(d))
    return leave_unknown(
        fmt::format("t = {:.9g} s: a contact lasts or a joint sticks; the volume of all own coordinates "
                    "vanishes",
                    p.t));
  if (!onsets.empty()) return cross_impact(d, p, onsets);
  if (p.event.kind != ModeEvent::Kind::slide_slip) return;
  // The sliding of a joint is reversed without sticking.
  const int k = p.event.index;
  const auto after = d.twin();
  take_varied_mode(*after, d);
  const auto acceleration = [&](EventDynamics& f, const Vector& x) {
    Vector rate(x.size());
    f(x, rate, p.t);
    const double h = 1e-6 * own_.time();
    const auto at = [&](double s) {
      auto y = x;
      for (std::size_t i = 0; i < y.size(); ++i) y[i] += s * rate[i];
      return f.slide_rate(k, y, p.t + s);
    };
    return (at(h) - at(-h)) / (2 * h);
  };
  logs_.impacts += std::log(std::abs(acceleration(*after, p.after) / acceleration(*probe_, p.before)));
}

void PredictedGrowth::cross_impact(const EventDynamics& d, const Variation::ProcessedEvent& p,
                                   const std::vector<int>& onsets) {
  const int n = system_.n();
  const auto rate = [&](int k, const Vector& x) { return probe_->look(k, x, p.t).normal.dot(x.data() + n); };
  if (p.in_impact.size() == 1 && probe_->look(onsets[0], p.before, p.t).tangent.size == 0 &&
      !probe_->contacts[onsets[0]].by_speed) {
    logs_.impacts += 2 * std::log(restitution_[static_cast<std::size_t>(onsets[0])]);
    return;
  }
  double approach = INFINITY, sum = 0;
  for (const int k : onsets) {
    sum += std::log(std::abs(rate(k, p.after) / rate(k, p.before)));
    approach = std::min(approach, std::abs(rate(k, p.before)));
  }
  const auto Z = own_.motions(p.before, p.t);
  const auto after_impact = [&](const Vector& y) {
    auto z = y;
    if (!probe_->apply_impact(z, p.t, {p.in_impact, p.ended}).empty()) z.assign(z.size(), NAN);
    return Vector(z.begin() + n, z.begin() + 2 * n);
  };
  const auto centre = after_impact(p.before);
  MatrixXd map(Z.cols(), Z.cols());
  for (Eigen::Index j = 0; j < Z.cols(); ++j) {
    Vector along(p.before.size());
    for (int i = 0; i < n; ++i) along[n + i] = Z(i, j) / std::sqrt(system_.mass()[i]);
    double most = 0;
    for (const int k : p.in_impact) {
      const auto& row = probe_->look(k, p.before, p.t);
      most = std::max(
          {most, std::abs(row.normal.dot(along.data() + n)), std::abs(row.tangent.dot(along.data() + n))});
    }
    if (most == 0) most = 1;
    const double h = small_change * approach / most;
    const auto change = difference(h, centre, [&](std::size_t i) {
      auto y = p.before;
      for (int k = 0; k < n; ++k) y[n + k] += difference_places[i] * h * along[n + k];
      return after_impact(y);
    });
    VectorXd weighted(n);
    for (int i = 0; i < n; ++i) weighted[i] = std::sqrt(system_.mass()[i]) * change.slope[i];
    map.col(j) = Z.transpose() * weighted;
  }
  sum += log_volume(map);
  if (!std::isfinite(sum))
    leave_unknown(
        fmt::format("t = {:.9g} s: the impact without rebound or with sticking in contact {} "
                    "reduces the own coordinates",
                    p.t, d.system.contact_facts(onsets[0]).name));
  else
    logs_.impacts += sum;
}

}  // namespace freeplay
