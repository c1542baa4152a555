#include "study/attractors/attractor_exponents.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "analysis/lyapunov.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/scene.hpp"
#include "study/runs/executor.hpp"

namespace freeplay {
namespace {

/// Batches of an average over many cycles.
constexpr long most_batches = 20;
/// Part of the average that precedes it, in which the vector aligns.
constexpr double aligning_share = 0.5;

/// Cycles of a periodic attractor, each of which yields its multipliers.
constexpr int cycles_of_orbit = fewest_batches;

/// Periods of a cycle of a periodic attractor; 0 if there is none.
long cycle_of(const SettledRun& run) {
  const auto n = static_cast<std::size_t>(std::max(run.attractor.period, 0));
  if (n == 0 || run.t.size() <= n) return 0;
  return std::max(1L, std::lround((run.t.back() - run.t[run.t.size() - 1 - n]) / run.period));
}

/// A run for the exponent: of some cycles, or of batches of whole periods.
LyapunovRequest request_of(const SettledRun& run, double averaged, Scene& scene) {
  LyapunovRequest request{.exponents = 1};
  scene.run.discard = 0;
  if (const long cycle = cycle_of(run); cycle > 0) {
    request.cycle = static_cast<double>(cycle) * run.period;
    request.batches = cycles_of_orbit;
    request.transient = request.cycle;
    scene.run.duration = (2 + request.batches) * request.cycle;
    return request;
  }
  const auto periods = std::max<long>(fewest_batches, std::lround(averaged));
  const long batches = std::min(most_batches, periods), length = (periods + batches - 1) / batches,
             aligning = std::lround(std::ceil(aligning_share * static_cast<double>(periods)));
  request.batches = static_cast<int>(batches);
  request.transient = static_cast<double>(aligning) * run.period;
  scene.run.duration = static_cast<double>(aligning + batches * length) * run.period;
  return request;
}

AttractorExponent exponent_of(const Study& study, const AttractorPlan& plan, const ChainLink& link,
                              const SettledRun& run, const StopToken& stop) {
  auto scene = scene_of(study, plan, link, stop);
  const auto start = located_in(scene, [&] { return take_over(scene, {run.end, run.drive_angles}, stop); });
  scene.instruments.clear();
  auto request = request_of(run, plan.averaged(), scene);
  request.formulation = plan.formulation;
  request.start = start;
  request.stop = stop;
  const auto found = located_in(scene, [&] { return lyapunov(scene, request); });
  if (!found.failure.empty()) return {NAN, NAN, found.failure};
  const auto& first = found.exponents.front();
  return {first.value, first.error, first.reason.empty() ? found.stopped : first.reason};
}

}  // namespace

void add_exponents(const Study& study, const AttractorPlan& plan, const std::vector<Chain>& chains,
                   const Classified& classified, AttractorStore& store, int threads, StopToken stop,
                   const OnProgress& on_progress, SettledRuns& runs) {
  struct One {
    const ChainLink* link;
    std::vector<SettledRun*> members;  // of one attractor
  };
  std::vector<One> list;
  std::map<std::pair<double, int>, std::size_t> places;
  for (std::size_t c = 0; c < runs.chains.size(); ++c)
    for (std::size_t i = 0; i < runs.chains[c].size(); ++i) {
      const int attractor = classified.of[c][i];
      if (attractor < 0) continue;
      auto& run = runs.chains[c][i];
      const auto [at, added] =
          places.try_emplace({classified.at_each_value ? run.values[0] : 0, attractor}, list.size());
      if (added) list.push_back({&chains[c].links[i], {}});
      list[at->second].members.push_back(&run);
    }
  store.begin_exponents();
  const auto periods = static_cast<long>(plan.averaged());
  const auto one = [&](std::size_t i) {
    const auto& run = *list[i].members.front();
    auto exponent = store.find_exponent(run.key, periods);
    if (!exponent) {
      exponent = exponent_of(study, plan, *list[i].link, run, stop);
      store.store_exponent(run.key, periods, *exponent);
    }
    for (auto* member : list[i].members) member->exponent = exponent;
  };
  execute_jobs(threads, list.size(), stop, one, on_progress);
  runs.interrupted = stop();
}

}  // namespace freeplay
