// The threads of a study, which may be more than the machine has cores: oneTBB limits them to these, with a
// warning, unless it is told.
#pragma once

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <optional>

namespace freeplay {

class Threads {
 public:
  /// `wanted`: their number; 0: all cores.
  explicit Threads(int wanted) : arena_(wanted > 0 ? wanted : oneapi::tbb::task_arena::automatic) {
    using Control = oneapi::tbb::global_control;
    const auto limit = Control::active_value(Control::max_allowed_parallelism);
    if (wanted > 0 && static_cast<std::size_t>(wanted) > limit)
      more_.emplace(Control::max_allowed_parallelism, static_cast<std::size_t>(wanted));
  }
  int count() { return arena_.max_concurrency(); }
  void execute(const auto& work) { arena_.execute(work); }

 private:
  std::optional<oneapi::tbb::global_control> more_;
  oneapi::tbb::task_arena arena_;  // takes its threads at its first use
};

}  // namespace freeplay
