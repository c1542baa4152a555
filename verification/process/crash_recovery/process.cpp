#include "verification/process/crash_recovery/process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <bit>
#include <chrono>
#include <cstdint>
#include <set>
#include <stdexcept>
#include <thread>

#include "verification/support/support.hpp"

namespace freeplay::killed {
namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

pid_t start(const Words& words, bool traced) {
  return test::start_freeplay(words, traced ? +[] { ptrace(PTRACE_TRACEME, 0, nullptr, nullptr); } : nullptr);
}

End end_of(pid_t id, Clock::time_point began) {
  int status = 0;
  if (waitpid(id, &status, 0) != id) throw std::runtime_error("the process is gone");
  return {WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL, WIFEXITED(status) ? WEXITSTATUS(status) : -1,
          since(began), 0};
}

/// Whether a call changes the names in a folder.
bool changes_names(const __ptrace_syscall_info& call) {
  switch (call.entry.nr) {
#ifdef SYS_rename
    case SYS_rename:
    case SYS_unlink:
    case SYS_mkdir:
    case SYS_rmdir:
#endif
    case SYS_renameat:
    case SYS_renameat2:
    case SYS_unlinkat:
    case SYS_mkdirat:
      return true;
#ifdef SYS_open
    case SYS_open:
      return (call.entry.args[1] & O_CREAT) != 0;
#endif
    case SYS_openat:
      return (call.entry.args[2] & O_CREAT) != 0;
    default:
      return false;
  }
}

}  // namespace

End let_end(const Words& words) {
  const auto began = Clock::now();
  return end_of(start(words, false), began);
}

End kill_after(const Words& words, double seconds) {
  const auto began = Clock::now();
  const pid_t id = start(words, false);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  ::kill(id, SIGKILL);
  return end_of(id, began);
}

End kill_before(const Words& words, int n) {
  const auto began = Clock::now();
  const pid_t id = start(words, true);
  End end;
  int status = 0;
  // It stops once when it executes the program.
  if (waitpid(id, &status, 0) != id || !WIFSTOPPED(status)) throw std::runtime_error("cannot be traced");
  if (ptrace(PTRACE_SETOPTIONS, id, nullptr,
             PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACECLONE | PTRACE_O_EXITKILL) != 0)
    throw std::runtime_error("cannot be traced");
  std::set<pid_t> threads{id};
  ptrace(PTRACE_SYSCALL, id, nullptr, nullptr);
  while (!threads.empty()) {
    const pid_t one = waitpid(-1, &status, __WALL);
    if (one < 0) break;
    if (WIFEXITED(status) || WIFSIGNALED(status)) {
      threads.erase(one);
      if (one == id) {
        end.killed = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
        end.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
      }
      continue;
    }
    threads.insert(one);
    int pass = 0;
    const int signal = WSTOPSIG(status);
    if (signal == (SIGTRAP | 0x80)) {
      __ptrace_syscall_info call{};
      ptrace(PTRACE_GET_SYSCALL_INFO, one, std::bit_cast<void*>(std::uintptr_t{sizeof call}), &call);
      if (call.op == PTRACE_SYSCALL_INFO_ENTRY && changes_names(call) && ++end.changes == n)
        ::kill(id, SIGKILL);
    } else if (signal != SIGTRAP && signal != SIGSTOP) {
      pass = signal;
    }
    ptrace(PTRACE_SYSCALL, one, nullptr, std::bit_cast<void*>(static_cast<std::intptr_t>(pass)));
  }
  end.seconds = since(began);
  return end;
}

}  // namespace freeplay::killed
