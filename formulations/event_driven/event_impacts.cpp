#include "formulations/event_driven/event_impacts.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {
namespace {

bool contains(const std::vector<int>& list, int k) { return std::ranges::find(list, k) != list.end(); }

/// Height (m) up to which a bounce ends the accumulation.
double least_bounce(const EventDynamics& d, int k, const std::vector<double>& x) {
  return std::max(1e-9 * d.system.contact_facts(k).clearance, 1e3 * gap_rounding(d.system, k, x.data()));
}

}  // namespace

EventImpacts::EventImpacts(int contacts, double position_error) : position_error_(position_error) {
  for (auto* x : {&rate_, &sliding_, &ending_}) x->resize(static_cast<std::size_t>(contacts));
}

std::vector<int> EventImpacts::touching(EventDynamics& d, const Vector& x, double t, const ModeEvent& event) {
  const double* v = x.data() + d.system.n();
  std::vector<int> list;
  for (int k = 0; k < d.system.contacts(); ++k) {
    const auto& row = d.look(k, x, t);
    rate_[k] = row.normal.dot(v);
    sliding_[k] = row.tangent.dot(v);
    ending_[k] = 0;
    const bool here = event.kind == ModeEvent::Kind::gap && event.index == k;
    const double near = std::max({1e-10 * d.system.contact_facts(k).clearance, position_error_,
                                  8 * gap_rounding(d.system, k, x.data())}) +
                        1e-14 * d.system.longest_arm();
    // If contacts have alternating impacts at one instant, separating contacts take part too:
    // without approach, they are only prevented from approaching.
    const bool crowded = crowd_ >= 8;
    if (d.contacts[k].closed || here ||
        (row.normal.size > 0 && row.gap <= near && (crowded || rate_[k] <= d.speed_tolerance())))
      list.push_back(k);
  }
  return list;
}

std::string EventImpacts::solve(EventDynamics& d, Vector& x, double t, const ModeEvent& event,
                                std::vector<int>& touching, EventPace& pace, EventFindings& findings,
                                WatchedForces& forces) {
  thrown_.clear();
  in_impact_.clear();
  ended_.clear();
  const double tiny = d.speed_tolerance();
  const auto& system = d.system;
  const double* v = x.data() + system.n();
  std::vector<int> approaching;
  std::ranges::copy_if(touching, std::back_inserter(approaching), [&](int k) { return rate_[k] < -tiny; });
  if (approaching.empty()) return stay(d, x, t, event, touching);
  // Approaching contacts have an impact at the same time as the one whose gap reached zero.
  if (touching.size() > 1)
    for (const int k : approaching)
      if (!d.contacts[k].closed) findings.merged = std::max(findings.merged, std::abs(d.look(k, x, t).gap));
  crowd_ = t - last_ <= pace.instant() ? crowd_ + 1 : 0;
  last_ = t;
  const auto before = x;
  const double loss_before = d.contact_loss;
  EventFindings::Unloaded unloaded_ones;
  const auto apply_impact = [&](const std::vector<int>& soft) {
    auto reason = d.apply_impact(x, t, {touching, soft});
    if (!reason.empty()) return reason;
    unloaded_ones = unloaded(d, t, event, touching);
    forces.apply_impact(d, x, touching);
    return reason;
  };
  if (auto reason = apply_impact({}); !reason.empty()) return reason;
  const auto leaving = [&](int k) { return d.look(k, x, t).normal.dot(v) > tiny; };
  auto staying = touching;
  std::erase_if(staying, leaving);
  if (auto reason = pace.impact(t, approaching); !reason.empty()) return reason;
  findings.most_kinetic = std::max(findings.most_kinetic, system.kinetic(before.data() + system.n()));
  std::vector<int> over;
  // One pass or, if contacts push each other apart, until no further bounces end.
  for (std::size_t round = 0; round <= touching.size(); ++round) {
    const auto known = over.size();
    thrown_.clear();
    if (auto reason = end_bounces(d, x, t, touching, staying, over); !reason.empty()) return reason;
    if (over.size() == known) break;
    x = before;
    d.contact_loss = loss_before;
    if (auto reason = apply_impact(over); !reason.empty()) return reason;
    staying = touching;
    std::erase_if(staying, leaving);
    if (touching.size() < 3) break;
  }
  forces.keep_impact();
  if (findings.unloaded.count == 0) findings.unloaded = unloaded_ones;
  const double kinetic = system.kinetic(before.data() + system.n());
  const auto& impact = d.last_impact();
  if (impact.inelastic()) findings.inelastic.take(kinetic - system.kinetic(v));
  d.extremes.count_gain(impact.normal_work() + impact.tangential_work(), kinetic, 1e-12);
  for (const int k : thrown_)
    if (!contains(staying, k)) staying.push_back(k);
  std::ranges::sort(staying);
  in_impact_.swap(touching);
  ended_ = over;
  touching = staying;
  return "";
}

