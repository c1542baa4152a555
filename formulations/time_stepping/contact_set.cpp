#include "formulations/time_stepping/contact_set.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formulations/time_stepping/step_text.hpp"

namespace freeplay {

ImpulseResponses::ImpulseResponses(const System& system, int rows, bool many)
    : n_(system.n()), m_(system.rows()), many_(many), rows_(rows), sparse_(many ? rows : 0) {
  if (!many) {
    response_.resize(static_cast<std::size_t>(rows) * system.n());
    reaction_.resize(static_cast<std::size_t>(rows) * system.rows());
    return;
  }
  taken_.resize(static_cast<std::size_t>(rows));
  int next = 0;
  for (int k = 0; k < system.contacts(); ++k) {
    first_.push_back(next);
    next += system.has_friction(k) ? 2 : 1;
  }
  for (int k = 0; k < system.frictions(); ++k) friction_.push_back(next++);
}

void ImpulseResponses::begin(SaddlePoint& saddle) {
  if (!many_) return;
  sparse_.use(saddle);
  std::ranges::fill(taken_, 0);
}

void ImpulseResponses::respond(SaddlePoint& saddle, int place) {
  if (!many_) {
    saddle.respond(rows_[place], nullptr, 0, response(place), reaction(place),
                   SaddlePoint::Multipliers::kept);
  } else if (!taken_[place]) {
    sparse_.take(place, rows_[place]);
    taken_[place] = 1;
  }
}

void ImpulseResponses::respond(SaddlePoint& saddle, int place, const SparseRow* beside, double factor) {
  if (many_)
    sparse_.take(place, rows_[place], beside, factor);
  else
    saddle.respond(rows_[place], beside, factor, response(place), reaction(place));
}

double ImpulseResponses::along(const SparseRow& row, int place) const {
  return many_ ? sparse_.along(row, place) : row.dot(response(place));
}

void ImpulseResponses::push(int place, double by, double* x) const {
  if (many_) {
    sparse_.add(place, by, x);
    return;
  }
  for (int i = 0; i < n_; ++i) x[i] += by * response(place)[i];
}

void ImpulseResponses::add_contact() {
  const auto first = static_cast<int>(rows_.size()), rows = first + 2;
  first_.push_back(first);
  taken_.resize(static_cast<std::size_t>(rows));
  sparse_.make_room(rows);
  rows_.resize(static_cast<std::size_t>(rows));
}

void ImpulseResponses::keep_contacts(int contacts) {
  const auto kept = static_cast<std::size_t>(contacts);
  rows_.resize(rows_.size() - 2 * (first_.size() - kept));
  first_.resize(kept);
}

void ImpulseResponses::renew(int contact) { std::fill_n(taken_.begin() + first_[contact], 2, 0); }

ContactSet::ContactSet(const System& system, const std::vector<double>& restitution, double step)
    : system_(system), step_(step), contacts_(system.contacts()), a_gamma_(system.n()) {
  for (int k = 0; k < system.contacts(); ++k) {
    live_.push_back(k);
    set_restitution(k, restitution[k]);
  }
  if (system.families().empty()) return;
  near_ = std::make_unique<Near>(system);
  near_->restitution.assign(restitution.begin() + system.contacts(), restitution.end());
}

void ContactSet::set_restitution(int k, double restitution) {
  auto& c = contacts_[k];
  c.restitution = restitution;
  const auto& surface = facts(k).surface;
  c.by_speed = surface.restitution_by_speed() ? &surface : nullptr;
  by_speed_ |= c.by_speed != nullptr;
}

/// Called with s.end evaluated at the start.
void ContactSet::start(StepData& s, ImpulseResponses& responses) {
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = contacts_[k];
    c.gap = system_.gap(k, s.q.data(), s.end);
    c.t_left = c.gap > 0 ? s.t : -INFINITY;
    c.closed = false;
  }
  if (!near_) return;
  auto& list = near_->neighbours;
  list.find(s.q.data(), list.advised(2 * step_ * list.fastest(s.v.data())));
  give_slots(s.q.data(), s, responses);
  for (const int k : slot_contacts()) contacts_[k].t_left = contacts_[k].gap > 0 ? s.t : -INFINITY;
}

void ContactSet::look_at_rows(StepData& s, ImpulseResponses& responses) {
  for (const int k : live_) look(k, s.q_mid.data(), s.v_old.data(), s.middle, contacts_[k].row);
  keep_near(s.length(), s.q_old.data(), s.v_old.data(), s.v_old.data(), s, responses);
}

void ContactSet::begin(const StepData& s, bool many) {
  for (const int k : live_) {
    auto& c = contacts_[k];
    c.in_impact = false;
    c.active = many && c.steps > 1 && c.last_n > 0 && c.row.normal.size > 0 && in_reach(c, s.reach);
  }
}

bool ContactSet::activate(StepData& s, ImpulseResponses& responses) {
  const double h = s.length();
  bool added = false;
  waiting_ = near_ != nullptr;
  keep_near(h, s.q_old.data(), s.v_old.data(), s.v.data(), s, responses);
  for (const int k : live_) {
    auto& c = contacts_[k];
    if (c.active || c.row.normal.size == 0 || !in_reach(c, s.reach)) continue;
    added |= c.active = gap_at_end(c.row, c.row.normal.dot(s.v.data()), h) <= (c.closed ? slack : 0);
    waiting_ |= !c.active;
  }
  return added;
}

