#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <stdexcept>

#include "io/run_folder.hpp"
#include "io/run_json.hpp"
#include "model/error.hpp"
#include "verification/extremes/extremes.hpp"
#include "verification/support.hpp"

namespace freeplay::verification {

const char* name_of(Outcome outcome) {
  constexpr const char* names[] = {"right", "degraded", "refused", "WRONG", "HUNG", "CRASHED"};
  return names[static_cast<int>(outcome)];
}

Judged beyond_bound(const Result& run, const std::string& what) {
  const bool failed = run.ending.status != Ending::Status::finished;
  for (const auto& note : run.notes)
    if (note.starts_with("DOUBTFUL"))
      return failed ? Judged{Outcome::refused, run.ending.reason + "; said: " + note}
                    : Judged{Outcome::degraded, what + "; said: " + note};
  return {Outcome::wrong, failed ? what + "; then stopped: " + run.ending.reason : what};
}

Judged within(const Result& run, double error, double bound, const std::string& what) {
  if (!(error <= bound))
    return beyond_bound(run, fmt::format("{}: {:.2g}, above {:.2g}", what, error, bound));
  if (run.ending.status != Ending::Status::finished) return {Outcome::refused, run.ending.reason};
  return {Outcome::right, fmt::format("{}: {:.2g}", what, error)};
}

Judged judge_apart(const Cell& cell, double seconds) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("extremes: no pipe");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("extremes: no process");
  if (child == 0) {
    close(ends[0]);
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // what it inherits, a folder's lock too, ends with the program
    // A crash here is the parent's to report: no handler inherited from a test runner speaks for it.
    for (const int s : {SIGABRT, SIGSEGV, SIGFPE, SIGILL, SIGBUS, SIGTERM}) std::signal(s, SIG_DFL);
    Judged j;
    try {
      j = cell.judge();
    } catch (const SceneError& e) {
      j = {Outcome::refused, e.what()};
      const std::string here = test::source_folder().string() + "/";  // a page is of no machine
      if (j.detail.starts_with(here)) j.detail.erase(0, here.size());
    } catch (const std::exception& e) {
      j = {Outcome::crashed, e.what()};
    }
    const std::string text = static_cast<char>('0' + static_cast<int>(j.outcome)) + j.detail;
    (void)!::write(ends[1], text.data(), text.size());
    _exit(0);
  }
  close(ends[1]);
  std::string text;
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  bool late = false;
  for (;;) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
    pollfd wait{ends[0], POLLIN, 0};
    const int ready = poll(&wait, 1, static_cast<int>(std::max<long>(left.count(), 0)));
    if (ready == 0) {
      late = true;
      kill(child, SIGKILL);
      break;
    }
    char buffer[4096];
    const auto n = read(ends[0], buffer, sizeof buffer);
    if (n <= 0) break;
    text.append(buffer, static_cast<std::size_t>(n));
  }
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (late) return {Outcome::hung, "no end within its time"};
  if (!WIFEXITED(status) || text.empty())
    return {Outcome::crashed, "signal " + std::to_string(WTERMSIG(status))};
  return {static_cast<Outcome>(text[0] - '0'), text.substr(1)};
}

}  // namespace freeplay::verification
