#include "study/comparison/settings.hpp"

#include <algorithm>
#include <numbers>

#include "dynamics/evaluation.hpp"
#include "facade/run_folder.hpp"
#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "simulation/touches.hpp"
#include "study/runs/executor.hpp"
#include "study/runs/perturb.hpp"

namespace freeplay {
namespace {

std::vector<ContactEvent> touches(const Result& run) {
  std::vector<ContactEvent> list;
  for (const auto& e : run.events)
    if (e.kind == EventKind::impact && is_onset(e)) list.push_back(e);
  return list;
}

Result run(Scene scene, const Setting& setting, const Conduct& conduct, double duration) {
  setting.apply(scene);
  scene.run.duration = duration;
  scene.run.discard = 0;
  scene.instruments.clear();
  return run_scene(
      scene, {.formulation = name_of(setting.family), .matched = conduct.matched, .stop = conduct.stop});
}

double dissipated(const EnergyLedger& l) { return l.contact + l.friction + l.damping + l.film; }

/// Time at which states are compared: the middle of the flight before the last compared contact
/// onset, so that the state includes effects of impacts; before the first onset if fewer than two
/// are compared. Simultaneous onsets count as one.
double state_time(const Scene& scene, const std::vector<ContactEvent>& assessed,
                  const std::vector<ContactEvent>& all) {
  if (all.empty()) return scene.run.duration;
  for (std::size_t i = assessed.size(); i-- > 0;) {
    const double last = assessed.back().t, left = assessed[i].t + assessed[i].duration;
    if (left < last * (1 - 1e-6)) return 0.5 * (left + last);
  }
  return 0.9 * all.front().t;
}

}  // namespace

bool Setting::adaptive() const {
  return family == Family::nonsmooth ? chosen_steps || choice_of(scheme).traits.adaptive
                                     : choice_of(integrator).traits.adaptive;
}

std::string Setting::method() const {
  if (family == Family::nonsmooth)
    return fmt::format("{}{}", text_of(scheme), chosen_steps ? " chosen steps" : "");
  const auto method = std::string(text_of(integrator));
  return stabilisation == Stabilisation::projection ? fmt::format("{}+{}", method, text_of(stabilisation))
                                                    : method;
}

std::string Setting::label() const { return fmt::format("{} {:.0e}", method(), fineness); }

std::vector<std::string> Setting::keys() const {
  const auto fine = fmt::format("{}.{}={}", name_of(family),
                                chosen_steps ? "step_tolerance"
                                : adaptive() ? "tolerance"
                                             : "step",
                                fineness);
  if (family == Family::nonsmooth) {
    std::vector<std::string> list = {fmt::format("nonsmooth.scheme={}", text_of(scheme)), fine};
    if (chosen_steps) list.emplace_back("nonsmooth.step=automatic");
    return list;
  }
  std::vector<std::string> list = {fmt::format("penalty.integrator={}", text_of(integrator)), fine};
  if (stabilisation == Stabilisation::projection)
    list.push_back(fmt::format("penalty.stabilisation={}", text_of(stabilisation)));
  return list;
}

void Setting::apply(Scene& scene) const {
  if (family == Family::nonsmooth) {
    auto& o = scene.nonsmooth;
    o.scheme = scheme;
    if (chosen_steps) {
      o.step.reset();
      o.step_tolerance = fineness;
    } else if (adaptive()) {
      o.tolerance = fineness;
    } else {
      o.step = fineness;
    }
    return;
  }
  scene.penalty.integrator = integrator;
  scene.penalty.stabilisation = stabilisation;
  (adaptive() ? scene.penalty.tolerance : scene.penalty.step) = fineness;
}

std::vector<Setting> all_settings(Family family) {
  std::vector<Setting> list;
  if (family == Family::nonsmooth) {
    for (const double h : {1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6})
      list.push_back({family, {}, Scheme::moreau_jean, h});
    for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7})
      list.push_back({family, {}, Scheme::moreau_jean, tolerance, {}, true});
    for (const double tolerance : {1e-3, 1e-5, 1e-7, 1e-9, 1e-10, 1e-11})
      list.push_back({family, {}, Scheme::event_driven, tolerance});
    for (const double tolerance : {1e-5, 1e-8, 1e-10})
      list.push_back({family, {}, Scheme::automatic, tolerance});
    return list;
  }
  for (const double h : {1e-5, 3e-6, 1e-6}) list.push_back({family, Integrator::rk4, {}, h});
  for (const auto integrator : {Integrator::dopri5, Integrator::bulirsch_stoer,
                                Integrator::adams_bashforth_moulton, Integrator::rosenbrock4})
    for (const double tolerance : {1e-3, 1e-5, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11}) {
      if (integrator == Integrator::rosenbrock4 && tolerance < 5e-8)
        continue;  // order 4 would need thousands of steps for each contact
      if (integrator != Integrator::adams_bashforth_moulton && (tolerance == 1e-8 || tolerance == 1e-10))
        continue;  // used by setting_for() only
      list.push_back({family, integrator, {}, tolerance});
    }
  for (const double tolerance : {1e-5, 1e-9})
    list.push_back({family, Integrator::dopri5, {}, tolerance, Stabilisation::projection});
  return list;
}

