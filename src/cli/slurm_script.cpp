#include "cli/slurm_script.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "cli/slurm.hpp"
#include "io/shell_words.hpp"
#include "io/visible.hpp"
#include "model/error.hpp"
#include "study/merge.hpp"
#include "study/shard.hpp"

namespace freeplay::cli {
namespace {

bool is_of(const std::string& text, std::string_view others) {
  return !text.empty() && std::ranges::all_of(text, [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           others.find(c) != others.npos;
  });
}

/// What jobs call: the program, or what started it with libraries of its own (scripts/bundle).
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
  return text;
}

/// Nodes whose scratch refused one of the shards. A name that no machine has is passed over: the file may be anyone's.
std::set<std::string> full_nodes(const std::filesystem::path& folder,
                                 const std::vector<std::size_t>& shards) {
  std::set<std::string> full;
  for (const auto k : shards)
    if (const auto s = state_of(folder, k);
        s.state == "failed" && s.reason.find("scratch") != s.reason.npos && is_of(s.host, "._-"))
      full.insert(s.host);
  return full;
}

}  // namespace

void require_plain(const JobRequest& request, const std::filesystem::path& folder) {
  const auto refuse = [](const char* what, const std::string& text, const char* right) {
    throw SceneError(fmt::format("{} {}: must be {}", what, visible(text), right));
  };
  if (!request.partition.empty() && !is_of(request.partition, "._,-"))
    refuse("--partition", request.partition,
           "names of letters, digits, '.', '_' and '-', with commas between them");
  if (!request.time.empty() && !is_of(request.time, ":-"))
    refuse("--time", request.time, "minutes, or as Slurm takes it: 30, 2:30:00, 1-12");
  const auto name = folder.string();
  if (std::ranges::any_of(name, [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; }) ||
      name.find_first_of("\"'\\%") != name.npos)
    refuse("-o", name,
           "a folder whose whole path has no quote, backslash, '%' or control character, for Slurm reads it");
}

std::string array_script(const JobRequest& request, const Manifest& m, const std::filesystem::path& folder,
                         const std::vector<std::size_t>& lacking) {
  auto text = heading(request, m, folder);
  text += fmt::format("#SBATCH --array={}\n#SBATCH --signal=B:TERM@{}\n", ranges(lacking), request.lead);
  if (const auto full = full_nodes(folder, lacking); !full.empty())
    text += fmt::format("#SBATCH --exclude={}\n", fmt::join(full, ","));
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
  if (!request.scratch.empty()) {
    merge.insert(merge.end(), {"--scratch", request.scratch});
    submit.insert(submit.end(), {"--scratch", request.scratch});
  }
  return heading(request, m, folder) +
         fmt::format("{} && exit 0\nexec {}\n", shell_words(merge), shell_words(submit));
}

}  // namespace freeplay::cli
