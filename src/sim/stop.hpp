// How a run is asked to stop: a flag that the caller owns and may set from another thread or a signal handler.
#pragma once

#include <atomic>

namespace freeplay {

class StopToken {
 public:
  StopToken() = default;  ///< never asks
  explicit StopToken(const std::atomic<bool>& requested) : requested_(&requested) {}
  explicit StopToken(const std::atomic<bool>&&) = delete;  // a flag that would be gone
  bool operator()() const { return requested_ && requested_->load(std::memory_order_relaxed); }

 private:
  const std::atomic<bool>* requested_ = nullptr;
};

}  // namespace freeplay
