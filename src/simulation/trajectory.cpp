#include "simulation/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freeplay {

/// Rounding error of step, end and their product.
double Grid::rounding() const { return 1e-9 * step_ + 4 * std::numeric_limits<double>::epsilon() * end_; }

bool Grid::beyond(long index) const {
  const double t = static_cast<double>(index) * step_;
  return t > last_ + rounding() && t - step_ < last_ - rounding();
}

double Grid::multiple(long index) const {
  if (beyond(index) && std::abs(end_ - last_) <= rounding()) return end_;
  const double t = static_cast<double>(index) * step_;
  return std::abs(t - end_) <= rounding() ? end_ : t;
}

void Grid::begin(double t, double step, double end, double last) {
  step_ = step;
  end_ = end;
  last_ = last;
  index_ = 0;
  if (!(step > 0)) {
    next_ = INFINITY;
    return;
  }
  // The first multiple after t; the division finds it up to rounding.
  index_ = std::max(0L, static_cast<long>(std::floor(t / step)) - 1);
  while (multiple(index_) <= t) ++index_;
  next_ = multiple(index_);
}

void Trajectory::begin(const Layout& layout, const State& state) {
  const bool goes_on = n_ == state.q.size() && !t_.empty() && t_.back() <= state.t;
  // By index: a row at the last end may equal a multiple up to rounding and must not be repeated.
  // After a time that was not observed: by time.
  if (goes_on && grid_.next() >= state.t) return grid_.go_on_to(layout.end);
  grid_.begin(state.t, step_ > 0 ? step_ : layout.output_step, layout.end, layout.duration);
  if (goes_on) return;
  n_ = state.q.size();
  t_ = {state.t};
  q_ = state.q;
  v_ = state.v;
}

void Trajectory::step(const Step& step) {
  for (; grid_.next() <= step.t1 && !step.stopped(); grid_.advance()) {
    t_.push_back(grid_.next());
    q_.resize(q_.size() + n_);
    v_.resize(v_.size() + n_);
    step.state(t_.back(), {q_.data() + q_.size() - n_, n_}, {v_.data() + v_.size() - n_, n_});
  }
}

void Energies::begin(const Layout& layout, const State& state) {
  if (!rows.empty() && rows.back().t <= state.t) return grid_.go_on_to(layout.end);
  rows.clear();
  grid_.begin(state.t, step_ > 0 ? step_ : layout.output_step, layout.end, layout.duration);
}

void Energies::step(const Step& step) {
  if (grid_.next() > step.t1) return;
  rows.push_back({step.t1, step.ledger()});
  while (grid_.next() <= step.t1) grid_.advance();
}

void EventList::event(const Event& e) {
  ++seen;
  if (events.size() < most_) events.push_back(e);
}

}  // namespace freeplay
