#include "study/partition/divided_ensemble.hpp"

#include <fmt/format.h>

#include "study/ensemble/ensemble_store.hpp"

namespace freeplay {

Division divided_ensemble(const Scene& scene, const EnsemblePlan& plan, std::vector<std::string> arguments) {
  const StartKeys keys(scene, plan);
  return {.verb = "ensemble",
          .arguments = std::move(arguments),
          .subject = keys.subject(),
          .units =
              [&scene, plan, keys] {
                const Starts all(scene, plan);  // throws for an invalid plan
                std::vector<Unit> units;
                for (int k = 0; k < plan.starts; ++k) units.push_back({keys(k), static_cast<std::size_t>(k)});
                return units;
              },
          .make =
              [&scene, plan](const FolderLock& lock, const std::vector<Unit>& units, const MakeUnits& how) {
                auto own = plan;
                own.stop = how.stop;
                own.threads = how.threads;
                const EnsembleStore store(lock.folder() / "ensemble.db", Database::Access::write, how.stop);
                std::vector<int> starts;
                for (const auto& unit : units) starts.push_back(static_cast<int>(unit.number));
                MadeUnits made;
                std::size_t done = 0;
                Starts(scene, own)
                    .make_all(
                        starts,
                        [&](std::size_t place, StartOutcome& outcome) {
                          return store.find(units[place].key, outcome);
                        },
                        [&](std::size_t place, const StartOutcome& outcome, bool found) {
                          if (outcome.interrupted) return;
                          if (!found) store.store(units[place].key, starts[place], outcome);
                          if (!outcome.failure.empty())
                            made.add_failure(fmt::format("start {}: {}", starts[place], outcome.failure));
                          if (how.on_progress) how.on_progress(++done);
                        });
                made.interrupted = how.stop();
                return made;
              }};
}

}  // namespace freeplay
