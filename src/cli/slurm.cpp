#include "cli/slurm.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "io/files/child.hpp"
#include "io/files/visible.hpp"
#include "mechanism/error.hpp"

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

}  // namespace freeplay::cli
