// Contact onsets of StepVariation: single impacts, and contacts that last.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formulations/variation/step_variation.hpp"

namespace freeplay {
namespace {

/// Change of a contact's rate by an impact, over the approach of that impact, from which it takes part.
constexpr double least_share = 1e-9;

}  // namespace

/// Passes the contact onsets of a step. Returns the time reached.
double StepVariation::cross_onsets(const Step& s, const Step* next, Vector& x) {
  const auto& system = mode_.system;
  const int n = system.n();
  const double h = s.t - s.t_old;
  std::vector<Impact> list;
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& c = s.contacts[static_cast<std::size_t>(k)];
    if (!c.onset || (count_ == 1 && mode_.contacts[k].closed) || closes_again(s, k)) continue;
    const auto gap = [&](const Vector& y, double at) {
      const auto& row = probe_->look(k, y, at);
      return std::pair{row.gap, row.normal.dot(y.data() + n)};
    };
    // A bounce that is shorter than the steps may have its highest point in this one.
    const double from = gap(x, s.t_old).second < 0 ? 0 : h;
    const auto tau = root_within(x, s.t_old, 1.5 * h, gap, from);
    if (!tau) {
      const auto why = fmt::format(
          "t = {:.9g} s: contact {} is pressed without approach, or its gap does not "
          "close within the step; use a smaller nonsmooth.step",
          s.t_old, system.contact_facts(k).name);
      refuse(why);
      record(s, k, why);
      continue;
    }
    const auto after = next ? next->contacts[static_cast<std::size_t>(k)] : Contact{};
    list.push_back({k, s.t_old + *tau, after.pressed && !after.onset});
  }
  std::ranges::sort(list, {}, &Impact::t);
  if (list.size() > 1) {
    std::vector<int> onsets, closed;
    for (const auto& i : list) onsets.push_back(i.contact);
    for (int k = 0; k < system.contacts(); ++k)
      if (mode_.contacts[k].closed) closed.push_back(k);
    if (coupled(x, s.t_old, {}, onsets, closed))
      refuse(
          fmt::format("t = {:.9g} s: contacts {} and {} have impacts within one step that act on each other; "
                      "use a smaller nonsmooth.step",
                      s.t_old, system.contact_facts(onsets[0]).name, system.contact_facts(onsets[1]).name));
  }
  double t = s.t_old;
  for (const auto& impact : list) {
    advance(x, t, impact.t);
    cross_impact(s, next, impact, &impact == &list.back(), x);
  }
  return t;
}

/// Whether a contact that has been closed closes again before a flight could be resolved. It stays closed.
bool StepVariation::closes_again(const Step& s, int k) {
  const auto& x = s.x_old;
  if (count_ - last_closed_[static_cast<std::size_t>(k)] > unresolved_steps) return false;
  const double rate = probe_->look(k, x, s.t_old).normal.dot(x.data() + mode_.system.n());
  const double closing = probe_->gap_acceleration(k, x, s.t_old);
  if (!(-rate <= unresolved_flight * std::abs(closing) * (s.t - s.t_old))) return false;
  mode_.contacts[k].closed = true;
  mode_.contacts[k].slip = s.contacts[static_cast<std::size_t>(k)].slip;
  begin_mode();
  project_columns(x, s.t_old);
  record(s, k,
         fmt::format("t = {:.9g} s: contact {} closes again before its flight is resolved by the steps",
                     s.t_old, mode_.system.contact_facts(k).name));
  return true;
}

/// One impact, or the onset of a lasting contact, at the state x, which is replaced by the state after it.
void StepVariation::cross_impact(const Step& s, const Step* next, const Impact& impact, bool last,
                                 Vector& x) {
  const auto& system = mode_.system;
  const int k = impact.contact, n = system.n();
  const double t = impact.t, h = s.t - s.t_old;
  const auto& c = s.contacts[static_cast<std::size_t>(k)];
  const auto& name = system.contact_facts(k).name;
  begin_mode();
  const bool at_start = count_ == 1 && std::ranges::find(at_start_, k) != at_start_.end();
  const ModeEvent event{at_start ? ModeEvent::Kind::none : ModeEvent::Kind::gap, k, t};
  std::vector<int> in_impact, ended;
  for (int j = 0; j < system.contacts(); ++j)
    if (mode_.contacts[j].closed || j == k) in_impact.push_back(j);
  if (impact.lasting) {
    ended.push_back(k);
    const double closing = probe_->gap_acceleration(k, x, t);
    if (c.leaving > unresolved_flight * std::abs(closing) * h)
      refuse(
          fmt::format("t = {:.9g} s: contact {} rebounds and is pressed again within one step; use a smaller "
                      "nonsmooth.step",
                      t, name));
  }
  auto after = x;
  mode_.project(after, t);
  mode_.measure_speeds(after);
  impacts_.touching(mode_, after, t, event);
  const auto pushed = after;
  if (const auto why = mode_.apply_impact(after, t, {in_impact, ended}); !why.empty())
    refuse(fmt::format("t = {:.9g} s: {}", t, why));
  for (int j = 0; next && j < system.contacts(); ++j) {
    auto& m = mode_.contacts[j];
    const auto& to = next->contacts[static_cast<std::size_t>(j)];
    if (j == k) {
      m.closed = impact.lasting;
      m.slip = to.slip;
      continue;
    }
    if (!m.closed) continue;
    const auto& row = probe_->look(j, pushed, t);
    const double *v = pushed.data() + n, *w = after.data() + n;
    const double change = std::max(std::abs(row.normal.dot(w) - row.normal.dot(v)),
                                   std::abs(row.tangent.dot(w) - row.tangent.dot(v)));
    if (!last && change <= least_share * std::abs(c.rate)) continue;
    m.closed = to.pressed;
    if (to.pressed) m.slip = to.slip;
  }
  for (std::size_t j = 0; next && last && j < s.slips.size(); ++j) mode_.preloaded[j].slip = next->slips[j];
  mode_.project(after, t);
  const auto known = onsets_.size();
  cross_event(mode_, {event, t, x, after, in_impact, ended, impacts_});
  if (onsets_.size() == known)
    record(s, k, fmt::format("t = {:.9g} s: contact {} closes without approach", t, name));
  auto& onset = onsets_.back();
  onset.t = c.t;
  onset.rate = c.rate;
  onset.impulse = c.impulse;
  onset.lasting = impact.lasting;
  begin_mode();
  project_columns(after, t);
  x = after;
}

/// A contact onset without derivatives.
void StepVariation::record(const Step& s, int k, const std::string& why) {
  const auto& c = s.contacts[static_cast<std::size_t>(k)];
  const Vector unknown(keys_.size(), NAN);
  Onset onset{k, false, c.t, c.rate, c.impulse, unknown, unknown, unknown, reasons_};
  for (auto& reason : onset.reasons)
    if (reason.empty()) reason = why;
  onsets_.push_back(std::move(onset));
}

}  // namespace freeplay