Setting setting_for(Family family, Accuracy accuracy) {
  const auto level = static_cast<int>(accuracy);
  if (family == Family::nonsmooth) {
    return {family, {}, Scheme::automatic, std::array{1e-5, 1e-8, 1e-10}[level]};
  }
  return {family, Integrator::adams_bashforth_moulton, {}, std::array{1e-5, 1e-8, 1e-10}[level]};
}

double velocity_error(const State& a, const State& b) {
  double worst = 0, size = 0;
  for (std::size_t i = 0; i < a.v.size(); ++i) {
    worst = std::max(worst, std::abs(a.v[i] - b.v[i]));
    size = std::max(size, std::abs(b.v[i]));
  }
  return size > 0 ? worst / size : worst;
}

std::pair<Setting, Setting> reference_settings(Family family) {
  if (family == Family::penalty)
    return {{family, Integrator::dopri5, {}, 1e-12},
            {family, Integrator::adams_bashforth_moulton, {}, 1e-10}};
  return {{family, {}, Scheme::event_driven, 1e-13}, {family, {}, Scheme::event_driven, 1e-11}};
}

Setting statistics_setting(Family family) {
  if (family == Family::penalty) return {family, Integrator::dopri5, {}, 1e-9};
  return {family, {}, Scheme::automatic, 1e-9};
}

double onset_error(const std::vector<ContactEvent>& found, const std::vector<ContactEvent>& reference) {
  return onset_difference(found, reference).greatest();
}

Reference make_reference(const Scene& scene, Family family, const Conduct& conduct, std::size_t most) {
  const auto [finest, other] = reference_settings(family);
  Reference r;
  const auto a = run(scene, finest, conduct, scene.run.duration);
  const auto b = run(scene, other, conduct, scene.run.duration);
  r.ending = a.ending.status == Ending::Status::finished ? b.ending : a.ending;
  if (r.ending.status != Ending::Status::finished) return r;
  r.dissipated = dissipated(a.ledger);
  const auto all = touches(a), check = touches(b);
  for (std::size_t i = 0; i < std::min(all.size(), most); ++i) {
    auto longer = r.touches;
    longer.push_back(all[i]);
    const double apart = onset_error(check, longer);
    if (apart > 1e-6) break;
    r.touches = std::move(longer);
    r.accuracy = apart;
  }
  r.horizon = r.touches.empty() ? scene.run.duration : r.touches.back().t;
  r.state_time = state_time(scene, r.touches, all);
  r.state = run(scene, finest, conduct, r.state_time).final_state;
  if (r.touches.empty())
    r.accuracy = velocity_error(run(scene, other, conduct, r.state_time).final_state, r.state);
  return r;
}

Measured measure(const Scene& scene, const Setting& setting, const Reference& reference,
                 const Conduct& conduct) {
  Measured m;
  m.setting = setting;
  const auto whole = run(scene, setting, conduct, scene.run.duration);
  m.ending = whole.ending;
  m.work = whole.work;
  m.cpu = m.cpu_low = m.cpu_high = whole.cpu_seconds;
  if (m.ending.status != Ending::Status::finished) return m;
  m.errors.events = onset_error(touches(whole), reference.touches);
  m.errors.energy = std::abs(whole.ledger.closure()) / std::max(whole.ledger.scale(), 1e-300);
  m.errors.dissipated = reference.dissipated != 0 ? dissipated(whole.ledger) / reference.dissipated - 1 : 0;
  const auto early = run(scene, setting, conduct, reference.state_time);
  m.errors.state = velocity_error(early.final_state, reference.state);
  return m;
}

