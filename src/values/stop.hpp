// Request to stop a run: a flag that the caller owns and may set from another thread or a signal
// handler.
#pragma once

#include <atomic>
#include <stdexcept>

namespace freeplay {

/// A request to stop a run, which another thread may make.
class StopToken {
 public:
  StopToken() = default;  ///< never requests a stop
  /// Refers to the caller's flag, which must exist as long as the token.
  explicit StopToken(const std::atomic<bool>& requested) : requested_(&requested) {}
  /// Refers to the caller's flag, which must exist as long as the token.
  explicit StopToken(const std::atomic<bool>&&) = delete;  // the flag would not outlive the token
  /// `heard` is set once the token has reported the request; the code that polls it then ends in
  /// order.
  StopToken(const std::atomic<bool>& requested, std::atomic<bool>& heard)
      : requested_(&requested), heard_(&heard) {}
  /// Whether a stop is requested.
  bool operator()() const {
    if (!requested_ || !requested_->load(std::memory_order_relaxed)) return false;
    if (heard_) heard_->store(true, std::memory_order_relaxed);
    return true;
  }

 private:
  const std::atomic<bool>* requested_ = nullptr;
  std::atomic<bool>* heard_ = nullptr;
};

/// Thrown by an operation that was stopped before it had a result: an assembly, a child process.
struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted") {}
};

}  // namespace freeplay
