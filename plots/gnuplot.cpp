#include "plots/gnuplot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gnuplot-iostream.h>
#include <cerrno>
#include <cstring>

#include "io/descriptor.hpp"
#include "io/input_file.hpp"
#include "io/output_file.hpp"

namespace freeplay::plots {
namespace {

constexpr const char* said = "said";  ///< file in the folder that takes gnuplot's messages

[[noreturn]] void fail(int reason) {
  throw OutputError(fmt::format("gnuplot: cannot be started: {}", std::strerror(reason)));
}

/// A child in `folder` that reads its commands from `commands`.
pid_t start(const Descriptor& folder, const Descriptor& commands) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addfchdir_np(&actions, folder.number());
  posix_spawn_file_actions_adddup2(&actions, commands.number(), 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, said, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW, 0666);
  char program[] = "gnuplot", bare[] = "--default-settings";
  char* const arguments[] = {program, bare, nullptr};
  pid_t child = 0;
  const int reason = posix_spawnp(&child, program, &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (reason != 0) fail(reason);
  return child;
}

}  // namespace

std::string run_gnuplot(const std::filesystem::path& folder, const std::string& script) {
  const auto place = open_folder(folder);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) fail(errno);
  Descriptor read(ends[0]), write(ends[1]);
  const pid_t child = start(place, read);
  read = Descriptor();
  if (std::FILE* commands = fdopen(write.number(), "w")) {
    write.release();
    Gnuplot gnuplot(commands);
    gnuplot << "load '" << script << "'\n";
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  LineReader lines(folder / said);
  std::string line;
  while (line.empty() && lines.next(line)) continue;
  return line.empty() ? "it ended without a word" : line;
}

}  // namespace freeplay::plots