namespace {

double welch(const std::vector<double>& a, const std::vector<double>& b) {
  const auto p = moments(a), q = moments(b);
  const double error =
      std::sqrt(p.variance / static_cast<double>(a.size()) + q.variance / static_cast<double>(b.size()));
  const double difference = std::abs(p.mean - q.mean);
  return difference == 0 ? 0 : difference / error;
}

}  // namespace

Moments moments(const std::vector<double>& x) {
  const auto n = static_cast<double>(x.size());
  Moments m;
  for (const double value : x) m.mean += value / n;
  for (const double value : x) m.variance += (value - m.mean) * (value - m.mean) / (n - 1);
  return m;
}

std::vector<Scene> perturbed_starts(const Scene& scene, const Sampling& sampling, int first,
                                    const Conduct& conduct) {
  std::vector<Scene> starts;
  if (sampling.starts < 2 || contact_names(scene.mechanism).empty() || !differ(scene, sampling.how))
    return starts;
  try {
    const auto near = ideal_pose(scene, conduct.stop);
    for (int i = 0; i < sampling.starts; ++i) {
      auto moved = perturbed(scene, near, conduct.stop, sampling.seed, first + i, sampling.how);
      moved.instruments.clear();
      moved.run.discard = 0;
      const auto* drive = main_drive(scene.mechanism);
      if (drive && drive->speed != 0)
        moved.run.duration = sampling.revolutions * 2 * std::numbers::pi / std::abs(drive->speed);
      starts.push_back(std::move(moved));
    }
  } catch (const ModelError&) {
    starts.clear();  // a scene that can be assembled only because of its clearances
  }
  return starts;
}

std::vector<LongRun> long_runs(const std::vector<Scene>& starts, const std::vector<Setting>& settings,
                               const Conduct& conduct, const std::function<void(double)>& on_progress) {
  const std::size_t n = starts.size(), all = n * settings.size();
  std::vector<Result> runs(all);
  const auto one = [&](std::size_t i) {
    auto scene = starts[i % n];
    const auto& setting = settings[i / n];
    setting.apply(scene);
    try {
      runs[i] = run_scene(
          scene, {.formulation = name_of(setting.family), .matched = conduct.matched, .stop = conduct.stop});
    } catch (const ModelError& e) {
      runs[i].ending = {Ending::Status::failed, e.what()};
    }
    runs[i].events.clear();
  };
  execute_jobs(0, all, conduct.stop, one, [&](std::size_t done, std::size_t) {
    if (on_progress) on_progress(static_cast<double>(done) / static_cast<double>(all));
  });
  std::vector<LongRun> results(settings.size());
  for (std::size_t i = 0; i < all; ++i) {
    auto& r = results[i / n];
    const auto& run = runs[i];
    if (run.ending.status != Ending::Status::finished) {
      if (r.stopped.empty()) r.stopped = run.ending.reason;
      continue;
    }
    r.lost.push_back((run.ledger.contact + run.ledger.friction) / run.t_end);
    double flight = 0, impacts = 0;
    for (const auto& c : run.contacts)
      impacts += c.impacts_per_revolution / static_cast<double>(run.contacts.size());
    r.impacts.push_back(impacts);
    for (const auto& c : run.contacts) flight += c.flight_fraction / static_cast<double>(run.contacts.size());
    r.flight.push_back(flight);
  }
  return results;
}

double deviation(const LongRun& a, const LongRun& b) {
  if (a.lost.size() < 2 || b.lost.size() < 2) return std::nan("");
  return std::max(welch(a.lost, b.lost), welch(a.flight, b.flight));
}

double relative_spread(const std::vector<double>& sample) {
  if (sample.size() < 2) return std::nan("");
  const auto m = moments(sample);
  return std::sqrt(m.variance) / std::abs(m.mean);
}

}  // namespace freeplay
