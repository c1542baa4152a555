#include "study/runs/measurer.hpp"

#include <fmt/format.h>

#include <optional>

#include "io/scene/read_section.hpp"
#include "mechanism/scene.hpp"
#include "simulation/section.hpp"
#include "simulation/statistics.hpp"
#include "simulation/table_rows.hpp"
#include "simulation/trajectory.hpp"

namespace freeplay {
namespace {

SceneError wrong(const Study& study, const Measure& m, const char* key, const std::string& message) {
  return error_at(study, {"measure", m.name, key}, message);
}

/// The column with this name. Contacts of several joints may share a name; then none is returned,
/// and `same` is their number. Contacts of one translational joint are numbered, as in guide.2.gap.
std::optional<Column> find(const std::vector<Column>& columns, const std::string& name, std::size_t& same) {
  std::optional<Column> found;
  same = 0;
  for (const auto& c : columns)
    if (c.name() == name && ++same == 1) found = c;
  std::map<std::string, int> number;
  for (const auto& c : columns)
    if (fmt::format("{}.{}.{}", c.owner, ++number[c.name()], c.part) == name && c.of == Column::Of::contact) {
      same = 1;
      return c;
    }
  return found;
}

}  // namespace

/// Evaluation of one measure.
class Measurer::Track {
 public:
  enum class Of { row, channel, point, statistic, turns };
  Track(const Measure& m, Of of) : measure(m), kind(of), sums(m) {}

  void close(double begin) {
    if (!sums.empty()) parts.push_back({begin, sums.value()});
    sums = Reducer(measure);
  }
  /// The value over the whole window, or the mean over its periods.
  MeasureValue measured() const {
    MeasureValue out{sums.value(), parts};
    if (!measure.each_period) return out;
    out.value = NAN;
    if (parts.empty()) return out;
    out.value = 0;
    for (const auto& p : parts) out.value += p.value / static_cast<double>(parts.size());
    return out;
  }
  bool extremes() const {
    return measure.reduce == Reduce::min || measure.reduce == Reduce::max || measure.reduce == Reduce::peak;
  }

  Measure measure;
  Of kind;
  Column column = {};
  std::size_t channel = 0;
  Reducer sums;
  std::vector<MeasureValue::Part> parts;
};

/// Observer that passes rows and samples to the measures.
class Measurer::Rows final : public Observer {
 public:
  explicit Rows(CountedTime time) : time_(time) {}
  void add(Track& track) {
    (track.kind == Track::Of::channel ? samples_ : rows_).push_back(&track);
    if (track.kind == Track::Of::channel) return;
    using Of = Column::Of;
    const auto of = track.column.of;
    state_ |= of == Of::position || of == Of::velocity || of == Of::contact;
    contacts_wanted_ |= of == Of::contact;
    forces_wanted_ |= of == Of::force || of == Of::acceleration;
    means_wanted_ |= of == Of::mean;
    ends_ |= track.extremes() && of != Of::mean;
    begins_ |= track.extremes() && of == Of::velocity;
  }
  bool any() const { return !rows_.empty() || !samples_.empty(); }
  /// Whether it needs no more than the states of the steps.
  bool follows() const { return !forces_wanted_ && !means_wanted_; }

  Wants wants() const override {
    return {forces_wanted_ || means_wanted_, !samples_.empty(), !rows_.empty()};
  }

  void begin(const Layout& layout, const State& state) override {
    if (data_.q.empty()) {
      data_.begin(layout, state);
      grid_.begin(state.t, layout.output_step, layout.end, layout.duration);
      boundary_ = time_.from;
    } else {
      grid_.go_on_to(layout.end);
    }
  }

  void step(const Step& step) override {
    while (grid_.next() < time_.from) grid_.advance();
    if (step.t1 < time_.from) return;
    if (begins_ && step.t0 >= time_.from && boundary_ > time_.from) extremes(step, step.t0, true);
    // data_.sum contains the means of this step up to here.
    double summed = std::max(step.t0, time_.from);
    if (means_wanted_) begin_sums(step);
    while (!step.stopped()) {
      const double t = due();
      if (t > step.t1 || t > time_.to) break;
      if (means_wanted_) add_sums(step, summed, t);
      row(step, t);
      if (t == boundary_) next_boundary(t);
      if (same(grid_.next(), t) || grid_.next() <= t) grid_.advance();
    }
    if (means_wanted_) add_sums(step, summed, step.t1);
    if (ends_ && boundary_ > time_.from && step.t1 <= time_.to) extremes(step, step.t1, false);
  }

