// How a run is asked to stop: a flag that the caller owns and may set from another thread or a signal handler.
#pragma once

#include <atomic>
#include <stdexcept>

namespace freeplay {

class StopToken {
 public:
  StopToken() = default;  ///< never asks
  explicit StopToken(const std::atomic<bool>& requested) : requested_(&requested) {}
  explicit StopToken(const std::atomic<bool>&&) = delete;  // a flag that would be gone
  /// `heard` is set when somebody was told to stop, who will then end in order.
  StopToken(const std::atomic<bool>& requested, std::atomic<bool>& heard)
      : requested_(&requested), heard_(&heard) {}
  bool operator()() const {
    if (!requested_ || !requested_->load(std::memory_order_relaxed)) return false;
    if (heard_) heard_->store(true, std::memory_order_relaxed);
    return true;
  }

 private:
  const std::atomic<bool>* requested_ = nullptr;
  std::atomic<bool>* heard_ = nullptr;
};

/// What was asked to stop before it had anything to give: an assembly, a child process.
struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted") {}
};

}  // namespace freeplay
