#include "simulation/table_rows.hpp"

#include "dynamics/planar.hpp"

namespace freeplay {

void TrajectoryRows::begin(const Layout& layout, const State& state, bool fresh, RowSink& sink) {
  const auto n = state.q.size();
  q_.resize(n);
  v_.resize(n);
  contacts_.resize(layout.contacts.size());
  if (!fresh) return grid_.go_on_to(layout.end);
  grid_.begin(state.t, layout.output_step, layout.end, layout.duration);
  row(state.t, state.q, state.v, layout.start, sink);
}

void TrajectoryRows::step(const Step& step, RowSink& sink) {
  for (; grid_.next() <= step.t1 && !step.stopped(); grid_.advance()) {
    const double t = grid_.next();
    step.state(t, q_, v_);
    step.contacts(t, q_, contacts_);
    row(t, q_, v_, contacts_, sink);
  }
}

void TrajectoryRows::row(double t, std::span<const double> q, std::span<const double> v,
                         std::span<const ContactPlace> contacts, RowSink& sink) {
  row_.clear();
  row_.push_back(t);
  for (std::size_t b = 0; planar::first(b) < q.size(); ++b)
    for (const auto& x : {q, v})
      for (std::size_t c = planar::first(b); c < planar::first(b + 1); ++c) row_.push_back(x[c]);
  for (const auto& c : contacts) row_.insert(row_.end(), {c.ex, c.ey, c.gap});
  sink.row(row_);
}

void ForceRows::begin(const Layout& layout, const State& state, bool fresh) {
  columns_.clear();
  for (const auto& e : layout.forces) columns_.push_back(force_parts(e.kind));
  if (!fresh) return grid_.go_on_to(layout.end);
  now_.elements.resize(columns_.size());
  now_.acceleration.resize(state.v.size());
  sum_ = now_;
  since_ = state.t;
  grid_.begin(state.t, layout.output_step, layout.end, layout.duration);
}

void ForceRows::step(const Step& step, RowSink& sink) {
  if (!started_) {  // forces are known after the first step; the first row uses them as means
    started_ = true;
    step.forces(step.t0, now_);
    row(step.t0, now_, now_, 1, sink);
  }
  sum_.add(1, step.before());
  double from = step.t0;
  const double h = step.t1 - step.t0;
  if (h == 0) sum_.add(1, step.within());
  const auto up_to = [&](double t) {
    step.add_impulse(from, t, sum_);
    if (h > 0) sum_.add((t - from) / h, step.within());
    from = t;
  };
  for (; grid_.next() <= step.t1 && !step.stopped(); grid_.advance()) {
    const double t = grid_.next();
    up_to(t);
    step.forces(t, now_);
    row(t, now_, sum_, 1 / (t - since_), sink);
    since_ = t;
    sum_.clear();
  }
  up_to(step.t1);
}

void ForceRows::row(double t, const Forces& now, const Forces& sum, double share, RowSink& sink) {
  row_.clear();
  row_.push_back(t);
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const auto& c = columns_[i];
    for (const auto& [name, member] : c.now) row_.push_back(now.elements[i].*member);
    for (const auto& [name, member] : c.mean) row_.push_back(share * (sum.elements[i].*member));
  }
  row_.insert(row_.end(), now.acceleration.begin(), now.acceleration.end());
  sink.row(row_);
}

}  // namespace freeplay
