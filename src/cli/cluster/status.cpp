// freeplay status: progress of a divided study, from the files of its shards, and from squeue if
// available.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>

#include "cli/cluster/shards.hpp"
#include "cli/cluster/slurm.hpp"
#include "cli/command_line.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/escaping.hpp"
#include "study/partition/merge.hpp"
#include "study/partition/shard.hpp"

namespace freeplay::cli {
namespace {

struct StatusRequest : Request {
  std::string study, output;
};

std::string time_of(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", seconds);
  if (seconds < 5400) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

int status(const StatusRequest& request) {
  const auto folder = result_folder(request.output, default_folder(request.study, ""));
  const auto m = read_manifest(folder);
  const double now =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  std::size_t whole = 0, running = 0, waiting = 0, done = 0, failed_runs = 0;
  double seconds = 0;
  std::vector<std::string> notes;
  for (std::size_t k = 1; k <= m.shards; ++k) {
    if (const auto seal = read_seal(folder, k)) {
      if (const auto fault = fault_of(*seal, m, folder, false); !fault.empty()) {
        notes.push_back(fmt::format("shard {}: {}", k, fault));
        ++waiting;
        continue;
      }
      ++whole;
      done += seal->units;
      seconds += seal->seconds;
      failed_runs += seal->failed;
      for (const auto& reason : seal->reasons)
        notes.push_back(fmt::format("shard {}: {}", k, visible(reason)));
      continue;
    }
    const auto s = state_of(folder, k);
    done += s.done;
    seconds += s.seconds;
    if (s.state == "running") {
      ++running;
      if (now - s.when > 60)
        notes.push_back(fmt::format("shard {}: on {}, no sign of life for {}", k, visible(s.host),
                                    time_of(now - s.when)));
    } else {
      ++waiting;
      if (s.state == "failed")
        notes.push_back(fmt::format("shard {}: on {}: {}", k, visible(s.host), visible(s.reason)));
    }
  }
  fmt::print("{} of {} units, {} of {} shards complete, {} running, {} waiting; {} runs failed\n", done,
             m.units, whole, m.shards, running, waiting, failed_runs);
  if (done > 0 && done < m.units && running > 0)
    fmt::print("expected to end in {}, at the present number of tasks\n",
               time_of(seconds / static_cast<double>(done) * static_cast<double>(m.units - done) /
                       static_cast<double>(running)));
  const auto queue = ask({"squeue", "-h", "-r", "-n", job_name(m), "-o", "%i %T %r"}, request.stop);
  if (queue && !queue->well) notes.push_back("squeue: " + visible(queue->errors));
  if (queue && queue->well)
    fmt::print("{}", queue->text.empty() ? "Slurm has no job of this study\n"
                                         : "Slurm's jobs (id, state, reason):\n" + queue->text);
  for (const auto& note : notes) fmt::print("{}", wrapped(note + "\n"));
  if (whole == m.shards)
    fmt::print("{}", wrapped(fmt::format("all shards are complete: {}\n",
                                         command_for(m, {"--merge", folder.string()}))));
  return 0;
}

}  // namespace

void status_verb(Program& program) {
  auto [options, request] = program.verb(
      "status", "show the progress of a study on a cluster: shards, failures, expected end", status);
  options.add("study", request.study, "study file of the plan").required();
  options.output(request.output, "result folder; default out/NAME");
}

}  // namespace freeplay::cli
