#include "study/calibration/series_fit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "facade/simulation.hpp"
#include "io/scene/points_file.hpp"
#include "io/scene/read_scene.hpp"
#include "io/scene/section.hpp"
#include "io/scene/spelling.hpp"
#include "mechanism/scene.hpp"
#include "simulation/table_rows.hpp"
#include "study/calibration/series_estimate.hpp"
#include "study/runs/executor.hpp"
#include "study/settings/study.hpp"

namespace freeplay {
namespace {

using Index = Eigen::Index;
using Vector = Eigen::VectorXd;
using Pairs = std::vector<std::pair<double, double>>;

/// The measured samples of a target within the compared time.
struct MeasuredSeries {
  std::vector<double> t, value, against;
  double deviation = 0;  // standard deviation of the values
};

Pairs pairs_in(const Target& target, const std::vector<std::string>& columns, const std::string& text) {
  const auto fail = [&](const std::string& what) {
    throw SceneError(fmt::format("{}: {}", target.data.string(), what));
  };
  auto pairs = read_points(text, columns, fail);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!std::isfinite(pairs[i].first) || !std::isfinite(pairs[i].second))
      fail(fmt::format("row {} has a number that is not finite", i + 1));
    if (i > 0 && !(pairs[i].first > pairs[i - 1].first))
      fail(fmt::format("row {}: the time must increase, is {} after {}", i + 1, pairs[i].first,
                       pairs[i - 1].first));
  }
  return pairs;
}

MeasuredSeries read_series(const Target& target) {
  const auto text = read_text(target.data);
  const auto values = pairs_in(target, target.columns, text);
  Pairs against;
  if (!target.against.empty()) {
    // Without `columns`, the time is the first column.
    const auto header = fields(text.substr(0, text.find('\n')));
    against =
        pairs_in(target, {target.columns.empty() ? header.front() : target.columns[0], target.against}, text);
  }
  MeasuredSeries series;
  double mean = 0, squares = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto [t, x] = values[i];
    if ((target.from && t < *target.from) || (target.until && t > *target.until)) continue;
    series.t.push_back(t);
    series.value.push_back(x);
    if (!against.empty()) series.against.push_back(against[i].second);
    mean += x;
    squares += x * x;
  }
  constexpr std::size_t least = 16;
  const auto n = static_cast<double>(series.t.size());
  if (series.t.size() < least)
    throw SceneError(fmt::format("{}: has {} samples in the compared time, at least {} are needed",
                                 target.data.string(), series.t.size(), least));
  series.deviation = std::sqrt(std::max(0.0, squares / n - mean * mean / (n * n)));
  if (!(series.deviation > 0))
    throw SceneError(fmt::format("{}: the value is constant in the compared time", target.data.string()));
  return series;
}

/// Values of a channel during a run, linear between them.
struct ChannelRecord {
  std::vector<double> t, value;
  double operator()(double at) const {
    const auto after = static_cast<std::size_t>(std::ranges::upper_bound(t, at) - t.begin());
    if (after == 0) return value.front();
    if (after == t.size()) return value.back();
    const double share = (at - t[after - 1]) / (t[after] - t[after - 1]);
    return value[after - 1] + share * (value[after] - value[after - 1]);
  }
};

/// Receives one column of a table.
class ColumnRecord : public TableSink {
 public:
  ColumnRecord(std::string column, ChannelRecord& record) : column_(std::move(column)), record_(record) {}
  void put(std::span<const double> numbers, std::span<const std::string_view>) override {
    double t = numbers[0];
    if (mean_ && !std::isnan(last_)) t = 0.5 * (t + last_);
    last_ = numbers[0];
    record_.t.push_back(t);
    record_.value.push_back(numbers[place_]);
  }

 protected:
  void head() override {
    place_ =
        static_cast<std::size_t>(std::ranges::find(columns_, column_, &ColumnName::name) - columns_.begin());
    mean_ = column_.ends_with("_mean");
  }

 private:
  std::string column_;
  ChannelRecord& record_;
  std::size_t place_ = 0;
  bool mean_ = false;
  double last_ = NAN;  // s, time of the previous row
};

