// StepResolution: checks whether fixed steps are short enough for the geometry and the curves of a
// scene: whether a body can move past a contact, such as a pin, within one step, and whether a
// curve bends within one step. Adaptive steps have limits for both (integrators/curve_limit.hpp,
// crossing.hpp).
#pragma once

#include <vector>

#include "dynamics/system.hpp"

namespace freeplay {

class ContactSet;
struct StepData;

class StepResolution {
 public:
  /// The greatest motion in one step relative to the width that a contact could pass through, and
  /// the contact.
  struct Passage {
    double share = 0;
    int contact = -1;
    template <class M>
    void serialize(M& m) {
      m(share, contact);
    }
  };
  /// The greatest deviation of a curve from a straight line within one step, relative to the
  /// curve's greatest value (share) and to the accepted deviation (over), and the element that
  /// reads it.
  struct Bend {
    double share = 0, over = 0;
    int reader = -1;
    template <class M>
    void serialize(M& m) {
      m(share, over, reader);
    }
  };

  explicit StepResolution(const System& system);
  void assess(const StepData& step, const ContactSet& contacts) {
    if (passes_) assess_passage(step, contacts);
    if (!greatest_.empty()) assess_bend(step);
  }

  /// Whether there is nothing to assess.
  bool idle() const { return !passes_ && greatest_.empty(); }

  Passage passage;
  Bend bend;

 private:
  void assess_passage(const StepData& step, const ContactSet& contacts);
  void assess_bend(const StepData& step);

  std::vector<double> greatest_;  // greatest |y| of each curve
  std::vector<int> passing_;      // contacts that a body may pass through
  bool passes_;                   // there are such contacts, or pairs among many bodies
};

}  // namespace freeplay
