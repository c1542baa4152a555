// How a run that Python has called is stopped: by Ctrl-C, by another thread, by an observer.
#pragma once

#include <atomic>
#include <csignal>
#include <memory>

#include "values/stop.hpp"

namespace freeplay::python {

/// A flag that Python holds and any thread may set.
struct StopFlag {
  std::atomic<bool> asked{false};
  StopToken token() const { return StopToken(asked); }
};

/// While it lives, SIGINT sets a flag: the run ends after its present step, wherever it is, without the interpreter having
/// to be asked. Only the main thread may make one; Python's own handler is back afterwards.
class CtrlC {
 public:
  /// `here`: whether this thread is the main one; else nothing is done.
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

/// Counts as work under way while it lives: a process that is forked meanwhile cannot go on in the child, whose copy of
/// locks and threads is a torn one.
class UnderWay {
 public:
  /// `threads`: makes threads of its own, which stay.
  explicit UnderWay(bool threads = false);
  ~UnderWay();
  UnderWay(const UnderWay&) = delete;
  UnderWay& operator=(const UnderWay&) = delete;
};

/// Throws std::runtime_error in a child that was forked while work was under way or after threads were made.
void refuse_forked();

}  // namespace freeplay::python