  void sample(std::size_t channel, double t, double value) override {
    if (t < time_.from || t > time_.to) return;
    for (auto* track : samples_) {
      if (track->channel != channel) continue;
      if (track->measure.each_period) {
        const auto now = static_cast<long>((t - time_.from) / time_.period * (1 + 1e-12));
        if (now != sample_period_[track]) {
          track->close(time_.from + static_cast<double>(sample_period_[track]) * time_.period);
          sample_period_[track] = now;
        }
      }
      track->sums.point(t, value);
    }
  }
  /// Ends the last period of samples if it is complete.
  void finish() {
    for (auto* track : samples_)
      if (track->measure.each_period) {
        const double begin = time_.from + static_cast<double>(sample_period_[track]) * time_.period;
        if (begin + time_.period <= time_.to * (1 + 1e-9)) track->close(begin);
      }
  }

 private:
  /// Times that differ by rounding only are one row.
  bool same(double a, double b) const { return std::abs(a - b) <= 1e-12 * time_.to; }
  double due() const { return same(grid_.next(), boundary_) ? boundary_ : std::min(grid_.next(), boundary_); }
  /// Sets the boundary after t: the end of the next period, finally that of the window.
  void next_boundary(double t) {
    if (t > time_.from && time_.period > 0)
      for (auto* track : rows_)
        if (track->measure.each_period && same(t, period_end())) {
          track->close(period_begin_);
          reopen(*track, t);
        }
    if (time_.period > 0 && (t == time_.from || same(t, period_end()))) {
      if (t > time_.from) ++period_;
      period_begin_ = t;
    }
    const double next = time_.period > 0 ? period_end() : INFINITY;
    boundary_ = t >= time_.to ? INFINITY : next > time_.to || same(next, time_.to) ? time_.to : next;
  }
  double period_end() const { return time_.from + static_cast<double>(period_ + 1) * time_.period; }
  /// The last row of a period is the first row of the next one.
  void reopen(Track& track, double t) {
    if (track.column.of == Column::Of::mean)
      track.sums.since(t);
    else
      track.sums.row(t, last_.at(&track));
  }

  double value(const Column& c, double t) const {
    const double x = data_.value(c, t);
    return c.of == Column::Of::mean ? x / (t - since_) : x;
  }
  void look(const Step& step, double t, bool forces) {
    if (state_) step.state(t, data_.q, data_.v);
    if (contacts_wanted_) step.contacts(t, data_.q, data_.contacts);
    if (forces && forces_wanted_) step.forces(t, data_.now);
  }
  void row(const Step& step, double t) {
    look(step, t, true);
    for (auto* track : rows_) {
      if (track->column.of != Column::Of::mean) {
        const double x = last_[track] = value(track->column, t);
        track->sums.row(t, x);
      } else if (t == time_.from) {
        track->sums.since(t);
      } else if (t > since_) {
        track->sums.mean_row(t, value(track->column, t));
      }
    }
    since_ = t;
    data_.sum.clear();
  }
  void extremes(const Step& step, double t, bool velocities) {
    look(step, t, !velocities);
    for (auto* track : rows_)
      if (track->extremes() && track->column.of != Column::Of::mean &&
          (!velocities || track->column.of == Column::Of::velocity))
        track->sums.extreme(value(track->column, t));
  }
  void begin_sums(const Step& step) {
    if (step.t0 < time_.from || boundary_ <= time_.from) return;
    data_.sum.add(1, step.before());
    if (step.t1 == step.t0) data_.sum.add(1, step.within());
  }
  void add_sums(const Step& step, double& from, double t) {
    if (t <= from) return;
    step.add_impulse(from, t, data_.sum);
    data_.sum.add((t - from) / (step.t1 - step.t0), step.within());
    from = t;
  }

  CountedTime time_;
  std::vector<Track*> rows_, samples_;
  bool state_ = false, contacts_wanted_ = false, forces_wanted_ = false, means_wanted_ = false;
  bool ends_ = false, begins_ = false;
  Grid grid_;
  long period_ = 0;
  double boundary_ = 0, period_begin_ = 0, since_ = 0;  // s
  ColumnData data_;
  std::map<const Track*, double> last_;
  std::map<const Track*, long> sample_period_;
};

/// Observer of the section points of one measure.
class Measurer::Points {
 public:
  Points(const Study& study, const Scene& scene, const Layout& layout, CountedTime time, Track& track)
      : track_(track), to_(time.to) {
    const auto& m = track.measure;
    const auto period = time.period > 0 ? std::optional(time.period) : std::nullopt;
    try {
      const auto rule = read_section(m.at, scene, layout, "at", period);
      std::vector<StateColumn> columns;
      if (m.column != "t") columns.push_back(read_column(m.column, scene, layout, rule, "column").column);
      points_.emplace(rule, columns, time.from);
    } catch (const ModelError& e) {
      throw wrong(study, m, e.key == "column" ? "column" : "at", e.message);
    }
  }
  Observer* observer() { return &*points_; }
  const SectionPoints& points() const { return *points_; }
  void finish() {
    for (std::size_t i = 0; i < points_->size(); ++i) {
      const double t = points_->t(i), x = track_.measure.column == "t" ? t : points_->row(i)[0];
      if (t > to_) break;
      track_.sums.point(t, x);
      track_.parts.push_back({t, x});
    }
  }