/// Receives the samples of one instrument.
class SampleRecord final : public Observer {
 public:
  SampleRecord(std::size_t channel, ChannelRecord& record) : channel_(channel), record_(record) {}
  Wants wants() const override { return {.samples = true, .steps = false}; }
  void sample(std::size_t channel, double t, double value) override {
    if (channel != channel_) return;
    record_.t.push_back(t);
    record_.value.push_back(value);
  }

 private:
  std::size_t channel_;
  ChannelRecord& record_;
};

bool has(const std::vector<Column>& columns, const std::string& name) {
  return std::ranges::any_of(columns, [&](const Column& c) { return c.name() == name; });
}

/// The observer that records a channel; null: there is no such channel.
std::unique_ptr<Observer> recorder(const Layout& layout, const std::string& channel, ChannelRecord& record) {
  if (const auto at = std::ranges::find(layout.channels, channel); at != layout.channels.end())
    return std::make_unique<SampleRecord>(static_cast<std::size_t>(at - layout.channels.begin()), record);
  if (has(trajectory_columns(layout), channel))
    return std::make_unique<RowsInto<TrajectoryRows, ColumnRecord>>(channel, record);
  if (has(force_columns(layout), channel))
    return std::make_unique<RowsInto<ForceRows, ColumnRecord>>(channel, record);
  return nullptr;
}

SceneError wrong_channel(const Study& study, const Target& target, const Layout& layout) {
  auto all = layout.channels;
  for (const auto& list : {trajectory_columns(layout), force_columns(layout)})
    for (const auto& c : list)
      if (c.of != Column::Of::time) all.push_back(c.name());
  const auto near = nearest_word(target.channel, all);
  return error_at(study, {"calibrate", "targets", target.name, "channel"},
                  fmt::format("\"{}\" is neither a column nor an instrument{}", target.channel,
                              near.empty() ? fmt::format("; there are {}", fmt::join(all, ", "))
                                           : fmt::format(", did you mean {}?", near)));
}

/// The runs of a study whose targets are series.
class SeriesModel {
 public:
  SeriesModel(const Study& study, int threads, const StopToken& stop, const std::function<void(int)>& on_run)
      : study_(study), c_(*study.calibration), threads_(threads), stop_(stop), on_run_(on_run) {
    for (const auto& target : c_.targets) measured_.push_back(read_series(target));
  }
  const MeasuredSeries& measured(std::size_t target) const { return measured_[target]; }
  int runs() const { return runs_; }

  /// Throws SceneError if a target cannot be run at the centre of the ranges.
  void require_runnable() const {
    for (std::size_t i = 0; i < c_.targets.size(); ++i) {
      const auto& target = c_.targets[i];
      const auto scene = scene_at(target, Vector::Zero(static_cast<Index>(c_.unknowns.size())));
      located_in(*scene, [&] {
        const Simulation simulation(*scene, c_.formulation, options());
        ChannelRecord record;
        if (!recorder(simulation.layout(), target.channel, record))
          throw wrong_channel(study_, target, simulation.layout());
      });
      if (const double first = measured_[i].t.front(); first < 0)
        throw error_at(
            study_, {"calibrate", "targets", target.name, "from"},
            fmt::format("the run begins at 0 s, after the first compared sample at {} s; set from", first));
      if (const double last = measured_[i].t.back(), end = scene->run.duration; last > end)
        throw error_at(study_, {"calibrate", "targets", target.name, "until"},
                       fmt::format("the run ends at {} s, before the last compared sample at {} s; set until "
                                   "or run.duration",
                                   end, last));
    }
  }

  struct Job {
    std::size_t target;
    std::string formulation;
    Vector xi;
    std::vector<double> model = {};  // at the measured times; empty: failed
    std::string reason = {};
  };
  /// Runs all jobs.
  void run(std::vector<Job>& jobs) {
    execute_jobs(threads_, jobs.size(), stop_, [&](std::size_t k) { run(jobs[k]); });
    if (stop_()) throw Interrupted();
    runs_ += static_cast<int>(jobs.size());
    if (on_run_) on_run_(runs_);
  }

