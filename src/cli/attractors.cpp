// freeplay bifurcation and freeplay basin: attractors as a function of one parameter, and for a
// grid of starts.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "cli/cluster/shards.hpp"
#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/figures.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/digest.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "study/attractors/attractor_exponents.hpp"
#include "study/attractors/attractor_table.hpp"
#include "study/partition/divided.hpp"
#include "study/settings/study.hpp"

namespace freeplay::cli {
namespace {

/// The parts in which the two verbs differ.
struct Verb {
  const char* name;  ///< also the name of its table in the study, and of its files
  const AttractorPlan* (*plan)(const Study&);
  std::vector<Chain> (*chains)(const Study&);
  Classified (*classified)(const SettledRuns&);
  std::string (*csv)(const Study&, const SettledRuns&, const Classified&);
  nlohmann::json (*json)(const Study&, const SettledRuns&, const Classified&);
  std::string (*text)(const Study&, const SettledRuns&, const Classified&);
};

/// Key of a chain, from everything that distinguishes it from others of the study.
std::string key_of(const Chain& chain) {
  auto text = chain.branch + "\n";
  for (const auto& link : chain.links)
    text +=
        fmt::format("{} {} {}\n", fmt::join(link.overrides, " "), fmt::join(link.values, " "), link.start);
  return digest(text);
}

/// Division of the study. Units are chains, because the runs of a chain depend on each other.
Division divided(const Study& study, const AttractorPlan& plan, const Verb& verb,
                 const StudyRequest& request) {
  return {.verb = verb.name,
          .arguments = study_arguments(request.study, request.reach),
          .subject = subject_of(study),
          .units =
              [&study, &verb] {
                std::vector<Unit> units;
                for (const auto& chain : verb.chains(study)) units.push_back({key_of(chain), units.size()});
                return units;
              },
          .make =
              [&study, &plan, &verb](const FolderLock& lock, const std::vector<Unit>& units,
                                     const MakeUnits& how) {
                const auto all = verb.chains(study);
                std::vector<Chain> chains;
                for (const auto& unit : units) {
                  require_planned(unit.number < all.size() && key_of(all[unit.number]) == unit.key, unit,
                                  study.file);
                  chains.push_back(all[unit.number]);
                }
                AttractorStore store(lock.folder() / fmt::format("{}.db", verb.name), how.stop);
                auto runs = settle(study, plan, verb.name, chains, store, how.threads, how.stop,
                                   [&](std::size_t done, std::size_t total) {
                                     if (how.on_progress) how.on_progress(done * units.size() / total);
                                   });
                if (plan.exponents && !runs.interrupted)
                  add_exponents(study, plan, chains, verb.classified(runs), store, how.threads, how.stop, {},
                                runs);
                MadeUnits made{.failed = 0, .reasons = {}, .interrupted = runs.interrupted};
                for (const auto& chain : runs.chains)
                  for (const auto& run : chain)
                    if (!run.finished())
                      made.add_failure(
                          fmt::format("{} at {}: {}", run.branch, fmt::join(run.values, ", "), run.failure));
                return made;
              }};
}

int attractors(const StudyRequest& request, const Verb& verb) {
  const auto study = read_study(request.study, request.reach);
  const auto* plan = verb.plan(study);
  if (!plan)
    throw SceneError(
        fmt::format("{}: has no table [{}]; see docs/how-to/attractors.md", request.study, verb.name));
  const auto folder =
      result_folder(request.output, default_folder(study.file, fmt::format("-{}", verb.name)));
  if (request.shards.requested())
    return in_shards(divided(study, *plan, verb, request), request.shards, folder, request.threads,
                     request.stop);
  auto origin = provenance(study);  // before the runs, since it reads the scene as the study names it
  origin["scene_file"] = study.scene.lexically_normal().string();
  ResultSet set(folder, verb.name);
  AttractorStore store(folder / fmt::format("{}.db", verb.name), request.stop);
  Progress progress;
  const auto show = [&](const char* what) {
    return [&progress, what](std::size_t done, std::size_t total) {
      progress.show(fmt::format("{} of {} {}", done, total, what),
                    static_cast<double>(done) / static_cast<double>(total));
    };
  };
  const auto chains = verb.chains(study);
  auto runs = settle(study, *plan, verb.name, chains, store, request.threads, request.stop, show("runs"));
  progress.clear();
  fmt::print("{} runs from the store, {} new\n", runs.found, runs.made);
  if (runs.interrupted) return interrupted(Kept::runs);
  const auto classified = verb.classified(runs);
  if (plan->exponents) {
    add_exponents(study, *plan, chains, classified, store, request.threads, request.stop, show("exponents"),
                  runs);
    progress.clear();
    if (runs.interrupted) return interrupted(Kept::runs);
  }
  write_json(set.place() / fmt::format("{}.json", verb.name),
             {{verb.name, verb.json(study, runs, classified)}}, origin);
  write_file(set.place() / fmt::format("{}.csv", verb.name), verb.csv(study, runs, classified));
  set.commit();
  fmt::print("{}", wrapped(verb.text(study, runs, classified)));
  draw_results(folder, Undrawn::is_error);
  int status = 0;
  for (const auto& chain : runs.chains)
    for (const auto& run : chain)
      if (!run.finished()) {
        fmt::print(stderr, "{} at {}: {}\n", run.branch, fmt::join(run.values, ", "), run.failure);
        status = 1;
      }
  return status;
}

constexpr Verb bifurcation_parts{
    "bifurcation",
    [](const Study& s) -> const AttractorPlan* { return s.bifurcation ? &*s.bifurcation : nullptr; },
    bifurcation_chains,
    attractors_at_each_value,
    bifurcation_csv,
    bifurcation_json,
    bifurcation_text};
constexpr Verb basin_parts{
    "basin",      [](const Study& s) -> const AttractorPlan* { return s.basin ? &*s.basin : nullptr; },
    basin_chains, attractors_of_all,
    basin_csv,    basin_json,
    basin_text};

int bifurcation(const StudyRequest& request) { return attractors(request, bifurcation_parts); }
int basin(const StudyRequest& request) { return attractors(request, basin_parts); }

void declare(Program& program, const Verb& verb, const char* what, int (*act)(const StudyRequest&)) {
  auto [options, request] = program.verb(verb.name, what, act);
  declare_study(options, request, "study file", "result folder; default out/NAME-VERB");
}

}  // namespace

void bifurcation_verb(Program& program) {
  declare(program, bifurcation_parts, "compute a bifurcation diagram over one parameter, swept up and down",
          bifurcation);
}

void basin_verb(Program& program) {
  declare(program, basin_parts, "compute basins of attraction over a grid of initial states", basin);
}

}  // namespace freeplay::cli
