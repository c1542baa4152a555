#include "io/files/csv.hpp"

namespace freeplay {

void FileObserver::save(MemoryWriter& m) {
  auto size = file_.settle();
  m(size, fresh_);
}

void FileObserver::load(MemoryReader& m) {
  m(from_, fresh_);
  file_.require(from_);
}

void FileObserver::line(std::span<const double> numbers) {
  file_.number(numbers.front());
  for (const double x : numbers.subspan(1)) field(x);
  file_.write("\n");
}

void TrajectoryCsv::begin(const Layout& layout, const State& state) {
  const bool first = fresh();
  if (first) header(header_of(trajectory_columns(layout)));
  rows_.begin(layout, state, first, *this);
}

void TrajectoryCsv::step(const Step& step) { rows_.step(step, *this); }

void TrajectoryCsv::save(MemoryWriter& m) {
  FileObserver::save(m);
  m(rows_);
}
void TrajectoryCsv::load(MemoryReader& m) {
  FileObserver::load(m);
  m(rows_);
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
  const bool first = fresh();
  if (first) header(header_of(force_columns(layout)));
  rows_.begin(layout, state, first);
}

void ForcesCsv::step(const Step& step) { rows_.step(step, *this); }

void ForcesCsv::save(MemoryWriter& m) {
  FileObserver::save(m);
  m(rows_);
}
void ForcesCsv::load(MemoryReader& m) {
  FileObserver::load(m);
  m(rows_);
}

}  // namespace freeplay
