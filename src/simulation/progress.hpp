// Detects runs that do not progress. Steps of a stiff or singular motion may become so small that
// the end is out of reach, although each step is accepted. With windows of N = Progress::window
// steps and L the length of the run, at most 100 s, a window is too slow if
//
//     Δt < share · N · L,        share = 1e-10,
//
// that is, if more than 1e10 steps are needed for L: hours at a microsecond a step. A run stops
// after three such windows in succession. Accumulating impacts and repeated contacts need fewer
// steps than that. L is limited to 100 s so that a long run of ordinary steps is not stopped.
#pragma once

#include <algorithm>

namespace freeplay {

class Progress {
 public:
  static constexpr long window = 1'000'000;
  static constexpr int most_windows = 3;
  static constexpr double share = 1e-10, longest = 100;  // 1, s

  /// Begins to observe a run from t to t_end (s).
  Progress(double t, double t_end) : begin_(t), left_(t_end - t), length_(std::min(left_, longest)) {}

  /// Call it after each step with the time t (s) reached; returns whether the run must stop.
  bool crawls(double t) {
    if (++steps_ < window) return false;
    const double advance = t - begin_;
    windows_ = advance < share * static_cast<double>(window) * length_ ? windows_ + 1 : 0;
    pace_ = advance / static_cast<double>(window);
    steps_ = 0;
    begin_ = t;
    return windows_ == most_windows;
  }
  double pace() const { return pace_; }  ///< s a step, in the last window
  /// Steps for the whole run at that pace.
  double needed() const { return left_ / std::max(pace_, 1e-300); }

 private:
  double begin_, left_, length_;  // s
  double pace_ = 0;
  long steps_ = 0;
  int windows_ = 0;
};

}  // namespace freeplay
