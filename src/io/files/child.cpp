#include "io/files/child.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <ctime>

#include "io/files/access.hpp"
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

/// What a child needs between fork and exec, made before the fork: only system calls are allowed there,
/// because another thread of the parent may have held any lock at the fork.
struct Prepared {
  explicit Prepared(const Child& child) : words(child.command) {
    if (child.temporary) variables.push_back("TMPDIR=" + child.folder.string());
    for (char** old = environ; *old; ++old)
      if (std::ranges::none_of(variables, [&](const std::string& v) {
            return std::string_view(*old).starts_with(v.substr(0, v.find('=') + 1));
          }))
        environment.push_back(*old);
    for (auto& word : words) command.push_back(word.data());
    for (auto& variable : variables) environment.push_back(variable.data());
    command.push_back(nullptr);
    environment.push_back(nullptr);
  }
  std::vector<std::string> words, variables;
  std::vector<char*> command, environment;
};

/// What the guard's signal handler needs.
volatile pid_t group = 0, starter = 0;
const char* volatile temporary = nullptr;

/// Ends the group of the command and waits for the end of its processes. Where nobody else can do that
/// any more, removes the temporary folder.
void end_group(int) {
  kill(-group, SIGKILL);
  while (waitpid(-group, nullptr, 0) > 0 || errno == EINTR) {
  }
  // The signal comes when the thread ends that started the guard; its process may end a moment later.
  constexpr timespec moment{0, 1'000'000};
  for (int i = 0; i < 100 && temporary && getppid() == starter; ++i) nanosleep(&moment, nullptr);
  if (getppid() != starter && temporary) execl("/bin/rm", "rm", "-rf", "--", temporary, nullptr);
  _exit(128 + SIGKILL);
}

[[noreturn]] void become(const Prepared& made, const sigset_t& mask) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal : {SIGTERM, SIGPIPE, SIGXFSZ})
    std::signal(signal, SIG_DFL);  // ignored signals stay ignored after exec
  sigprocmask(SIG_SETMASK, &mask, nullptr);
  execvpe(made.command[0], made.command.data(), made.environment.data());
  _exit(127);
}

/// The guard: a process between this one and the command. It has the command in a process group of its
/// own, and ends that group when the command ends, on SIGTERM, and when this process ends. It starts with
/// all signals blocked, because handlers of this process must not run there. `mask`: that of the command.
[[noreturn]] void guard(const Prepared& made, const char* folder, bool own, pid_t parent,
                        const sigset_t& mask, const Pipe& in, const Pipe* output, const Pipe& errors) {
  setpgid(0, 0);  // signals of a terminal are for this process, which decides
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  sigset_t term;
  sigemptyset(&term);
  sigaddset(&term, SIGTERM);
  starter = parent;
  if (own) temporary = folder;
  std::signal(SIGTERM, end_group);
  std::signal(SIGCHLD, SIG_DFL);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(127);
  const int to = output ? output->ends[1] : open("/dev/null", O_WRONLY);
  if (to < 0 || dup2(in.ends[0], 0) < 0 || dup2(to, 1) < 0 || dup2(errors.ends[1], 2) < 0) _exit(127);
  if (*folder && chdir(folder) != 0) _exit(127);  // the folder may be named by a descriptor
  close_range(3, ~0U, 0);                         // locks of files, and pipes to other children
  const pid_t id = fork();
  if (id < 0) _exit(127);
  if (id == 0) become(made, mask);
  setpgid(id, id);
  group = id;
  close_range(0, 2, 0);
  sigprocmask(SIG_UNBLOCK, &term, nullptr);
  siginfo_t info;
  while (waitid(P_PID, static_cast<id_t>(id), &info, WEXITED | WNOWAIT) != 0 && errno == EINTR) {
  }
  sigprocmask(SIG_BLOCK, &term, nullptr);
  kill(-id, SIGKILL);
  int status = 0;
  waitpid(id, &status, 0);
  while (waitpid(-id, nullptr, 0) > 0) {
  }
  _exit(WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status));
}

/// write() to a pipe that may have no reader: EPIPE without SIGPIPE, whatever this process does with
/// the signal.
ssize_t write_quietly(int to, std::string_view text) {
  sigset_t broken, before, pending;
  sigemptyset(&broken);
  sigaddset(&broken, SIGPIPE);
  sigpending(&pending);
  pthread_sigmask(SIG_BLOCK, &broken, &before);
  const auto gone = write(to, text.data(), text.size());
  const int error = errno;
  constexpr timespec at_once{};
  if (gone < 0 && error == EPIPE && !sigismember(&pending, SIGPIPE)) sigtimedwait(&broken, nullptr, &at_once);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  errno = error;
  return gone;
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
  const Prepared made(child);
  const auto folder = child.folder.string();

  Pipe in, output, errors;
  sigset_t all, mask;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &mask);
  const pid_t parent = getpid(), id = fork();
  if (id == 0)
    guard(made, folder.c_str(), child.temporary, parent, mask, in, child.listen ? &output : nullptr, errors);
  const int error = errno;
  pthread_sigmask(SIG_SETMASK, &mask, nullptr);
  if (id < 0)
    throw OutputError(fmt::format("{}: cannot be started: {}", made.words[0], std::strerror(error)));
  in.close_end(0);
  output.close_end(1);
  errors.close_end(1);
  for (const int end : {in.ends[1], output.ends[0], errors.ends[0]}) fcntl(end, F_SETFL, O_NONBLOCK);
  if (!child.listen) output.close_end(0);

  const Descriptor process(static_cast<int>(syscall(SYS_pidfd_open, id, 0)));  // readable at its end
  ChildEnd end;
  const auto until = Clock::now() + std::chrono::duration<double>(child.seconds);
  auto rest = child.input;
  bool interrupted = false;
  for (int status = 0;;) {
    // poll() ignores negative descriptors.
    std::array<pollfd, 4> waits{{{in.ends[1], POLLOUT, 0},
                                 {errors.ends[0], POLLIN, 0},
                                 {output.ends[0], POLLIN, 0},
                                 {process.number(), POLLIN, 0}}};
    poll(waits.data(), waits.size(), pause);
    if (waits[0].revents) {
      const auto gone = rest.empty() ? 0 : write_quietly(in.ends[1], rest);
      if (gone > 0) rest.remove_prefix(static_cast<std::size_t>(gone));
      if (rest.empty() || (gone < 0 && errno != EAGAIN && errno != EINTR)) in.close_end(1);
    }
    if (waits[1].revents) take(errors, end.errors, most_errors);
    if (waits[2].revents) take(output, end.output, most_output);
    if (!interrupted && !end.late) {
      interrupted = child.stop();
      end.late = !interrupted && Clock::now() > until;
      if (interrupted || end.late) kill(id, SIGTERM);
    }
    // Do not wait for the end of its standard error: a process that left its group may keep that open.
    const pid_t ended = waitpid(id, &status, WNOHANG);
    if (ended == 0 || (ended < 0 && errno == EINTR)) continue;
    end.status = ended < 0 ? 127 : WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
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
