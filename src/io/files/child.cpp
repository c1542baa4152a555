#include "io/files/child.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>

#include "io/files/output_file.hpp"

namespace freeplay {
namespace {

constexpr int pause = 50;  // ms, between two checks of the stop token
constexpr std::size_t most_errors = 1 << 16, most_output = 1 << 24;

/// A pipe, closed on destruction. The child inherits its ends by dup2 only.
struct Pipe {
  Pipe() {
    if (pipe2(ends.data(), O_CLOEXEC) != 0)
      throw OutputError(fmt::format("cannot create a pipe to another program: {}", std::strerror(errno)));
  }
  ~Pipe() {
    close_end(0);
    close_end(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void close_end(int which) {
    if (ends[which] >= 0) close(ends[which]);
    ends[which] = -1;
  }
  std::array<int, 2> ends{-1, -1};
};

/// Runs in the child between fork and exec. Only system calls are allowed there, because another
/// thread of the parent may have held any lock at the fork.
[[noreturn]] void become(char* const* command, const char* folder, pid_t parent, const Pipe& in,
                         const Pipe* output, const Pipe& errors) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);
  for (const int signal : {SIGPIPE, SIGXFSZ})
    std::signal(signal, SIG_DFL);  // ignored signals stay ignored after exec
  const int to = output ? output->ends[1] : open("/dev/null", O_WRONLY);
  if (to < 0 || dup2(in.ends[0], 0) < 0 || dup2(to, 1) < 0 || dup2(errors.ends[1], 2) < 0) _exit(127);
  if (*folder && chdir(folder) != 0) _exit(127);
  execvp(command[0], command);
  _exit(127);
}

/// Reads what is available from a pipe, and closes it at its end. False if nothing was read.
bool take(Pipe& pipe, std::string& text, std::size_t most) {
  std::array<char, 4096> piece{};
  const auto come = read(pipe.ends[0], piece.data(), piece.size());
  if (come > 0) text.append(piece.data(), std::min(static_cast<std::size_t>(come), most - text.size()));
  if (come == 0 || (come < 0 && errno != EAGAIN && errno != EINTR)) pipe.close_end(0);
  return come > 0;
}

}  // namespace

ChildEnd run_child(const Child& child) {
  using Clock = std::chrono::steady_clock;
  std::vector<char*> command;
  auto words = child.command;
  for (auto& word : words) command.push_back(word.data());
  command.push_back(nullptr);
  const auto folder = child.folder.string();

  Pipe in, output, errors;
  const pid_t parent = getpid(), id = fork();
  if (id < 0) throw OutputError(fmt::format("{}: cannot be started: {}", words[0], std::strerror(errno)));
  if (id == 0) become(command.data(), folder.c_str(), parent, in, child.listen ? &output : nullptr, errors);
  in.close_end(0);
  output.close_end(1);
  errors.close_end(1);
  for (const int end : {in.ends[1], output.ends[0], errors.ends[0]}) fcntl(end, F_SETFL, O_NONBLOCK);
  if (!child.listen) output.close_end(0);

  ChildEnd end;
  const auto until = Clock::now() + std::chrono::duration<double>(child.seconds);
  auto rest = child.input;
  bool interrupted = false;
  for (int status = 0;;) {
    // poll() ignores negative descriptors.
    std::array<pollfd, 3> waits{
        {{in.ends[1], POLLOUT, 0}, {errors.ends[0], POLLIN, 0}, {output.ends[0], POLLIN, 0}}};
    poll(waits.data(), waits.size(), pause);
    if (waits[0].revents) {
      const auto gone = rest.empty() ? 0 : write(in.ends[1], rest.data(), rest.size());
      if (gone > 0) rest.remove_prefix(static_cast<std::size_t>(gone));
      if (rest.empty() || (gone < 0 && errno != EAGAIN && errno != EINTR)) in.close_end(1);
    }
    if (waits[1].revents) take(errors, end.errors, most_errors);
    if (waits[2].revents) take(output, end.output, most_output);
    interrupted = interrupted || child.stop();
    end.late = end.late || Clock::now() > until;
    if (interrupted || end.late) kill(id, SIGKILL);
    // Do not wait for the end of its standard error: the child's own children may keep that open.
    if (waitpid(id, &status, WNOHANG) != id) continue;
    end.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    break;
  }
  // Read the remaining output.
  while (errors.ends[0] >= 0 && take(errors, end.errors, most_errors)) {
  }
  while (output.ends[0] >= 0 && take(output, end.output, most_output)) {
  }
  if (interrupted) throw Interrupted();
  return end;
}

}  // namespace freeplay
