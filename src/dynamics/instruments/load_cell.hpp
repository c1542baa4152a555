// Force of a joint on its second body along an axis of the world, through a low-pass. It is the sum
// of the ideal reaction, the contacts and the joint friction. A drive of the joint contributes
// nothing: it exerts a torque only.
#pragma once

#include "dynamics/instrument_parts.hpp"

namespace freeplay {

template <>
struct Sensor<Instrument::Kind::load_cell> {
  static constexpr std::string_view type = "load-cell", what = "a load cell",
                                    meaning = "N, force of a joint on its second body";
  static constexpr auto senses = Sensing::force;

  static void keys(auto& k, auto& i) {
    k.any_joint({"joint", "", "the joint whose force it shows"}, i.joint, i.pair);
    k.axis("direction of measurement in the world", i.axis);
    low_pass_keys(k, i);
    sample_keys(k, i);
    full_scale_keys(k, i);
    check_sampling(k, i);
  }
  static bool watches(const Instrument& i, const ForceElement& element) {
    return element.kind != ForceElement::Kind::drive && element.kind != ForceElement::Kind::push &&
           element.joint == i.joint;
  }
  static double measure(const Instrument& i, const ElementForce& f) {
    return i.axis.x() * f.fx + i.axis.y() * f.fy;
  }
};

}  // namespace freeplay
