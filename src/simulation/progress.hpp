// Whether a run gets on. Steps of a stiff or singular motion may shrink until the end is out of reach although each of
// them is accepted. With N = Progress::window steps a window, L the run's length and at most 100 s, a window crawls where
//
//     Δt < share · N · L,        share = 1e-10,
//
// which is a pace of more than 1e10 steps for L: hours at a microsecond a step. A run stops after three such windows, one
// behind the other. Impacts that accumulate, and contacts that come and go, are passed in fewer steps than that. L ends
// at 100 s, for a long run of ordinary steps is long and does not crawl.
#pragma once

#include <algorithm>

namespace freeplay {

class Progress {
 public:
  static constexpr long window = 1'000'000;
  static constexpr int most_windows = 3;
  static constexpr double share = 1e-10, longest = 100;  // 1, s

  /// Of a run from t to t_end (s).
  Progress(double t, double t_end) : begin_(t), left_(t_end - t), length_(std::min(left_, longest)) {}

  /// Of each step, with the time t (s) that it has come to: whether the run is to stop.
  bool crawls(double t) {
    if (++steps_ < window) return false;
    const double advance = t - begin_;
    windows_ = advance < share * static_cast<double>(window) * length_ ? windows_ + 1 : 0;
    pace_ = advance / static_cast<double>(window);
    steps_ = 0;
    begin_ = t;
    return windows_ == most_windows;
  }
  double pace() const { return pace_; }                              ///< s a step, of the last window
  double needed() const { return left_ / std::max(pace_, 1e-300); }  ///< steps of a run at that pace

 private:
  double begin_, left_, length_;  // s
  double pace_ = 0;
  long steps_ = 0;
  int windows_ = 0;
};

}  // namespace freeplay
