// Interface of observers that need few of the steps, such as those of rows of a table. Where all
// observers of a run have it, the steps that none of them needs can be made without showing them
// (formulations/single_lane.hpp).
#pragma once

namespace freeplay {

/// Second base of such observers.
class Occasional {
 public:
  /// Time (s) up to which steps change nothing for it, except the last one before it. Asked after
  /// begin(), and after each step that it has seen. Infinite: it needs no further steps.
  virtual double next() const = 0;

 protected:
  ~Occasional() = default;
};

}  // namespace freeplay
