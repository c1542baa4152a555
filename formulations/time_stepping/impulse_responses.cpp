#include "formulations/time_stepping/impulse_responses.hpp"

#include <algorithm>

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

}  // namespace freeplay
