#include "cli/ending.hpp"

#include <fmt/format.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <string_view>

#include "cli/terminal.hpp"

namespace freeplay::cli {
namespace {

// Flags of the program; the library has none. Signals call the following functions, which may use
// atomics and system calls only.
std::atomic<bool> requested{false}, heard{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void ring_in(double seconds) {
  const auto whole = static_cast<time_t>(seconds);
  const itimerval timer{{0, 0},
                        {whole, static_cast<suseconds_t>(1e6 * (seconds - static_cast<double>(whole)))}};
  setitimer(ITIMER_REAL, &timer, nullptr);
}

void on_alarm(int) {
  static volatile std::sig_atomic_t waited = 0;
  if (heard && !waited) {
    waited = 1;
    return ring_in(grace);
  }
  constexpr std::string_view line = "interrupted\n";
  [[maybe_unused]] const auto ignored = write(2, line.data(), line.size());
  _exit(1);
}

void on_stop(int signal) {
  const int error = errno;
  if (requested.exchange(true)) {
    std::signal(signal, SIG_DFL);
    raise(signal);  // delivered when this handler returns
  } else {
    ring_in(patience);
  }
  errno = error;
}

void handle(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

}  // namespace

StopToken listen_for_signals() {
  handle(SIGALRM, on_alarm);
  handle(SIGINT, on_stop);
  handle(SIGTERM, on_stop);
  handle(SIGPIPE, SIG_IGN);
  handle(SIGXFSZ, SIG_IGN);
  return {requested, heard};
}

void take_time() {
  const itimerval none{};
  setitimer(ITIMER_REAL, &none, nullptr);
}

void say_undetermined(const Result& result) {
  if (result.undetermined.empty()) return;
  fmt::print("{}", wrapped(fmt::format("note: the reactions of {} are statically indeterminate (dependent "
                                       "constraint rows); forces.csv has the minimum-norm solution\n",
                                       fmt::join(result.undetermined, ", "))));
}

int report(const Result& result) {
  if (result.ending.status == Ending::Status::finished) return 0;
  if (result.ending.status == Ending::Status::failed)
    fmt::print(stderr, "{}: stopped: {}\n", result.formulation, result.ending.reason);
  else
    fmt::print(stderr, "interrupted: {} at t = {:.9g} s\n", result.formulation, result.t_end);
  return 1;
}

int interrupted(Kept kept) {
  fmt::print(stderr, "interrupted; the same command {}\n",
             kept == Kept::runs ? "continues" : "starts again, nothing was written");
  return 1;
}

}  // namespace freeplay::cli
