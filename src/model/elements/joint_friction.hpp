// Coulomb friction of a preloaded translational joint: a force of fixed bound against sliding, set-valued in the
// nonsmooth formulation. It acts along one row, u = a·ḋ (rows/sliding.hpp), which the formulations weigh.
#pragma once

#include <optional>
#include <string>
#include <variant>

#include "model/elements/translational_joint.hpp"
#include "values/forces.hpp"

namespace freeplay {

struct JointFriction {
  static constexpr std::string_view type = "joint-friction", what = "a joint friction";
  static constexpr auto reports = ForceElement::Kind::force;
  std::string name;
  int joint = -1;
  double force = 0;  ///< N, the bound, ≥ 0
  std::optional<double> regularisation =
      {};  ///< m/s: below it the penalty formulation's force is linear in speed

  static void keys(auto& k, auto& l) {
    const auto* on = k.template joint<TranslationalJoint>({"joint", "", "the translational joint"}, l.joint);
    k.need({"force", "N", "the bound of the friction force"}, l.force, non_negative);
    k.take({"regularisation", "m/s",
            "speed below which the penalty formulation's friction is linear; it needs it"},
           l.regularisation, positive);
    k.check(!on || !on->clearance, "joint",
            "must be a joint without clearance; a loose one has friction by its surface");
  }

  auto link(auto& b) const {
    const auto& on = std::get<TranslationalJoint>(b.mechanism().joints[joint]);
    return b.link(on.between, on.at);
  }
  void build(auto& b) const {
    b.sliding(link(b), std::get<TranslationalJoint>(b.mechanism().joints[joint]).axis, name, force,
              regularisation);
  }
};

}  // namespace freeplay
