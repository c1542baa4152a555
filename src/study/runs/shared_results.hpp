// Intermediate results that the runs of a study share: of ideal mechanisms and of measured files. Each is
// computed once; other threads wait for it.
#pragma once

#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "measure/waveform.hpp"

namespace freeplay {

/// Results by their keys. Safe for concurrent use.
template <class Key, class Value>
class ComputedOnce {
 public:
  /// The result for this key: computes it, waits for the thread that does, or returns it. Throws the error of
  /// the computation.
  template <class F>
  Value operator()(const Key& key, F&& compute) {
    std::promise<Value> made;
    std::shared_future<Value> found;
    bool mine = false;
    {
      const std::lock_guard lock(mutex_);
      auto& entry = found_[key];
      mine = !entry.valid();
      if (mine) entry = made.get_future().share();
      found = entry;
    }
    if (mine) try {
        made.set_value(compute());
      } catch (...) {
        made.set_exception(std::current_exception());
      }
    return found.get();
  }

 private:
  std::mutex mutex_;
  std::map<Key, std::shared_future<Value>> found_;
};

/// Keys are digests of identities, and of a file with the speed of its crank (rad/s).
struct SharedResults {
  ComputedOnce<std::string, double> ideal_maxima;        ///< study/runs/ideal_turn.hpp
  ComputedOnce<std::string, std::vector<double>> poses;  ///< study/runs/near_pose.hpp
  ComputedOnce<std::pair<std::string, double>, std::shared_ptr<const MeasuredTurns>> files;
};

}  // namespace freeplay
