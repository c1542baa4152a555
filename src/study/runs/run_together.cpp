#include "study/runs/run_together.hpp"

#include <algorithm>
#include <deque>
#include <optional>
#include <utility>

#include "facade/compile.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

/// Fixed steps of all runs together above which lanes are worth their compilations.
constexpr double lanes_after = 1e6;

}  // namespace

SimulationOptions SharedCompilation::options(const Scene& scene, std::string_view formulation) {
  SimulationOptions options{.structures = &structures};
  const auto& o = scene.nonsmooth;
  if (formulation == "nonsmooth" && o.step && o.scheme_in_force() == Scheme::moreau_jean &&
      compile_choice(Compile::automatic) == Compile::automatic &&
      (duration > 0 ? duration : scene.run.duration) / *o.step * static_cast<double>(runs) >= lanes_after)
    options.compile = Compile::always;
  return options;
}

int most_at_a_time(std::size_t runs, int threads) {
  const auto all = static_cast<std::size_t>(std::max(threads, 1));
  return static_cast<int>(std::clamp<std::size_t>((runs + all - 1) / all, 1,
                                                  static_cast<std::size_t>(Simulation::most_together())));
}

void run_all(int most, const std::function<std::unique_ptr<StudyRun>()>& next,
             const std::function<void(StudyRun&)>& done) {
  if (most < 2) {
    while (const auto run = next()) {
      while (run->take(run->simulation().run(run->request()))) {
      }
      done(*run);
    }
    return;
  }
  std::deque<std::shared_ptr<StudyRun>> going_on;  // to their next requests
  int begun = 0;
  Simulation::run_together([&]() -> std::optional<Simulation::Together> {
    std::shared_ptr<StudyRun> run;
    if (!going_on.empty()) {
      run = std::move(going_on.front());
      going_on.pop_front();
    } else {
      if (begun == most || !(run = next())) return {};
      ++begun;
    }
    auto* r = run.get();
    return Simulation::Together{.simulation = &r->simulation(),
                                .request = r->request(),
                                .next_shown = [r] { return r->next_shown(); },
                                .followers = r->followers(),
                                .ended =
                                    [&, run](Result result, long in_lanes) {
                                      run->in_lanes += in_lanes;
                                      if (run->take(std::move(result))) {
                                        going_on.push_back(run);
                                      } else {
                                        --begun;
                                        done(*run);
                                      }
                                    }};
  });
}

}  // namespace freeplay
