// Stops a run that Python started: by Ctrl-C, from another thread, or from an observer.
#pragma once

#include <atomic>
#include <csignal>
#include <memory>

#include "values/stop.hpp"

namespace freeplay::python {

/// A stop flag owned by Python. Any thread may set it.
struct StopFlag {
  std::atomic<bool> requested{false};
  StopToken token() const { return StopToken(requested); }
};

/// During its lifetime SIGINT sets a flag and the run ends after its current step, without
/// involving the interpreter. Only the main thread may create one. The destructor restores Python's
/// handler.
class CtrlC {
 public:
  /// `here`: whether this is the main thread; otherwise the object has no effect.
  CtrlC(StopFlag& flag, bool here);
  ~CtrlC();
  CtrlC(const CtrlC&) = delete;
  CtrlC& operator=(const CtrlC&) = delete;
  bool pressed() const;

 private:
  bool here_;
  struct sigaction before_ {};
  StopFlag* outer_ = nullptr;
  bool pressed_before_ = false;
};

/// Marks work as under way during its lifetime. A child process that is forked meanwhile must not
/// use the library, because its copies of locks and threads are inconsistent.
class UnderWay {
 public:
  /// `threads`: the work starts threads that outlive it.
  explicit UnderWay(bool threads = false);
  ~UnderWay();
  UnderWay(const UnderWay&) = delete;
  UnderWay& operator=(const UnderWay&) = delete;
};

/// Throws std::runtime_error in a child that was forked during a run or after threads
/// were made.
void refuse_forked();

}  // namespace freeplay::python
