// The forces of the elements at the end of the last step of a run.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "simulation/observer.hpp"

namespace freeplay::test {

class LastForces final : public Observer {
 public:
  Wants wants() const override { return {.forces = true, .steps = true}; }
  void begin(const Layout& layout, const State&) override { elements = layout.forces; }
  void step(const Step& step) override { step.forces(step.t1, now); }
  /// Normal force of an element (N); NaN if there is none of this name.
  double normal(const std::string& name) const {
    for (std::size_t i = 0; i < elements.size(); ++i)
      if (elements[i].name == name) return now.elements.at(i).fn;
    return NAN;
  }
  std::vector<ForceElement> elements;
  Forces now;
};

}  // namespace freeplay::test
