#include "stop.hpp"

#include <pthread.h>

#include <cerrno>
#include <stdexcept>

namespace freeplay::python {
namespace {

// A signal handler reads and writes these variables, so they are lock-free atomics.
std::atomic<StopFlag*> present{nullptr};
std::atomic<bool> pressed_now{false};
static_assert(std::atomic<StopFlag*>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

void on_interrupt(int) {
  pressed_now = true;
  if (auto* flag = present.load()) flag->requested = true;
}

std::atomic<int> under_way{0};
std::atomic<bool> has_threads{false}, slip_forced{false};

void in_child() {
  if (under_way > 0 || has_threads) slip_forced = true;
  under_way = 0;
}

}  // namespace

CtrlC::CtrlC(StopFlag& flag, bool here) : here_(here) {
  if (!here_) return;
  outer_ = present.exchange(&flag);
  pressed_before_ = pressed_now.exchange(false);
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, &before_);
}

CtrlC::~CtrlC() {
  if (!here_) return;
  sigaction(SIGINT, &before_, nullptr);
  present = outer_;
  pressed_now = pressed_before_;
}

bool CtrlC::pressed() const { return here_ && pressed_now; }

UnderWay::UnderWay(bool threads) {
  static const int once = pthread_atfork(nullptr, nullptr, in_child);
  if (once != 0) throw std::runtime_error("no memory to watch for forks");
  refuse_forked();
  ++under_way;
  if (threads) has_threads = true;
}

UnderWay::~UnderWay() { --under_way; }

void refuse_forked() {
  if (slip_forced)
    throw std::runtime_error(
        "this process was forked from one that had runs or threads of freeplay under way: their locks are "
        "copied as they "
        "stood and would never open; start processes by spawn, for example "
        "multiprocessing.get_context(\"spawn\")");
}

}  // namespace freeplay::python
