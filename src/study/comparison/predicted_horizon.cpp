#include "study/comparison/predicted_horizon.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "analysis/growth.hpp"
#include "mechanism/scene.hpp"
#include "simulation/touches.hpp"

namespace freeplay {
namespace {

/// An onset of the event-driven run is that of the nonsmooth run if their times differ by less than this
/// share of the time since the onset before: steps of time stepping displace onsets.
constexpr double same_onset = 0.05;

/// The paired impacts of each contact, with their mean at the end.
struct PenaltyImpact {
  ImpactError error;
  double duration = 0;  ///< s
};
std::vector<std::vector<PenaltyImpact>> impacts_of(const PredictionBasis& basis) {
  const auto contacts = basis.restitution.size();
  std::vector<std::vector<PenaltyImpact>> list(contacts);
  std::vector<PenaltyImpact> sums(contacts + 1);
  std::vector<double> counts(contacts + 1);
  for (const auto& pair : basis.pairing.pairs) {
    const auto &a = pair.penalty, &b = pair.nonsmooth;
    const auto k = static_cast<std::size_t>(b.contact);
    PenaltyImpact i;
    if (a.kind == EventKind::impact && a.v_n_minus < 0) {
      const double e = std::max(0.0, -a.v_n_plus / a.v_n_minus);
      i = {{a.duration * e / (1 + e), (e - basis.restitution[k]) / (1 + basis.restitution[k])}, a.duration};
      for (const auto place : {k, contacts}) {
        sums[place].error.delay += i.error.delay;
        sums[place].error.excess += i.error.excess;
        sums[place].duration += i.duration;
        ++counts[place];
      }
    }
    list[k].push_back(i);
  }
  for (std::size_t k = 0; k < contacts; ++k) {
    const auto from = counts[k] > 0 ? k : contacts;
    const double count = std::max(1.0, counts[from]);
    list[k].push_back(
        {{sums[from].error.delay / count, sums[from].error.excess / count}, sums[from].duration / count});
  }
  return list;
}

/// The events of the nonsmooth run, displaced by the differences, up to the first one that a difference
/// displaces by more than the rule of compare admits in any case. `until`: time up to which all are known.
std::vector<ContactEvent> displaced(const PredictionBasis& basis, const Growth& growth,
                                    const std::vector<std::vector<PenaltyImpact>>& impacts, double& until) {
  std::vector<ContactEvent> list;
  std::vector<std::size_t> next(basis.restitution.size()), count(next);
  std::vector<double> change(basis.restitution.size()), last(change);
  for (auto e : basis.nonsmooth) {
    if (e.t >= until) break;
    const auto k = static_cast<std::size_t>(e.contact);
    if (is_onset(e)) {
      auto& i = next[k];
      const double near = same_onset * (e.t - last[k]);
      while (i < growth.onsets.size() &&
             (growth.onsets[i].contact != e.contact || growth.onsets[i].t < e.t - near))
        ++i;
      if (i == growth.onsets.size() || growth.onsets[i].t > e.t + near) {
        until = e.t;
        break;
      }
      const auto& o = growth.onsets[i++];
      change[k] = o.t_change;
      if (std::abs(o.t_change) > 0.25 * (e.t - last[k])) {
        until = std::nextafter(e.t, INFINITY);
        change[k] = std::abs(o.t_change);  // it does not overtake the events before
      }
      last[k] = e.t;
      e.v_n_minus += o.rate_change;
      e.v_n_plus -= basis.restitution[k] * o.rate_change;
      if (e.kind == EventKind::impact)
        e.duration = impacts[k][std::min(count[k]++, impacts[k].size() - 1)].duration;
    }
    e.t += change[k];
    list.push_back(e);
  }
  return list;
}

}  // namespace

PredictedHorizon predict_horizon(const Scene& scene, const PredictionBasis& basis, const StopToken& stop) {
  PredictedHorizon p;
  if (basis.pairing.pairs.empty()) {
    p.reason = "no contact events are paired";
    return p;
  }
  const auto impacts = impacts_of(basis);
  GrowthRequest request{.errors = std::vector<std::vector<ImpactError>>(impacts.size()),
                        .restitution = basis.restitution,
                        .end = basis.end,
                        .most_evaluations = basis.most_evaluations,
                        .stop = stop};
  for (std::size_t k = 0; k < impacts.size(); ++k)
    for (const auto& i : impacts[k]) request.errors[k].push_back(i.error);
  try {
    const auto growth = growth_of_impact_errors(scene, request);
    double until = growth.ended.empty() ? INFINITY : growth.until;
    const auto moved = displaced(basis, growth, impacts, until);
    const auto pairs =
        pair_impacts(moved, basis.nonsmooth, static_cast<int>(basis.restitution.size()), until, basis.turn);
    p.to_the_end = pairs.complete;
    if (pairs.cut)
      p.reason = growth.ended.empty() ? "the event-driven run has other contact events" : growth.ended;
    else
      p.t = pairs.horizon;
  } catch (const ModelError& error) {
    p.reason = error.what();
  }
  return p;
}

}  // namespace freeplay
