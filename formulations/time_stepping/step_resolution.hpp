// Whether fixed steps are short enough for what lies on their way: a pin that a body moves past within one, a curve that bends
// within one. Adaptive steps have limits for both (integrators/curve_limit.hpp, crossing.hpp).
#pragma once

#include <vector>

#include "dynamics/system.hpp"

namespace freeplay {

class ContactSet;
struct StepData;

class StepResolution {
 public:
  /// The greatest share of what a contact could pass through that it moved in one step, and which it was.
  struct Passage {
    double share = 0;
    int contact = -1;
    template <class M>
    void remember(M& m) {
      m(share, contact);
    }
  };
  /// By how much of its greatest value a curve departed from a straight line within one step at most, over what it may, and
  /// which it was.
  struct Bend {
    double share = 0, over = 0;
    int reader = -1;
    template <class M>
    void remember(M& m) {
      m(share, over, reader);
    }
  };

  explicit StepResolution(const System& system);
  void judge(const StepData& step, const ContactSet& contacts) {
    if (passes_) judge_passage(step, contacts);
    if (!greatest_.empty()) judge_bend(step);
  }

  Passage passage;
  Bend bend;

 private:
  void judge_passage(const StepData& step, const ContactSet& contacts);
  void judge_bend(const StepData& step);

  std::vector<double> greatest_;  // |y| of each curve that is read
  std::vector<int> passing_;      // contacts that something may pass through
  bool passes_;                   // there are some, or pairs among many bodies
};

}  // namespace freeplay