/// A contact is in impact if it was open before and approaches faster than rows rotate within the
/// step. A slower contact has only just separated from a lasting contact, and continues it.
bool ContactSet::find_impacts(StepData& s) {
  const double h = s.length();
  bool any = false;
  const auto approach = [&](const StepContact& c) { return -c.row.normal.dot(s.v_old.data()); };
  for (const int k : live_) {
    auto& c = contacts_[k];
    if (!c.active) continue;
    c.bias_n = rate_bias(c.row.gamma_n, h);
    c.bias_t = rate_bias(c.row.gamma_t, h);
    c.in_impact = s.reach == StepReach::all && c.steps == 0 && approach(c) > 10 * std::abs(c.bias_n);
    any |= c.in_impact;
  }
  if (!any) return false;
  if (system_.rows() == 0)
    std::ranges::fill(a_gamma_, 0.0);
  else
    s.saddle.solve(nullptr, s.middle.gamma.data(), a_gamma_.data(), s.dlambda.data(),
                   SaddlePoint::Multipliers::kept);
  any = false;
  for (const int k : live_) {
    auto& c = contacts_[k];
    if (!c.active || !c.in_impact) continue;
    const double bias = rate_bias(c.row.normal.dot(a_gamma_.data()), h);
    c.in_impact = approach(c) > 10 * std::abs(bias);
    if (!c.in_impact) continue;
    any = true;
    c.bias_n = bias;
    if (c.row.tangent.size > 0) c.bias_t = rate_bias(c.row.tangent.dot(a_gamma_.data()), h);
  }
  return any;
}

void ContactSet::look(int k, const double* q, const double* v, const Evaluation& e, ContactRow& row) const {
  if (!has_slot(k)) return system_.contact(k, q, v, e, row);
  System::contact(shape(k), facts(k), q, v, e, row);
}

double ContactSet::gap(int k, const double* q, const Evaluation& e) const {
  return has_slot(k) ? System::gap(shape(k), q, e) : system_.gap(k, q, e);
}

void ContactSet::renew_pairs(double h, const double* q, const double* v0, const double* v1, StepData& s,
                             ImpulseResponses& responses) {
  auto& list = near_->neighbours;
  const double moved = list.moved(q, h, v0, v1);
  if (moved < list.reach() || !std::isfinite(moved)) return;
  // From here on only the motion of the present step counts.
  const double ahead =
      h > 0 ? h * std::max(list.fastest(v0), list.fastest(v1)) : step_ * list.fastest(s.v.data());
  list.find(q, list.advised(2 * ahead));
  give_slots(q, s, responses);
}

/// Gives slots to new pairs of the list and frees the slots of pairs that left it. A pair in
/// contact keeps its slot.
void ContactSet::give_slots(const double* q, StepData& s, ImpulseResponses& responses) {
  auto& near = *near_;
  const int own = system_.contacts();
  const auto& found = near.neighbours.found();
  near.kept.assign(live_.begin() + own, live_.end());
  live_.resize(static_cast<std::size_t>(own));
  const auto leave = [&](int k) {
    if (contacts_[k].steps > 0 || s.log->is_open(k) || contacts_[k].last_n > 0) {
      live_.push_back(k);
      return;
    }
    contacts_[k] = {};
    near.free.push_back(k);
  };
  std::size_t old = 0;
  for (const auto& wanted : found) {
    while (old < near.kept.size() && pair(near.kept[old]) < wanted) leave(near.kept[old++]);
    if (old < near.kept.size() && pair(near.kept[old]) == wanted) {
      live_.push_back(near.kept[old++]);
      continue;
    }
    const int k = new_slot(s, responses);
    const auto& family = system_.families()[static_cast<std::size_t>(wanted.family)];
    near.slots[static_cast<std::size_t>(k - own)] = {wanted, family.pair(wanted.i, wanted.j)};
    auto& c = contacts_[k];
    set_restitution(k, near.restitution[static_cast<std::size_t>(wanted.family)]);
    c.gap = gap(k, q, s.end);
    c.t_left = -INFINITY;  // the flight before is long
    look(k, s.q_mid.data(), s.v_old.data(), s.middle, c.row);
    responses.renew(k);
    live_.push_back(k);
  }
  while (old < near.kept.size()) leave(near.kept[old++]);
}

/// Returns a free slot, or adds one with room for its rows.
int ContactSet::new_slot(StepData& s, ImpulseResponses& responses) {
  auto& near = *near_;
  if (!near.free.empty()) {
    const int k = near.free.back();
    near.free.pop_back();
    return k;
  }
  near.slots.emplace_back();
  const int k = static_cast<int>(contacts_.size());
  contacts_.emplace_back();
  s.log->make_room(k);
  responses.add_contact();
  return k;
}

/// Rebuilds the data of the slots after they have been restored from a snapshot.
void ContactSet::take_slots_again(StepData& s, ImpulseResponses& responses) {
  const auto slots = std::move(near_->slots);
  const int own = system_.contacts(), families = static_cast<int>(system_.families().size());
  near_->slots.clear();
  auto free = std::exchange(near_->free, {});
  contacts_.resize(static_cast<std::size_t>(own));
  responses.keep_contacts(own);
  for (const auto& slot : slots) {
    const auto& p = slot.pair;
    if (p.family < 0 || p.family >= families || p.i < ground || p.i >= system_.bodies() || p.j < 0 ||
        p.j >= system_.bodies())
      throw MemoryError("the snapshot's pairs belong to another mechanism");
    const int k = new_slot(s, responses);
    const auto family = static_cast<std::size_t>(p.family);
    near_->slots.back() = {p, system_.families()[family].pair(p.i, p.j)};
    set_restitution(k, near_->restitution[family]);
  }
  for (const int k : free)
    if (k < own || k >= static_cast<int>(contacts_.size()))
      throw MemoryError("the snapshot's pairs belong to another mechanism");
  for (const int k : live_)
    if (k < 0 || k >= static_cast<int>(contacts_.size()))
      throw MemoryError("the snapshot's pairs belong to another mechanism");
  near_->free = std::move(free);
}

}  // namespace freeplay
