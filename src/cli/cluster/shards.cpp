#include "cli/cluster/shards.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cstdlib>

#include "cli/cluster/slurm.hpp"
#include "cli/ending.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/escaping.hpp"
#include "mechanism/error.hpp"
#include "study/partition/merge.hpp"
#include "study/partition/shard.hpp"

namespace freeplay::cli {
namespace {

/// Exit status of a process that was stopped and can be continued by the same command.
constexpr int stopped_status = 75;

/// Default number of threads: those that Slurm assigned to the task, else 0, all cores.
int threads_of(int requested) {
  const char* given = std::getenv("SLURM_CPUS_PER_TASK");
  return requested > 0 || !given ? requested : std::max(std::atoi(given), 0);
}

std::pair<std::size_t, std::size_t> read_shard(const std::string& text) {
  std::size_t k = 0, n = 0;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, k);
  if (first.ec == std::errc() && first.ptr != end && *first.ptr == '/') {
    const auto second = std::from_chars(first.ptr + 1, end, n);
    if (second.ec == std::errc() && second.ptr == end && k >= 1 && k <= n) return {k, n};
  }
  throw SceneError(fmt::format("--shard {}: must be k/N with 1 <= k <= N, as in 3/24", visible(text)));
}

int plan_shards(const Division& study, const ShardOptions& requested, const std::filesystem::path& folder) {
  const auto m = make_plan(study, folder, static_cast<std::size_t>(requested.plan));
  fmt::print("{} units in {} shards of {} to {}; plan file: {}\n", m.units, m.shards, m.units / m.shards,
             (m.units + m.shards - 1) / m.shards, (shards_folder(folder) / "manifest.json").string());
  fmt::print("each: {}\nthen: {}\n",
             command_for(m, {"--shard", fmt::format("k/{}", m.shards), "-o", folder.string()}),
             command_for(m, {"--merge", folder.string()}));
  return 0;
}

int one_shard(const Division& study, const ShardOptions& requested, const std::filesystem::path& folder,
              int threads, StopToken stop) {
  const auto said = read_shard(requested.shard);
  const auto k = said.first;
  const auto n = said.second;
  if (const auto m = read_manifest(folder); m.shards != n)
    throw SceneError(fmt::format("--shard {}: {} has {} shards", requested.shard, folder.string(), m.shards));
  Progress progress;
  const auto made = make_shard(study, folder,
                               {.shard = k,
                                .scratch = scratch_folder(requested.scratch),
                                .threads = threads_of(threads),
                                .stop = stop,
                                .on_progress =
                                    [&](std::size_t done, std::size_t total) {
                                      progress.show(fmt::format("shard {}/{}", k, n),
                                                    static_cast<double>(done) / static_cast<double>(total));
                                    },
                                .on_stop = take_time});
  progress.clear();
  if (made.interrupted) {
    fmt::print(stderr, "shard {}/{}: interrupted; finished runs are kept, and the same command continues\n",
               k, n);
    requeue_this_job();
    return stopped_status;
  }
  fmt::print("shard {}/{}: {}{} units, {} failed, in {:.3g} s\n", k, n,
             made.found ? "already complete: " : "", made.seal.units, made.seal.failed, made.seal.seconds);
  return 0;
}

int merge(const Division& study, const ShardOptions& requested) {
  const auto folder = real_folder(requested.merge);
  const auto s = merge_shards(study, folder, scratch_folder(requested.scratch));
  fmt::print("{} shards, {} units {} in {:.3g} s, {} failed\nresults in {}\n", s.shards, s.units,
             s.found ? "were merged before, verified" : "merged", s.seconds, s.failed,
             (folder / (study.verb + ".db")).string());
  fmt::print("tables and figures: freeplay {} {} -o {}\n", study.verb, shell_words(study.arguments),
             shell_words({folder.string()}));
  return 0;
}

}  // namespace

void declare_shards(Options& options, ShardOptions& into) {
  auto plan = options
                  .add("--plan", into.plan,
                       "divide the work into N shards for several machines; "
                       "docs/how-to/cluster.md")
                  .between(1, 1'000'000)
                  .takes("N");
  auto shard =
      options.add("--shard", into.shard, "run shard k of the N planned in the result folder").takes("k/N");
  auto merge =
      options.add("--merge", into.merge, "verify and merge the shards of a result folder").takes("FOLDER");
  options.add("--scratch", into.scratch, "folder on a local disk for a shard or a merge").takes("FOLDER");
  plan.excludes(shard);
  plan.excludes(merge);
  shard.excludes(merge);
}

void declare_study(Options& options, StudyRequest& into, const char* file, const char* output) {
  options.add("study", into.study, file).required();
  options.output(into.output, output);
  options.allow_outside(into.reach);
  options.threads(into.threads);
  declare_shards(options, into.shards);
}

bool divides(const std::string& option) {
  return option == "--plan" || option == "--shard" || option == "--merge";
}

std::string why_undivided(const std::string& verb) {
  if (verb == "continue")
    return "a continuation cannot be divided, because each "
           "motion of a branch starts from the one before; divide "
           "a chart by one study file for each branch (docs/how-to/cluster.md)";
  if (verb == "tradeoff")
    return "tradeoff cannot be divided, because it measures cost on one otherwise idle machine";
  return fmt::format(
      "{} cannot be divided; sweep, bifurcation, basin, calibrate and ensemble can (docs/how-to/cluster.md)",
      verb);
}

int in_shards(const Division& study, const ShardOptions& requested, const std::filesystem::path& folder,
              int threads, StopToken stop) {
  if (requested.plan > 0) return plan_shards(study, requested, folder);
  if (!requested.shard.empty()) return one_shard(study, requested, folder, threads, stop);
  return merge(study, requested);
}

std::filesystem::path scratch_folder(const std::string& requested) {
  if (!requested.empty()) return requested;
  for (const char* name : {"FREEPLAY_SCRATCH", "SLURM_TMPDIR", "TMPDIR"})
    if (const char* value = std::getenv(name); value && *value) return value;
  return "/tmp";
}

std::vector<std::string> study_arguments(const std::string& file, Reach reach) {
  std::vector<std::string> list{std::filesystem::absolute(file).lexically_normal().string()};
  if (reach == Reach::anywhere) list.emplace_back("--allow-outside");
  return list;
}

}  // namespace freeplay::cli
