#include "cli/cluster/slurm.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "io/files/child.hpp"
#include "io/files/escaping.hpp"
#include "mechanism/error.hpp"
#include "study/partition/merge.hpp"
#include "study/partition/shard.hpp"

namespace freeplay::cli {
namespace {

/// Time limit of a Slurm command, s. A busy controller answers within its MessageTimeout, usually
/// 10 s.
double seconds_a_command() {
  constexpr double usual = 60;
  const char* const given = std::getenv("FREEPLAY_SLURM_SECONDS");
  if (!given) return usual;
  char* end = nullptr;
  const double seconds = std::strtod(given, &end);
  if (end == given || *end || !(seconds > 0) || seconds > 86400)
    throw SceneError(fmt::format("FREEPLAY_SLURM_SECONDS: must be above 0 and at most 86400 s, is {}",
                                 visible_brief(given)));
  return seconds;
}

}  // namespace

std::optional<Said> ask(const std::vector<std::string>& command, StopToken stop) {
  const double seconds = seconds_a_command();
  auto end = run_child({.command = command, .seconds = seconds, .listen = true, .stop = stop});
  if (end.status == 127 && end.output.empty()) return std::nullopt;
  Said said{std::move(end.output), std::move(end.errors), end.status == 0 && !end.late};
  if (end.late) said.errors = fmt::format("no answer within {:g} s; {}", seconds, said.errors);
  return said;
}

std::string job_name(const Manifest& manifest) { return "freeplay-" + manifest.plan.substr(0, 12); }

void requeue_this_job() {
  const char *const array = std::getenv("SLURM_ARRAY_JOB_ID"),
                    *const task = std::getenv("SLURM_ARRAY_TASK_ID"), *const id = std::getenv("SLURM_JOB_ID");
  if (!id) return;
  // The last task of an array has the array's number as its SLURM_JOB_ID; requeueing that would
  // requeue all tasks.
  const auto job = array && task ? std::string(array) + "_" + task : std::string(id);
  // A job that was cancelled or requeued by others is not running any more.
  const auto state = ask({"squeue", "-h", "-j", job, "-o", "%T"});
  if (state && state->well && state->text.starts_with("RUNNING")) ask({"scontrol", "requeue", job});
}

namespace {

bool is_of(const std::string& text, std::string_view others) {
  return !text.empty() && std::ranges::all_of(text, [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           others.find(c) != others.npos;
  });
}

/// The program that jobs call, or the script that starts it with bundled libraries
/// (scripts/bundle).
std::string program_file() {
  if (const char* named = std::getenv("FREEPLAY_PROGRAM"); named && *named) return named;
  return std::filesystem::read_symlink("/proc/self/exe").string();
}

std::vector<std::string> study_words(const Manifest& m) {
  std::vector<std::string> words{program_file(), m.verb};
  words.insert(words.end(), m.arguments.begin(), m.arguments.end());
  return words;
}

std::string heading(const JobRequest& request, const Manifest& m, const std::filesystem::path& folder) {
  auto text = fmt::format(
      "#!/bin/bash\n#SBATCH --job-name={}\n#SBATCH --cpus-per-task={}\n#SBATCH --requeue\n"
      "#SBATCH --open-mode=append\n#SBATCH --output=\"{}/%A_%a.log\"\n#SBATCH --time={}\n",
      job_name(m), request.cpus, (shards_folder(folder) / "log").string(), request.time);
  if (!request.partition.empty()) text += "#SBATCH --partition=" + request.partition + "\n";
  if (!request.exclude.empty()) text += "#SBATCH --exclude=" + request.exclude + "\n";
  return text;
}

}  // namespace

void require_plain(const JobRequest& request, const std::filesystem::path& folder) {
  const auto refuse = [](const char* what, const std::string& text, const char* right) {
    throw SceneError(fmt::format("{} {}: must be {}", what, visible(text), right));
  };
  if (!request.partition.empty() && !is_of(request.partition, "._,-"))
    refuse("--partition", request.partition,
           "names of letters, digits, '.', '_' and '-', with commas between them");
  if (!request.exclude.empty() && !is_of(request.exclude, "._,-"))
    refuse("--exclude", request.exclude,
           "names of letters, digits, '.', '_' and '-', with commas between them");
  if (!request.time.empty() && !is_of(request.time, ":-"))
    refuse("--time", request.time, "minutes, or as Slurm takes it: 30, 2:30:00, 1-12");
  const auto name = folder.string();
  if (std::ranges::any_of(name, [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; }) ||
      name.find_first_of("\"'\\%") != name.npos)
    refuse("-o", name,
           "a folder whose whole path has no quote, backslash, '%' or control character, for Slurm reads it");
}

void leave_out(JobRequest& request, const std::filesystem::path& folder,
               const std::vector<std::size_t>& lacking) {
  std::set<std::string> nodes;
  for (std::size_t at = 0; at < request.exclude.size();) {
    const auto end = std::min(request.exclude.find(',', at), request.exclude.size());
    if (end > at) nodes.insert(request.exclude.substr(at, end - at));
    at = end + 1;
  }
  const auto add = [&](const std::string& node) {
    if (is_of(node, "._-")) nodes.insert(node);
  };
  for (const auto k : lacking)
    if (const auto s = state_of(folder, k); s.state == "failed" && s.reason.find("scratch") != s.reason.npos)
      add(s.host);
  if (const char* here = std::getenv("SLURMD_NODENAME"); here && lacking.empty() && request.round > 1)
    add(here);
  request.exclude = fmt::format("{}", fmt::join(nodes, ","));
}

std::string array_script(const JobRequest& request, const Manifest& m, const std::filesystem::path& folder,
                         const std::vector<std::size_t>& lacking) {
  auto text = heading(request, m, folder);
  text += fmt::format("#SBATCH --array={}\n#SBATCH --signal=B:TERM@{}\n", ranges(lacking), request.lead);
  auto words = study_words(m);
  if (!request.scratch.empty()) words.insert(words.end(), {"--scratch", request.scratch});
  words.insert(words.end(), {"-o", folder.string()});
  return text + fmt::format("exec {} --shard \"$SLURM_ARRAY_TASK_ID/{}\"\n", shell_words(words), m.shards);
}

std::string merge_script(const JobRequest& request, const Manifest& m, const std::filesystem::path& folder) {
  auto merge = study_words(m);
  merge.insert(merge.end(), {"--merge", folder.string()});
  std::vector<std::string> submit{program_file(), "submit",
                                  request.study,  "--slurm",
                                  "-o",           folder.string(),
                                  "--time",       request.time,
                                  "--cpus",       std::to_string(request.cpus),
                                  "--signal",     std::to_string(request.lead),
                                  "--round",      std::to_string(request.round + 1)};
  if (request.outside) submit.emplace_back("--allow-outside");
  if (!request.partition.empty()) submit.insert(submit.end(), {"--partition", request.partition});
  if (!request.exclude.empty()) submit.insert(submit.end(), {"--exclude", request.exclude});
  if (!request.scratch.empty()) {
    merge.insert(merge.end(), {"--scratch", request.scratch});
    submit.insert(submit.end(), {"--scratch", request.scratch});
  }
  return heading(request, m, folder) +
         fmt::format("{} && exit 0\nexec {}\n", shell_words(merge), shell_words(submit));
}

}  // namespace freeplay::cli
