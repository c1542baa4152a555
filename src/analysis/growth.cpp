#include "analysis/growth.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/system.hpp"
#include "facade/simulation.hpp"
#include "formulations/variation/tangent_run.hpp"
#include "mechanism/scene.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

/// Copies new onsets. Returns false if a difference exceeds the time since the onset before.
bool take_onsets(TangentRun& run, std::vector<double>& last, Growth& found) {
  bool together = true;
  auto list = run.varied_onsets();
  std::ranges::stable_sort(list, {}, &VariedOnset::t);
  for (const auto& o : list) {
    found.onsets.push_back({o.contact, o.t, o.rate, o.dt[0], o.drate[0]});
    auto& before = last[static_cast<std::size_t>(o.contact)];
    together = together && std::abs(o.dt[0]) <= o.t - before;
    before = o.t;
  }
  run.forget_onsets();
  return together;
}

}  // namespace

Growth growth_of_impact_errors(const Scene& scene, const GrowthRequest& request) {
  Simulation simulation(scene, "nonsmooth", {.start = {}, .stop = request.stop});
  const auto& given = simulation.scene();
  const System system(given.mechanism);
  std::vector<std::size_t> impacts(request.errors.size());
  const auto error_of = [&](int contact) -> ImpactError {
    const auto k = static_cast<std::size_t>(contact);
    if (k >= impacts.size() || request.errors[k].empty()) return {};
    return request.errors[k][std::min(impacts[k]++, request.errors[k].size() - 1)];
  };
  TangentRun run({.scene = given,
                  .system = system,
                  .start = simulation.state(),
                  .end = request.end,
                  .stop = request.stop,
                  .restitution = request.restitution},
                 Family::nonsmooth, {.predict = false, .impact_error = error_of});
  run.vary({std::vector<double>(static_cast<std::size_t>(2 * system.n() + system.states()))});
  Growth found;
  std::vector<double> last(static_cast<std::size_t>(system.contacts()), simulation.t());
  while (run.t() < request.end && found.ended.empty()) {
    const bool stepped = run.step(request.end);
    found.parted = !take_onsets(run, last, found);
    if (found.parted) break;
    if (!stepped)
      found.ended = run.failure();
    else if (run.evaluations() > request.most_evaluations)
      found.ended = "the prediction would cost more than both runs";
  }
  found.until = found.parted ? std::nextafter(found.onsets.back().t, INFINITY) : run.t();
  return found;
}

}  // namespace freeplay
