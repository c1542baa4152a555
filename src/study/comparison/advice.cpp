#include "study/comparison/advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>

#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "simulation/touches.hpp"

namespace freeplay {
namespace {

/// A compared contact onset, and the time since the previous onset of any contact, s.
struct Assessed {
  ContactEvent event;
  double interval = 0;
};

/// Onsets with at least a hundredth of the greatest speed of their contact so far. An accumulation
/// contains infinitely many slower ones, of which rounding determines the last.
std::vector<Assessed> that_count(const Result& run) {
  std::vector<Assessed> list;
  std::vector<double> fastest(run.contacts.size());
  double before = 0, interval = 0;
  for (const auto& e : run.events) {
    if (!is_onset(e)) continue;
    auto& f = fastest[e.contact];
    if (-e.v_n_minus < 0.01 * f) continue;
    f = std::max(f, -e.v_n_minus);
    // Simultaneous onsets share the interval before them.
    if (e.t - before > 1e-6 * e.t) interval = e.t - before;
    before = e.t;
    list.push_back({e, interval});
  }
  return list;
}

/// Observer that compares contact onsets during a run, and stops the run when its result is known.
/// Each reference onset is compared with the first onset of its contact within the tolerance of its
/// time; earlier onsets are ignored, since their effect appears in later ones.
class Assessment final : public Observer {
 public:
  Assessment(const std::vector<Assessed>& reference, double bound, long most_steps, StopToken requested)
      : reference_(reference),
        bound_(bound),
        most_steps_(most_steps),
        requested_(requested),
        off_(reference.size(), -1) {}
  StopToken token() const { return StopToken(done_); }
  bool dearer() const { return steps_ > most_steps_; }
  /// Number of onsets before the first one outside the bound.
  std::size_t kept() const {
    std::size_t i = 0;
    while (i < off_.size() && off_[i] >= 0 && off_[i] <= bound_) ++i;
    return i;
  }
  /// Greatest error up to and including the first onset outside the bound; infinite if that is
  /// missing.
  double worst() const {
    const auto n = kept();
    double worst = 0;
    for (std::size_t i = 0; i < n; ++i) worst = std::max(worst, off_[i]);
    return n == off_.size() ? worst : off_[n] < 0 ? INFINITY : std::max(worst, off_[n]);
  }

  void event(const Event& e) override { assess(e); }
  void step(const Step&) override {
    if (++steps_ > most_steps_ || requested_()) done_ = true;
  }
  void end(const RunEnd& end) override {
    for (const auto& e : end.held_back) assess(e);
  }
  void assess(const ContactEvent& e) {
    if (!is_onset(e) || done_) return;
    next_.resize(std::max(next_.size(), static_cast<std::size_t>(e.contact) + 1));
    auto& i = next_[e.contact];
    while (i < reference_.size() && reference_[i].event.contact != e.contact) ++i;
    if (i == reference_.size()) return;  // beyond the horizon
    const auto& [touch, interval] = reference_[i];
    if (e.t < touch.t - bound_ * interval) return;
    off_[i] = event_difference(e, touch, interval);
    if (!(off_[i] <= bound_) || ++met_ == off_.size()) done_ = true;
    ++i;
  }

