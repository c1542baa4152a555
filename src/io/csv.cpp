#include "io/csv.hpp"

#include "model/planar.hpp"

namespace freeplay {

void FileObserver::save(MemoryWriter& m) {
  auto size = file_.settle();
  m(size, fresh_);
}

void FileObserver::load(MemoryReader& m) {
  m(from_, fresh_);
  file_.require(from_);
}

void TrajectoryCsv::begin(const Layout& layout, const State& state) {
  const auto n = state.q.size();
  q_.resize(n);
  v_.resize(n);
  contacts_.resize(layout.contacts.size());
  if (!fresh()) return grid_.go_on_to(layout.end);
  header(header_of(trajectory_columns(layout)));
  grid_.begin(state.t, layout.output_step, layout.end, layout.duration);
  row(state.t, state.q, state.v, layout.start);
}

void TrajectoryCsv::step(const Step& step) {
  for (; grid_.next() <= step.t1 && !step.stopped(); grid_.advance()) {
    const double t = grid_.next();
    step.state(t, q_, v_);
    step.contacts(t, q_, contacts_);
    row(t, q_, v_, contacts_);
  }
}

void TrajectoryCsv::row(double t, std::span<const double> q, std::span<const double> v,
                        std::span<const ContactPlace> contacts) {
  file_.number(t);
  for (std::size_t b = 0; planar::first(b) < q.size(); ++b)
    for (const auto& x : {q, v})
      for (std::size_t c = planar::first(b); c < planar::first(b + 1); ++c) field(x[c]);
  for (const auto& c : contacts) {
    field(c.ex);
    field(c.ey);
    field(c.gap);
  }
  file_.write("\n");
}

void TrajectoryCsv::save(MemoryWriter& m) {
  FileObserver::save(m);
  m(grid_);
}
void TrajectoryCsv::load(MemoryReader& m) {
  FileObserver::load(m);
  m(grid_);
}

void EventsCsv::begin(const Layout&, const State&) {
  if (fresh())
    header(
        "t,joint,kind,crank_angle,v_n_minus,v_n_plus,v_t_minus,v_t_plus,impulse_n,impulse_t,duration,t_"
        "uncertainty\n");
}

void EventsCsv::event(const Event& e) {
  file_.number(e.t);
  file_.write(",");
  file_.write(e.joint);
  file_.write(",");
  file_.write(name_of(e.kind));
  for (double x : {e.crank_angle, e.v_n_minus, e.v_n_plus, e.v_t_minus, e.v_t_plus, e.impulse_n, e.impulse_t,
                   e.duration, e.t_uncertainty})
    field(x);
  file_.write("\n");
}

void SignalsCsv::begin(const Layout& layout, const State&) {
  names_ = layout.channels;
  crank_start_ = layout.crank_start;
  crank_speed_ = layout.crank_speed;
  if (fresh()) header("channel,t,crank_angle,value\n");
}

void SignalsCsv::sample(std::size_t channel, double t, double value) {
  file_.write(names_[channel]);
  field(t);
  field(crank_start_ + crank_speed_ * t);
  field(value);
  file_.write("\n");
}

void ForcesCsv::begin(const Layout& layout, const State& state) {
  columns_.clear();
  for (const auto& e : layout.forces) columns_.push_back(force_parts(e.kind));
  if (!fresh()) return grid_.go_on_to(layout.end);
  header(header_of(force_columns(layout)));
  now_.elements.resize(columns_.size());
  now_.acceleration.resize(state.v.size());
  sum_ = now_;
  since_ = state.t;
  grid_.begin(state.t, layout.output_step, layout.end, layout.duration);
}

void ForcesCsv::step(const Step& step) {
  if (!started_) {  // known once a first step has been made; the mean of no time is the value itself
    started_ = true;
    step.forces(step.t0, now_);
    row(step.t0, now_, now_, 1);
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
    row(t, now_, sum_, 1 / (t - since_));
    since_ = t;
    sum_.clear();
  }
  up_to(step.t1);
}

void ForcesCsv::row(double t, const Forces& now, const Forces& sum, double share) {
  file_.number(t);
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const auto& c = columns_[i];
    for (const auto& [name, member] : c.now) field(now.elements[i].*member);
    for (const auto& [name, member] : c.mean) field(share * (sum.elements[i].*member));
  }
  for (const double a : now.acceleration) field(a);
  file_.write("\n");
}

void ForcesCsv::save(MemoryWriter& m) {
  FileObserver::save(m);
  m(grid_, since_, now_, sum_, started_);
}
void ForcesCsv::load(MemoryReader& m) {
  FileObserver::load(m);
  m(grid_, since_, now_, sum_, started_);
}

}  // namespace freeplay