 private:
  Track& track_;
  double to_;
  std::optional<SectionPoints> points_;
};

/// Observers for the numbers in run.json.
class Measurer::Statistics {
 public:
  explicit Statistics(CountedTime time) : contacts_(time.from), window_(time.from, time.to) {}
  std::vector<Observer*> observers() { return {&contacts_, &window_}; }
  double next() const { return window_.next(); }
  std::map<std::string, double> numbers(Result& result) const {
    contacts_.into(result);
    window_.into(result);
    return numbers_of(result);
  }

 private:
  ContactStatistics contacts_;
  WindowStatistics window_;
};

Measurer::Measurer(const Study& study, const Scene& scene, const Layout& layout, CountedTime time)
    : rows_(std::make_unique<Rows>(time)) {
  const auto trajectory = trajectory_columns(layout), forces = force_columns(layout);
  for (const auto& m : study.measures) {
    if (!m.waveform.empty()) {
      tracks_.push_back(std::make_unique<Track>(m, Track::Of::turns));
      continue;
    }
    if (m.each_period && !(time.period > 0))
      throw wrong(study, m, "each",
                  "\"period\": no drive of the scene defines a period; give study.period (s)");
    if (!m.at.empty()) {
      auto& track = *tracks_.emplace_back(std::make_unique<Track>(m, Track::Of::point));
      points_.push_back(std::make_unique<Points>(study, scene, layout, time, track));
      continue;
    }
    const auto channel = std::ranges::find(layout.channels, m.column);
    std::size_t same = 0, same_force = 0;
    const auto of_state = find(trajectory, m.column, same), of_force = find(forces, m.column, same_force);
    if (same > 1 || (!of_state && same_force > 1))
      throw wrong(
          study, m, "column",
          fmt::format("\"{}\" occurs {} times, once for each contact of the joint; give one of them, such as "
                      "{}.1.{}",
                      m.column, std::max(same, same_force), (of_state ? of_state : of_force)->owner,
                      (of_state ? of_state : of_force)->part));
    const bool row = of_state || of_force, sampled = channel != layout.channels.end();
    auto& track = *tracks_.emplace_back(std::make_unique<Track>(m, row       ? Track::Of::row
                                                                   : sampled ? Track::Of::channel
                                                                             : Track::Of::statistic));
    if (row)
      track.column = of_state ? *of_state : *of_force;
    else if (sampled)
      track.channel = static_cast<std::size_t>(channel - layout.channels.begin());
    else if (!statistics_)
      statistics_ = std::make_unique<Statistics>(time);
    if (track.kind != Track::Of::statistic) rows_->add(track);
  }
}

Measurer::~Measurer() = default;

std::vector<Observer*> Measurer::observers() const {
  std::vector<Observer*> all;
  if (rows_->any()) all.push_back(rows_.get());
  for (const auto& p : points_) all.push_back(p->observer());
  if (statistics_)
    for (auto* o : statistics_->observers()) all.push_back(o);
  return all;
}

double Measurer::next_shown() const {
  double next = rows_->follows() ? INFINITY : -INFINITY;
  for (const auto& p : points_) next = std::min(next, p->points().next());
  return statistics_ ? std::min(next, statistics_->next()) : next;
}

std::vector<Observer*> Measurer::followers() const {
  std::vector<Observer*> all;
  if (rows_->any() && rows_->follows()) all.push_back(rows_.get());
  for (const auto& p : points_)
    if (p->points().follows()) all.push_back(p->observer());
  return all;
}

std::vector<Measure> Measurer::numbers_of_runs() const {
  std::vector<Measure> all;
  for (const auto& track : tracks_)
    if (track->kind == Track::Of::statistic) all.push_back(track->measure);
  return all;
}

std::vector<MeasureValue> Measurer::finish(Result result) const {
  rows_->finish();
  for (const auto& p : points_) p->finish();
  const auto numbers = statistics_ ? statistics_->numbers(result) : std::map<std::string, double>{};
  std::vector<MeasureValue> all;
  for (const auto& track : tracks_) {
    all.push_back(track->measured());
    if (track->kind != Track::Of::statistic) continue;
    const auto found = numbers.find(track->measure.column);
    all.back().value = found == numbers.end() ? NAN : found->second;
  }
  return all;
}

}  // namespace freeplay
