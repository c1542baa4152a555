// Pairs among many bodies in Moreau's steps (docs/decisions/028-groups.md): which of them are near enough to touch, and what
// is remembered of each as they come and go. A pair without a seat cannot touch before the list is made anew; the list is made
// anew before a motion of the step could close the gap of one (dynamics/neighbours.hpp), in the middle of a step if need be.
#include <algorithm>
#include <utility>

#include "formulations/time_stepping/moreau.hpp"

namespace freeplay {

const Neighbours::Pair& MoreauStepper::pair_of(int k) const {
  return near_->seats[static_cast<std::size_t>(k - system_.contacts())].pair;
}

void MoreauStepper::look(int k, const double* q, const double* v, const Evaluation& e,
                         ContactRow& row) const {
  if (!seated(k)) return system_.contact(k, q, v, e, row);
  const auto& seat = near_->seats[static_cast<std::size_t>(k - system_.contacts())];
  System::contact(seat.shape, facts_of(k), q, v, e, row);
}

double MoreauStepper::gap_of(int k, const double* q, const Evaluation& e) const {
  if (!seated(k)) return system_.gap(k, q, e);
  return System::gap(near_->seats[static_cast<std::size_t>(k - system_.contacts())].shape, q, e);
}

/// Sees to it that whatever a step of h from q at v0 to v1 may close has a seat. h = 0: whatever overlaps at q.
void MoreauStepper::keep_near(double h, const double* q, const double* v0, const double* v1) {
  auto& list = near_->neighbours;
  const double moved = list.moved(q, h, v0, v1);
  if (moved < list.reach() || !std::isfinite(moved)) return;
  // From here on only the step's own motion counts.
  const double ahead =
      h > 0 ? h * std::max(list.fastest(v0), list.fastest(v1)) : step_ * list.fastest(v_.data());
  list.find(q, list.advised(2 * ahead));
  seat(q);
}

/// Seats what the list has found, where it is not seated, and takes the seats of what it has lost. A pair in contact stays.
void MoreauStepper::seat(const double* q) {
  auto& near = *near_;
  const int own = system_.contacts();
  const auto& found = near.neighbours.found();
  near.kept.assign(live_.begin() + own, live_.end());
  live_.resize(static_cast<std::size_t>(own));
  const auto leave = [&](int k) {
    if (contacts_[k].steps > 0 || log_->is_open(k) || contacts_[k].last_n > 0) {
      live_.push_back(k);
      return;
    }
    contacts_[k] = {};
    near.free.push_back(k);
  };
  std::size_t old = 0;
  for (const auto& pair : found) {
    while (old < near.kept.size() && pair_of(near.kept[old]) < pair) leave(near.kept[old++]);
    if (old < near.kept.size() && pair_of(near.kept[old]) == pair) {
      live_.push_back(near.kept[old++]);
      continue;
    }
    const int k = new_seat();
    const auto& family = system_.families()[static_cast<std::size_t>(pair.family)];
    near.seats[static_cast<std::size_t>(k - own)] = {pair, family.pair(pair.i, pair.j)};
    auto& c = contacts_[k];
    c.restitution = near.restitution[static_cast<std::size_t>(pair.family)];
    c.gap = gap_of(k, q, end_);
    c.t_left = -INFINITY;  // of a flight that was long
    look(k, q_mid_.data(), v_old_.data(), e_, c.row);
    std::fill_n(many_->taken.begin() + many_->first[k], 2, 0);
    live_.push_back(k);
  }
  while (old < near.kept.size()) leave(near.kept[old++]);
  make_room();
}

void MoreauStepper::make_room() {
  problem_.reserve_rates(static_cast<int>(rows_.size()));
  position_problem_.reserve_rates(static_cast<int>(contacts_.size()));
}

/// A free seat, or one more with room for its rows.
int MoreauStepper::new_seat() {
  auto& near = *near_;
  if (!near.free.empty()) {
    const int k = near.free.back();
    near.free.pop_back();
    return k;
  }
  near.seats.emplace_back();
  const int k = static_cast<int>(contacts_.size());
  contacts_.emplace_back();
  log_->make_room(k);
  const auto first = static_cast<int>(rows_.size()), rows = first + 2;
  many_->first.push_back(first);
  many_->place.resize(static_cast<std::size_t>(rows));
  many_->taken.resize(static_cast<std::size_t>(rows));
  many_->responses.make_room(rows);
  rows_.resize(static_cast<std::size_t>(rows));
  return k;
}

/// After a snapshot's seats have been read: what follows from them.
void MoreauStepper::seat_again() {
  const auto seats = std::move(near_->seats);
  const int own = system_.contacts(), families = static_cast<int>(system_.families().size());
  near_->seats.clear();
  auto free = std::exchange(near_->free, {});
  const auto begin = static_cast<std::size_t>(own);
  contacts_.resize(begin);
  rows_.resize(rows_.size() - 2 * (many_->first.size() - begin));
  many_->first.resize(begin);
  for (const auto& seat : seats) {
    const auto& p = seat.pair;
    if (p.family < 0 || p.family >= families || p.i < ground || p.i >= system_.bodies() || p.j < 0 ||
        p.j >= system_.bodies())
      throw MemoryError("the snapshot's pairs are of another mechanism");
    const int k = new_seat();
    const auto family = static_cast<std::size_t>(p.family);
    near_->seats.back() = {p, system_.families()[family].pair(p.i, p.j)};
    contacts_[k].restitution = near_->restitution[family];
  }
  for (const int k : free)
    if (k < own || k >= static_cast<int>(contacts_.size()))
      throw MemoryError("the snapshot's pairs are of another mechanism");
  for (const int k : live_)
    if (k < 0 || k >= static_cast<int>(contacts_.size()))
      throw MemoryError("the snapshot's pairs are of another mechanism");
  near_->free = std::move(free);
  make_room();
}

}  // namespace freeplay
