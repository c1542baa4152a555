// freeplay submit: submits a divided study to Slurm as a job array with one task for each shard,
// and a job that merges the shards. The merge job starts when all tasks have ended, with or without
// success (afterany), and submits another round for missing shards.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <set>

#include "cli/cluster/shards.hpp"
#include "cli/cluster/slurm.hpp"
#include "cli/command_line.hpp"
#include "cli/folders.hpp"
#include "io/files/escaping.hpp"
#include "mechanism/error.hpp"
#include "study/partition/divided.hpp"
#include "study/partition/division.hpp"
#include "study/partition/merge.hpp"
#include "study/partition/shard.hpp"

namespace freeplay::cli {
namespace {

constexpr int most_rounds = 5;
// s, start of a task: Slurm, the program, files.
constexpr double pilot_seconds = 10, start_seconds = 2;
constexpr std::size_t pilot_units = 63;  // 1 + 2 + … + 32

struct SubmitRequest : Request {
  std::string output;
  Reach reach = Reach::beside;
  bool slurm = false, dry = false;
  int array = 0;
  JobRequest job;
};

/// Computing time of a unit, measured by running some units in a temporary folder.
struct Pilot {
  double unit = 0, greatest = 0;
  std::size_t made = 0;
};
Pilot pilot(const Division& study, const std::vector<Unit>& units, const SubmitRequest& request) {
  const Scratch own(scratch_folder(request.job.scratch), "pilot0000000");
  Pilot p;
  double spent = 0;
  // Choose units from the whole study, because neighbours have similar costs. Batches grow, so that
  // the last one gives the cost of a unit without that of opening files.
  const auto most = std::min(pilot_units, units.size());
  double last = 0;
  std::size_t size = 1, of_last = 1;
  for (; p.made + size <= most && spent < pilot_seconds && !request.stop(); size *= 2) {
    std::vector<Unit> batch;
    for (std::size_t i = 0; i < size; ++i) batch.push_back(units[(p.made + i) * units.size() / most]);
    const auto began = std::chrono::steady_clock::now();
    study.make(own.lock(), batch, {.threads = 1, .stop = request.stop});
    last = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    of_last = size;
    spent += last;
    p.greatest = std::max(p.greatest, last / static_cast<double>(size));
    p.made += size;
  }
  p.unit = last / static_cast<double>(of_last);
  return p;
}

/// Number of shards, a multiple of the cores: four for each core, so that all cores are busy to the
/// end, but fewer (at least one for each core) if the start of a task would take more than two per
/// cent of its work.
std::size_t shards_for(const Pilot& p, std::size_t units, std::size_t cores) {
  const double work = p.unit * static_cast<double>(units);
  const double most = std::max(1.0, work / (50 * start_seconds)), even = static_cast<double>(4 * cores);
  const auto n =
      static_cast<std::size_t>(std::ceil(std::max(std::min(most, even), static_cast<double>(cores))));
  return std::clamp<std::size_t>((n + cores - 1) / cores * cores, 1, std::min<std::size_t>(units, 10000));
}

std::size_t cores_of(const std::string& partition, StopToken stop) {
  std::vector<std::string> words{"sinfo", "-h", "-o", "%C"};
  if (!partition.empty()) words.insert(words.end(), {"-p", partition});
  const auto said = ask(words, stop);  // allocated/idle/other/total
  if (!said || !said->well) return 1;
  const auto last = said->text.rfind('/');
  return last == said->text.npos
             ? 1
             : static_cast<std::size_t>(std::max(std::atoi(said->text.c_str() + last + 1), 1));
}

/// Throws if Slurm is not available; called before any measurement or output.
void require_slurm(StopToken stop) {
  const auto said = ask({"sbatch", "--version"}, stop);
  if (said && !said->well) throw std::runtime_error("sbatch --version: " + visible(said->errors));
  if (!said)
    throw SceneError(
        "--slurm: Slurm is not installed here (no sbatch); docs/how-to/cluster.md shows how to run shards "
        "without "
        "it");
}

/// Numbers of the study's queued and running jobs, except this one.
std::set<std::string> jobs_of(const Manifest& m, StopToken stop) {
  const auto said = ask({"squeue", "-h", "-n", job_name(m), "-o", "%A"}, stop);
  if (!said || !said->well)
    throw std::runtime_error("squeue: " + visible(said ? said->errors : "is not there"));
  std::set<std::string> jobs;
  for (std::size_t at = 0; at < said->text.size();) {
    const auto end = said->text.find('\n', at);
    jobs.insert(said->text.substr(at, end - at));
    at = end == said->text.npos ? said->text.size() : end + 1;
  }
  if (const char* own = std::getenv("SLURM_JOB_ID")) jobs.erase(own);
  return jobs;
}

std::string hand_in(const std::filesystem::path& script, const std::vector<std::string>& options,
                    StopToken stop) {
  std::vector<std::string> words{"sbatch", "--parsable"};
  words.insert(words.end(), options.begin(), options.end());
  words.push_back(script.string());
  const auto said = ask(words, stop);
  if (!said || !said->well)
    throw std::runtime_error(
        fmt::format("sbatch {}: {}\nsqueue lists the accepted jobs; the same command submits no job twice",
                    script.filename().string(), visible(said ? said->errors : "is not there")));
  return said->text.substr(0, said->text.find_first_of(";\n"));
}

std::string minutes(double seconds) {
  return fmt::format("{}", std::max(2, static_cast<int>(std::ceil(seconds / 60))));
}

/// Checks that a plan in the folder is that of this study. The folder may be of unknown origin, so
/// the plan's commands are not run otherwise.
void require_planned(const Manifest& m, const SubmitRequest& request, const std::filesystem::path& folder) {
  constexpr std::array<std::string_view, 4> verbs{"sweep", "bifurcation", "basin", "calibrate"};
  if (std::ranges::find(verbs, m.verb) == verbs.end() ||
      m.arguments != study_arguments(request.job.study, request.reach))
    throw SceneError(
        fmt::format("{}: contains the plan of another study: {} {}; give another folder with "
                    "-o",
                    shards_folder(folder).string(), visible(m.verb), shell_words(m.arguments)));
}

int submit(const SubmitRequest& requested) {
  auto request = requested;
  if (!request.slurm) throw SceneError("submit: give a scheduler: --slurm");
  const auto study = read_study(request.job.study, request.reach);
  request.job.outside = request.reach == Reach::anywhere;
  const auto folder =
      std::filesystem::absolute(result_folder(request.output, default_folder(study.file, "")));
  const bool planned = std::filesystem::exists(shards_folder(folder) / "manifest.json");
  require_plain(request.job, folder);
  if (!request.dry) require_slurm(request.stop);
  auto& time = request.job.time;
  if (!planned) {
    auto division = divided_sweep(study, request.conduct(), "sweep",
                                  study_arguments(request.job.study, request.reach), subject_of(study));
    const auto all = division.units();  // computed once, half a millisecond each
    division.units = [&all] { return all; };
    const auto p = pilot(division, all, request);
    if (request.stop()) throw Interrupted();
    const auto units = all.size();
    const auto n = request.array > 0 ? static_cast<std::size_t>(request.array)
                                     : shards_for(p, units, cores_of(request.job.partition, request.stop));
    // Time limit: three times the expected time, for busy nodes, plus the current unit. A task that
    // takes longer is requeued.
    const double expected =
        p.unit * std::ceil(static_cast<double>(units) / static_cast<double>(n)) / request.job.cpus;
    if (time.empty()) time = minutes(3 * expected + p.greatest + request.job.lead + 60);
    const auto m = make_plan(division, folder, n);
    fmt::print(
        "pilot: {} of {} units, {:.3g} s each (at most {:.3g} s); {} shards of about {:.3g} s, time limit "
        "{} min\n",
        p.made, units, p.unit, p.greatest, m.shards, expected, time);
  }
  const auto m = read_manifest(folder);
  require_planned(m, request, folder);
  if (time.empty()) time = "60";
  std::vector<std::size_t> lacking;
  for (const auto& [k, why] : not_whole(m, folder, false)) lacking.push_back(k);
  const auto place = shards_folder(folder);
  if (!request.dry)
    if (const auto jobs = jobs_of(m, request.stop); !jobs.empty()) {
      fmt::print("{} is already submitted as job {}; nothing was done\n", request.job.study,
                 fmt::join(jobs, ", "));
      return 0;
    }
  if (request.job.round > most_rounds)
    throw std::runtime_error(
        fmt::format("{}: after {} rounds {} of {} shards are missing: {}; see freeplay status for the "
                    "reasons",
                    place.string(), most_rounds, lacking.size(), m.shards, ranges(lacking)));
  leave_out(request.job, folder, lacking);
  const auto merge = merge_script(request.job, m, folder);
  const auto array = lacking.empty() ? std::string() : array_script(request.job, m, folder, lacking);
  if (request.dry) {
    fmt::print("# array.sh\n{}\n# merge.sh, after it (afterany)\n{}", array, merge);
    return 0;
  }
  std::filesystem::create_directories(place / "log");
  write_file(place / "merge.sh", merge, OutputFile::Shared());
  std::vector<std::string> after;
  if (!array.empty()) {
    write_file(place / "array.sh", array, OutputFile::Shared());
    const auto job = hand_in(place / "array.sh", {}, request.stop);
    fmt::print("{} shards as job {}\n", lacking.size(), job);
    after = {"--dependency=afterany:" + job};
  }
  fmt::print("merge as job {}\n", hand_in(place / "merge.sh", after, request.stop));
  return 0;
}

}  // namespace

void submit_verb(Program& program) {
  auto [options, request] =
      program.verb("submit", "submit a study to a cluster: an array of shards and a merge job", submit);
  options.add("study", request.job.study, "study file").required();
  options.flag("--slurm", request.slurm, "submit to Slurm");
  options.add("--array", request.array, "number of shards; default from a pilot")
      .between(1, 1'000'000)
      .takes("N");
  options.add("--partition", request.job.partition, "partition of the cluster").takes("NAME");
  options.add("--exclude", request.job.exclude, "nodes to avoid, separated by commas").takes("NAMES");
  options.add("--time", request.job.time, "time limit of a task in Slurm's format; default from a pilot")
      .takes("TIME");
  options.add("--cpus", request.job.cpus, "cores per task").between(1, 1024).takes("N").shows_default();
  options.add("--signal", request.job.lead, "seconds before its limit at which a task stops and is requeued")
      .between(1, 86400)
      .takes("N")
      .shows_default();
  options
      .add("--scratch", request.job.scratch,
           "folder on the local disks of the nodes; default $TMPDIR or "
           "/tmp there")
      .takes("FOLDER");
  options.add("--round", request.job.round, "number of resubmissions of missing shards so far")
      .between(1, 100)
      .takes("N");
  options.flag("--dry-run", request.dry, "print the scripts without submitting them");
  options.output(request.output, "result folder; default out/NAME");
  options.allow_outside(request.reach);
}

}  // namespace freeplay::cli
