#include "verification/support/apart.hpp"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>

namespace freeplay::verification {

namespace {

/// Writes the whole text, as far as the other end reads it.
void add_notes(int end, const std::string& text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto n = ::write(end, text.data() + i, text.size() - i);
    if (n <= 0) return;
    i += static_cast<std::size_t>(n);
  }
}

}  // namespace

Apart run_apart(const std::function<std::string()>& work, double seconds) {
  return run_apart([&](const Say& say) { say(work()); }, seconds);
}

Apart run_apart(const std::function<void(const Say&)>& work, double seconds) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe to a process of its own");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process of its own");
  if (child == 0) {
    close(ends[0]);
    // inherited resources, a folder's lock too, end with the program
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    // The parent reports a crash here: handlers inherited from a test runner are removed.
    for (const int s : {SIGABRT, SIGSEGV, SIGFPE, SIGILL, SIGBUS, SIGTERM}) std::signal(s, SIG_DFL);
    try {
      work([&](const std::string& text) { add_notes(ends[1], text); });
    } catch (...) {  // the exception is lost; this copy must not continue beyond here
      _exit(1);
    }
    _exit(0);
  }
  close(ends[1]);
  Apart result;
  for (;;) {
    pollfd wait{ends[0], POLLIN, 0};
    if (poll(&wait, 1, static_cast<int>(1000 * seconds)) == 0) {
      result.late = true;
      kill(child, SIGKILL);
      break;
    }
    char buffer[4096];
    const auto n = read(ends[0], buffer, sizeof buffer);
    if (n <= 0) break;
    result.said.append(buffer, static_cast<std::size_t>(n));
  }
  close(ends[0]);
  int status = 0;
  rusage used{};
  wait4(child, &status, 0, &used);
  if (!result.late && WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  result.megabytes = static_cast<double>(used.ru_maxrss) / 1024;
  return result;
}

}  // namespace freeplay::verification