/// Without an impact: closed contacts do not separate because of their drift, but only because of
/// their force.
std::string EventImpacts::stay(EventDynamics& d, const Vector& x, double t, const ModeEvent& event,
                               std::vector<int>& touching) const {
  const auto held = [&](int k) {
    return d.contacts[k].closed && !(event.kind == ModeEvent::Kind::force && event.index == k);
  };
  std::erase_if(touching, [&](int k) { return rate_[k] > d.speed_tolerance() && !held(k); });
  // A gap may close within rounding while it opens. If its motion is too small for a bounce, the
  // contact stays closed.
  const int k = event.kind == ModeEvent::Kind::gap ? event.index : -1;
  if (k < 0 || contains(touching, k)) return "";
  if (auto reason = d.choose(x, t, touching); !reason.empty() && !d.locked_up()) return reason;
  const double g = d.locked_up() ? 0 : d.gap_acceleration(k, x, t), u = rate_[k];
  if (g < 0 && 0.5 * u * u / -g <= least_bounce(d, k, x)) touching.push_back(k);
  std::ranges::sort(touching);
  return "";
}

/// Among the separating contacts of the impact, finds those whose bounces end, and sets their
/// remaining time in ending_.
std::string EventImpacts::end_bounces(EventDynamics& d, const Vector& x, double t,
                                      const std::vector<int>& in_impact, const std::vector<int>& staying,
                                      std::vector<int>& over) {
  auto held = staying;
  decided_ = staying;
  // A contact that stays closed may keep others closed, as a peg that presses a wall without other
  // load: repeat until none is added.
  for (std::size_t round = 0; round < in_impact.size(); ++round) {
    bool chosen = false, added = false;
    for (const int k : in_impact) {
      if (contains(held, k)) continue;
      const double u = d.look(k, x, t).normal.dot(x.data() + d.system.n());
      // A contact that already had its impact without restitution and still separates is pushed
      // away by its neighbours.
      const bool bounced = rate_[k] < -d.speed_tolerance() && !contains(over, k);
      const double e = bounced ? u / -rate_[k] : 0;
      if (!(e < 1)) continue;
      if (!chosen)
        if (auto reason = d.choose(x, t, decided_); !reason.empty())
          // In a lockup the closing accelerations are unknown, and no bounce ends here.
          return d.locked_up() ? "" : reason;
      chosen = true;
      const double g = d.gap_acceleration(k, x, t);
      if (!(g < 0) || 0.5 * u * u / -g > least_bounce(d, k, x)) continue;
      (bounced ? over : thrown_).push_back(k);
      ending_[k] = bounced ? 2 * u / -g / (1 - e) : 0;
      held.push_back(k);
      added = true;
    }
    if (!added) break;
    std::ranges::sort(held);
    decided_ = held;
  }
  return "";
}

/// Finds the contacts of the last impact that neither approached nor had a load before it, and have
/// an impulse in it. In an impact without them they would approach afterwards: the motion depends
/// on whether their gaps are zero.
EventFindings::Unloaded EventImpacts::unloaded(const EventDynamics& d, double t, const ModeEvent& event,
                                               const std::vector<int>& in_impact) const {
  double greatest = 0;
  for (const int k : in_impact) greatest = std::max(greatest, std::abs(rate_[k]));
  EventFindings::Unloaded found;
  for (std::size_t i = 0; i < in_impact.size(); ++i) {
    const int k = in_impact[i];
    const bool located = event.kind == ModeEvent::Kind::gap && event.index == k;
    if (d.contacts[k].closed || located || rate_[k] < -d.speed_tolerance() ||
        d.last_impact().own_rate(d, i) <= 1e-9 * greatest)
      continue;
    if (found.count++ == 0) {
      found.contact = k;
      found.t = t;
    }
    found.gap = std::max(found.gap, std::abs(d.contacts[k].row.gap));
  }
  return found;
}

}  // namespace freeplay
