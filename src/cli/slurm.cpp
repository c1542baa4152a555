#include "cli/slurm.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>

namespace freeplay::cli {
namespace {

std::string all_of(int descriptor) {
  std::string text;
  std::array<char, 65536> buffer;
  for (;;) {
    const auto n = read(descriptor, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(n));
  }
}

}  // namespace

std::optional<Said> ask(const std::vector<std::string>& command) {
  int ends[2];
  char errors[] = "/tmp/freeplay-said-XXXXXX";
  const int file = mkostemp(errors, O_CLOEXEC);
  if (file < 0 || pipe2(ends, O_CLOEXEC) != 0) return std::nullopt;
  unlink(errors);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], 1);
  posix_spawn_file_actions_adddup2(&actions, file, 2);
  std::vector<char*> words;
  for (const auto& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, words[0], &actions, nullptr, words.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  std::optional<Said> said;
  if (failed == 0) {
    said.emplace();
    said->text = all_of(ends[0]);
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    said->well = WIFEXITED(status) && WEXITSTATUS(status) == 0;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 127 && said->text.empty()) said.reset();
    lseek(file, 0, SEEK_SET);
    if (said) said->errors = all_of(file);
  }
  close(ends[0]);
  close(file);
  return said;
}

std::string job_name(const Manifest& manifest) { return "freeplay-" + manifest.plan.substr(0, 12); }

void requeue_this_job() {
  const char *const array = std::getenv("SLURM_ARRAY_JOB_ID"),
                    *const task = std::getenv("SLURM_ARRAY_TASK_ID"), *const id = std::getenv("SLURM_JOB_ID");
  if (!id) return;
  // The last task of an array has the array's own number as its SLURM_JOB_ID, and that would requeue all tasks.
  const auto job = array && task ? std::string(array) + "_" + task : std::string(id);
  // A job that is cancelled or requeued by others is not running any more.
  const auto state = ask({"squeue", "-h", "-j", job, "-o", "%T"});
  if (state && state->well && state->text.starts_with("RUNNING")) ask({"scontrol", "requeue", job});
}

}  // namespace freeplay::cli
