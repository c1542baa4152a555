#include "study/partition/divided.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <unordered_map>

#include "io/files/digest.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "study/ensemble/ensemble.hpp"
#include "study/settings/study.hpp"
#include "study/sweep/sweep.hpp"
#include "study/sweep/sweep_table.hpp"

namespace freeplay {

void require_planned(bool same, const Unit& unit, const std::filesystem::path& file) {
  if (!same)
    throw SceneError(fmt::format("{}: run {} differs from the planned one; plan again into another folder",
                                 file.string(), unit.number));
}

namespace {

/// The runs of these units, with their keys from the plan.
std::vector<PlannedRun> runs_of(const Study& study, const Conduct& conduct, const std::vector<Unit>& units) {
  auto all = cases(study);
  std::vector<PlannedRun> runs;
  std::unordered_map<std::size_t, Identity> known;  // identities of first starts
  for (const auto& unit : units) {
    if (conduct.stop()) throw Interrupted();
    require_planned(unit.number < all.size(), unit, study.file);
    auto& one = all[unit.number];
    const auto first = unit.number - static_cast<std::size_t>(one.start);
    if (!known.contains(first)) known[first] = identity(study, all[first], conduct);
    require_planned(run_key(known[first], one.start) == unit.key, unit, study.file);
    runs.push_back({unit.key, one, unit.number});
  }
  return runs;
}

}  // namespace

std::string subject_of(const Study& study) {
  auto origin = provenance(study);
  // Exclude parts that are only for users.
  return digest(origin.contains("identity") ? origin["identity"].dump() : origin.dump());
}

Division divided_sweep(const Study& study, const Conduct& conduct, const char* verb,
                       std::vector<std::string> arguments, std::string subject) {
  return {.verb = verb,
          .arguments = std::move(arguments),
          .subject = std::move(subject),
          .units =
              [&study, conduct] {
                std::vector<Unit> units;
                const auto planned = plan(study, conduct);
                if (conduct.stop()) throw Interrupted();
                for (const auto& run : planned) units.push_back({run.key, run.number});
                return units;
              },
          .make =
              [&study, conduct, verb](const FolderLock& lock, const std::vector<Unit>& units,
                                      const MakeUnits& how) {
                const Conduct own{conduct.matched, how.stop};
                Results results(lock.folder() / fmt::format("{}.db", verb), study, how.stop);
                const auto summary = sweep(study, runs_of(study, own, units), own, results, lock, how.threads,
                                           [&](const SweepProgress& p) {
                                             if (how.on_progress) how.on_progress(p.done);
                                           });
                MadeUnits made{.failed = 0, .reasons = {}, .interrupted = summary.interrupted};
                for (const auto& [variant, formulation, reason] : results.failures())
                  made.add_failure(fmt::format("{}, {}: {}", variant, formulation, reason));
                return made;
              },
          .finish =
              [&study, verb](const std::filesystem::path& folder) {
                Results results(folder / fmt::format("{}.db", verb), study);
                results.derive(study);
                if (verb == std::string_view("sweep")) write_sweep_document(study, results, folder);
              }};
}

Division divided_ensemble(const Scene& scene, const EnsemblePlan& plan, std::vector<std::string> arguments) {
  const auto all_starts = identity(scene, plan);
  return {.verb = "ensemble",
          .arguments = std::move(arguments),
          .subject = run_key(all_starts, fmt::format("starts = {}\n", plan.starts)),
          .units =
              [&scene, plan, all_starts] {
                const Starts all(scene, plan);  // throws for an invalid plan
                std::vector<Unit> units;
                for (int k = 0; k < plan.starts; ++k)
                  units.push_back({run_key(all_starts, k), static_cast<std::size_t>(k)});
                return units;
              },
          .make =
              [&scene, plan, all_starts](const FolderLock& lock, const std::vector<Unit>& units,
                                         const MakeUnits& how) {
                auto own = plan;
                own.stop = how.stop;
                own.threads = how.threads;
                const EnsembleStore store(lock.folder() / "ensemble.db", Database::Access::write, how.stop);
                std::vector<int> starts;
                for (const auto& unit : units) {
                  starts.push_back(static_cast<int>(unit.number));
                  require_planned(run_key(all_starts, starts.back()) == unit.key, unit, scene.file);
                }
                MadeUnits made;
                std::size_t done = 0;
                Starts(scene, own)
                    .make_all(
                        starts, &store, [&](std::size_t place, const StartOutcome& outcome, bool found) {
                          if (outcome.interrupted) return;
                          if (!found) store.store(starts[place], outcome);
                          if (!outcome.failure.empty())
                            made.add_failure(fmt::format("start {}: {}", starts[place], outcome.failure));
                          if (how.on_progress) how.on_progress(++done);
                        });
                made.interrupted = how.stop();
                return made;
              }};
}

}  // namespace freeplay