  /// Residuals of the fitted targets, in standard deviations of the measured values.
  std::vector<SeriesResiduals> residuals(const std::vector<Vector>& points) {
    std::vector<Job> jobs;
    for (const auto& xi : points)
      for (std::size_t i = 0; i < c_.targets.size(); ++i)
        if (!c_.targets[i].hold_out) jobs.push_back({i, c_.formulation, xi});
    run(jobs);
    std::vector<SeriesResiduals> all(points.size());
    const auto each = jobs.size() / points.size();
    for (std::size_t p = 0; p < points.size(); ++p)
      for (std::size_t k = 0; k < each; ++k) {
        const auto& job = jobs[p * each + k];
        if (job.model.empty()) {
          if (reason_.empty()) reason_ = job.reason;
          all[p].clear();
          break;
        }
        const auto& m = measured_[job.target];
        const auto n = static_cast<Index>(m.t.size());
        all[p].push_back((Vector::Map(job.model.data(), n) - Vector::Map(m.value.data(), n)) / m.deviation);
      }
    return all;
  }
  /// Why the first run failed that did.
  const std::string& reason() const { return reason_; }

 private:
  std::shared_ptr<const Scene> scene_at(const Target& target, const Vector& xi) const {
    auto overrides = target.overrides;
    std::ranges::copy(overrides_at(c_, xi), std::back_inserter(overrides));
    try {
      return open_scene(study_.scene, overrides, study_.reach == Reach::anywhere);
    } catch (const SceneError& e) {
      throw in_study(study_, e);
    }
  }
  SimulationOptions options() const { return {.matched = study_.matched, .stop = stop_, .checked = true}; }
  void run(Job& job) const try {
    const auto& target = c_.targets[job.target];
    Simulation simulation(*scene_at(target, job.xi), job.formulation, options());
    ChannelRecord record;
    const auto observer = recorder(simulation.layout(), target.channel, record);
    if (!observer) throw wrong_channel(study_, target, simulation.layout());
    const auto result = simulation.run({.observers = {observer.get()}, .keep_events = false, .stop = stop_});
    if (result.ending.status != Ending::Status::finished)
      job.reason = result.ending.reason;
    else if (record.t.empty())
      job.reason = fmt::format("the run has no value of {}", target.channel);
    else
      for (const double t : measured_[job.target].t) job.model.push_back(record(t));
  } catch (const std::runtime_error& e) {
    job.reason = e.what();
  }

  const Study& study_;
  const Calibration& c_;
  int threads_;
  StopToken stop_;
  std::function<void(int)> on_run_;
  std::vector<MeasuredSeries> measured_;
  int runs_ = 0;
  std::string reason_;
};

/// A passage of a level on a flank.
struct Passage {
  int sign = 0;
  double t = 0, place = 0;  // s and `against`, linear between samples
};

std::vector<Passage> passages(const std::vector<double>& t, const std::vector<double>& against,
                              const std::vector<double>& x, double level) {
  std::vector<Passage> list;
  int sign = 0;  // of the last level that was reached
  for (std::size_t i = 0; i < x.size(); ++i) {
    const int now = x[i] > 0 ? 1 : -1;
    if (std::abs(x[i]) < level || now == sign) continue;
    sign = now;
    if (i == 0) continue;  // beyond the level from the beginning
    const double share = std::clamp((now * level - x[i - 1]) / (x[i] - x[i - 1]), 0.0, 1.0);
    const auto between = [&](const std::vector<double>& of) {
      return of[i - 1] + share * (of[i] - of[i - 1]);
    };
    list.push_back({now, between(t), between(against)});
  }
  return list;
}

void compare_flanks(const std::vector<double>& t, const std::vector<double>& against,
                    const std::vector<double>& measured, const std::vector<double>& model,
                    const std::vector<double>& levels, SeriesMisfit& m) {
  // Two passages are partners if each is the other's nearest of its sign.
  const auto nearest = [](const std::vector<Passage>& list, const Passage& to) -> const Passage* {
    const Passage* best = nullptr;
    for (const auto& f : list)
      if (f.sign == to.sign && (!best || std::abs(f.t - to.t) < std::abs(best->t - to.t))) best = &f;
    return best;
  };
  double squares = 0, sum = 0;
  for (const double level : levels) {
    const auto theirs = passages(t, against, measured, level), ours = passages(t, against, model, level);
    const auto before = m.flanks;
    for (const auto& f : theirs) {
      const auto* partner = nearest(ours, f);
      if (!partner || nearest(theirs, *partner) != &f) continue;
      const double off = partner->place - f.place;
      ++m.flanks;
      squares += off * off;
      sum += f.sign * off;
    }
    m.unpaired += theirs.size() + ours.size() - 2 * (m.flanks - before);
  }
  const auto n = static_cast<double>(m.flanks);
  m.flank_rms = m.flanks > 0 ? std::sqrt(squares / n) : NAN;
  m.flank_mean = m.flanks > 0 ? sum / n : NAN;
}

}  // namespace

