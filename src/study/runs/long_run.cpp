#include "study/runs/long_run.hpp"

#include <cmath>
#include <numbers>

#include "dynamics/contacts.hpp"
#include "facade/run_folder.hpp"
#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "study/runs/near_pose.hpp"
#include "study/runs/run_together.hpp"

namespace freeplay {
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
    const auto near = near_pose(scene, conduct.stop);
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
  execute_jobs(0, all, conduct.stop, one, [&](std::size_t done) {
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