 private:
  const std::vector<Assessed>& reference_;
  double bound_;
  long most_steps_, steps_ = 0;
  StopToken requested_;
  std::vector<double> off_;  // error of each onset; −1: not found
  std::vector<std::size_t> next_;
  std::size_t met_ = 0;
  std::atomic<bool> done_ = false;
};

Scene bare(const Scene& given, const Setting& setting) {
  Scene scene = given;
  setting.apply(scene);
  scene.run.discard = 0;
  scene.run.forces = false;
  scene.instruments.clear();
  return scene;
}

/// Number of standard errors for a significant difference: Student's t with 14 degrees of freedom
/// at 1 % for the three statistics of one setting together.
constexpr double surely = 3.6;

long cost(const Work& w) { return w.rhs + 10 * w.jacobians; }

Result whole_run(const Scene& scene, const Setting& setting, const Conduct& conduct,
                 const AdviceRules& rules) {
  return Simulation(bare(scene, setting), name_of(setting.family),
                    {.matched = conduct.matched, .stop = conduct.stop})
      .run({.most_events = static_cast<std::size_t>(rules.most_events), .stop = conduct.stop});
}

/// Contact onsets up to the horizon, and whether that is the end of the run.
std::vector<Assessed> find_horizon(Advice& advice, const Result& fine, const Result& other, double parting) {
  auto& r = advice.reference;
  auto all = that_count(fine);
  Assessment assess(all, parting, std::numeric_limits<long>::max(), {});
  for (const auto& e : other.events) assess.assess(e);
  const auto kept = assess.kept();
  advice.to_the_end = kept == all.size() && !fine.events_cut();
  r.state_time = all.empty() ? fine.t_end : 0.9 * all.front().event.t;
  all.resize(kept);
  for (const auto& [touch, interval] : all) r.touches.push_back(touch);
  Assessment again(all, parting, std::numeric_limits<long>::max(), {});
  for (const auto& e : other.events) again.assess(e);
  r.accuracy = again.worst();
  advice.by_events = !all.empty();
  r.horizon = advice.to_the_end ? fine.t_end : advice.by_events ? all.back().event.t : 0;
  return all;
}

/// Runs a setting and compares its onsets up to the horizon, or, without onsets, its state.
Measured tried(const Scene& scene, const Setting& setting, const Advice& advice,
               const std::vector<Assessed>& assessed, double bound, long most_steps, const Conduct& conduct) {
  const auto& r = advice.reference;
  Measured m;
  m.setting = setting;
  Assessment assess(assessed, bound, most_steps, conduct.stop);
  // Run beyond the last onset, so that a late onset is not reported as missing, and a lasting
  // contact can be recognised.
  const double until =
      advice.by_events ? std::min(scene.run.duration, 1.25 * r.touches.back().t + 0.1 * scene.run.duration)
                       : r.state_time;
  Simulation simulation(bare(scene, setting), name_of(setting.family),
                        {.matched = conduct.matched, .stop = conduct.stop});
  const auto run =
      simulation.run({.until = until, .observers = {&assess}, .keep_events = false, .stop = assess.token()});
  m.ending = run.ending;
  m.work = run.work;
  m.cpu = m.cpu_low = m.cpu_high = run.cpu_seconds;
  if (run.ending.status == Ending::Status::failed) return m;
  m.dearer = assess.dearer();
  if (!m.dearer && !conduct.stop()) m.ending = {};
  if (assess.kept() > 0) m.kept_to = assessed[assess.kept() - 1].event.t;
  if (advice.by_events)
    m.errors.events = assess.worst();
  else
    m.errors.state = velocity_error(run.final_state, r.state);
  m.errors.energy = std::abs(run.ledger.closure()) / std::max(run.ledger.scale(), 1e-300);
  return m;
}

Perturbation moved_by(const AdviceRules& rules) { return {.turn = 0, .play = rules.play}; }

std::vector<Scene> moved_starts(const Scene& scene, int first, int number, const AdviceRules& rules,
                                const Conduct& conduct) {
  Sampling sampling;
  sampling.starts = number;
  sampling.how = moved_by(rules);
  auto starts = perturbed_starts(scene, sampling, first, conduct);
  for (auto& s : starts) {
    s.run.duration = scene.run.duration;
    s.run.discard = scene.run.discard;
    s.run.forces = false;
  }
  return starts;
}

Statistic compared(const char* name, const std::vector<double>& reference, const std::vector<double>& found) {
  const auto r = moments(reference), f = moments(found);
  const double size = r.mean != 0 ? std::abs(r.mean) : std::abs(f.mean);
  if (size == 0) return {name, 0, 0, 0, 0};
  return {name, r.mean, (f.mean - r.mean) / size,
          std::sqrt(r.variance / static_cast<double>(reference.size()) +
                    f.variance / static_cast<double>(found.size())) /
              size,
          std::sqrt(f.variance) / size};
}

std::vector<Statistic> compared(const LongRun& reference, const LongRun& found) {
  if (!reference.stopped.empty() || !found.stopped.empty() || reference.lost.size() < 2) return {};
  return {compared("flight share", reference.flight, found.flight),
          compared("impacts", reference.impacts, found.impacts),
          compared("power lost", reference.lost, found.lost)};
}

}  // namespace

double Advice::promised() const {
  double worst = statistics.empty() ? INFINITY : 0;
  for (const auto& s : statistics) worst = std::max(worst, s.promised());
  return worst;
}

Advice advise(const Scene& scene, Family family, double error, const Conduct& conduct,
              const std::function<void(double)>& on_progress, const AdviceRules& rules) {
  using Clock = std::chrono::steady_clock;
  const auto began = Clock::now();
  const auto show = [&](double done) {
    if (on_progress) on_progress(done);
  };
  Advice advice;
  auto& r = advice.reference;
  const auto [finest, other] = reference_settings(family);
  const auto fine = whole_run(scene, finest, conduct, rules);
  show(0.2);
  const auto check = whole_run(scene, other, conduct, rules);
  r.ending = fine.ending.status == Ending::Status::finished ? check.ending : fine.ending;
  if (r.ending.status != Ending::Status::finished) return advice;
  const auto assessed = find_horizon(advice, fine, check, 0.01 * error);
  if (!advice.to_the_end)
    require_differing_starts(
        scene, moved_by(rules),
        advice.by_events
            ? fmt::format("; reference runs diverge after t = {:.3g} s, and later advice needs statistics "
                          "of starts: use a run.duration up to that time",
                          r.horizon)
            : "; reference runs diverge at the first contact event, and later advice needs statistics of "
              "starts: use a run.duration up to that time");
  if (!advice.by_events) {
    const auto to_state = [&](const Setting& s) {
      Scene one = scene;
      one.run.duration = r.state_time;
      return whole_run(one, s, conduct, rules).final_state;
    };
    r.state = to_state(finest);
    r.accuracy = velocity_error(to_state(other), r.state);
  }
  show(0.4);

  auto settings = all_settings(family);
  std::stable_partition(settings.begin(), settings.end(), std::mem_fn(&Setting::adaptive));
  long cheapest = std::numeric_limits<long>::max();
  const auto keeps = [&](const Measured& m) {
    const double found = advice.by_events ? m.errors.events : m.errors.state;
    return m.ending.status == Ending::Status::finished && found <= 0.5 * error;
  };
  for (std::size_t i = 0; i < settings.size(); ++i) {
    if (conduct.stop()) return advice;
    advice.tried.push_back(tried(scene, settings[i], advice, assessed, 0.5 * error, cheapest, conduct));
    if (keeps(advice.tried.back())) cheapest = std::min(cheapest, cost(advice.tried.back().work));
    show(0.4 + 0.3 * static_cast<double>(i + 1) / static_cast<double>(settings.size()));
  }
  // Cost in right-hand sides, which do not depend on the load of the machine.
  std::ranges::stable_sort(advice.tried, {}, [](const Measured& m) { return cost(m.work); });
  std::vector<Scene> starts;
  std::vector<LongRun> fine_runs;
  if (!advice.to_the_end) {
    const auto affordable = rules.most_rhs / std::max(1L, fine.work.rhs);
    const int number = static_cast<int>(std::clamp(affordable, 4L, static_cast<long>(rules.starts)));
    starts = moved_starts(scene, 0, number, rules, conduct);
    // The reference uses other starts, so that no setting is compared with its own runs.
    if (!starts.empty())
      fine_runs = long_runs(moved_starts(scene, number, number, rules, conduct), {statistics_setting(family)},
                            conduct, {});
  }
  int refused = 0;
  for (std::size_t i = 0; i < advice.tried.size() && advice.chosen < 0 && refused < rules.most_refused; ++i) {
    if (!keeps(advice.tried[i]) || conduct.stop()) continue;
    if (!starts.empty()) {
      advice.statistics =
          compared(fine_runs[0], long_runs(starts, {advice.tried[i].setting}, conduct, {})[0]);
      const auto apart = std::ranges::find_if(advice.statistics, [&](const Statistic& s) {
        return std::abs(s.difference) > error + surely * s.error;
      });
      if (apart != advice.statistics.end()) {
        advice.refused.push_back({advice.tried[i].setting, *apart});
        ++refused;
        continue;
      }
    }
    advice.chosen = static_cast<int>(i);
  }
  show(1);
  advice.seconds = std::chrono::duration<double>(Clock::now() - began).count();
  return advice;
}

}  // namespace freeplay