bool fits_series(const Calibration& calibration) {
  return !calibration.targets.empty() && calibration.targets.front().is_series();
}

SeriesMisfit misfit_of(const std::vector<double>& t, const std::vector<double>& against,
                       const std::vector<double>& measured, const std::vector<double>& model,
                       const std::vector<double>& levels) {
  SeriesMisfit m;
  m.samples = t.size();
  const auto n = static_cast<Index>(t.size());
  const Vector y = Vector::Map(measured.data(), n), r = Vector::Map(model.data(), n) - y;
  Index place = 0;
  r.cwiseAbs().maxCoeff(&place);
  m.rms = std::sqrt(r.squaredNorm() / static_cast<double>(n));
  m.mean = r.mean();
  m.greatest = r[place];
  m.greatest_at = t[static_cast<std::size_t>(place)];
  m.measured_rms = std::sqrt((y.array() - y.mean()).square().mean());
  const double samples = correlation_samples(autocovariance(r));
  m.correlation_time = samples * (t.back() - t.front()) / static_cast<double>(n - 1);
  m.independent = static_cast<double>(n) / samples;
  if (!levels.empty()) compare_flanks(t, against, measured, model, levels, m);
  return m;
}

SeriesFit fit_series(const Study& study, int threads, const StopToken& stop,
                     const std::function<void(int)>& on_run) {
  const auto& c = *study.calibration;
  SeriesModel model(study, threads, stop, on_run);
  model.require_runnable();
  SeriesEstimate found;
  try {
    found = estimate_series([&](const auto& points) { return model.residuals(points); },
                            static_cast<int>(c.unknowns.size()));
  } catch (const Interrupted&) {
    throw;
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(fmt::format("{}: {}", e.what(), model.reason()));
  }
  SeriesFit fit;
  fit.xi = found.xi;
  fit.independent = found.independent;
  fit.converged = found.converged;
  fit.iterations = found.iterations;
  const Vector sd = found.covariance.diagonal().cwiseSqrt();
  fit.correlation = sd.cwiseInverse().asDiagonal() * found.covariance * sd.cwiseInverse().asDiagonal();
  for (std::size_t j = 0; j < c.unknowns.size(); ++j) {
    const auto k = static_cast<Index>(j);
    const double half = found.quantile * sd[k], low = found.xi[k] - half, high = found.xi[k] + half;
    const auto at = [&](double xi) {
      return std::isnan(xi) ? NAN : unscaled(c.unknowns[j], std::clamp(xi, -1.0, 1.0));
    };
    fit.unknowns.push_back({at(found.xi[k]), at(low), at(high), !(low > -1), !(high < 1)});
  }
  // All targets at the optimum, in each formulation.
  std::vector<SeriesModel::Job> jobs;
  for (std::size_t i = 0; i < c.targets.size(); ++i)
    for (const auto& formulation : study.formulations) jobs.push_back({i, formulation, fit.xi});
  model.run(jobs);
  for (auto& job : jobs) {
    const auto& target = c.targets[job.target];
    const auto& m = model.measured(job.target);
    ComparedSeries one{job.target,
                       job.formulation,
                       !target.hold_out && job.formulation == c.formulation,
                       m.t,
                       m.against,
                       m.value,
                       job.model,
                       {},
                       job.reason};
    if (!one.model.empty())
      one.misfit = misfit_of(one.t, one.against, one.measured, one.model, target.levels);
    fit.series.push_back(std::move(one));
  }
  fit.runs = model.runs();
  return fit;
}

}  // namespace freeplay
