// Torque of a drive, through a low-pass.
#pragma once

#include "dynamics/instrument_parts.hpp"

namespace freeplay {

template <>
struct Sensor<Instrument::Kind::torque> {
  static constexpr std::string_view type = "torque", what = "a torque sensor", meaning = "N m, of a drive";
  static constexpr auto senses = Sensing::force;

  static void keys(auto& k, auto& i) {
    k.drive({"drive", "", "the drive whose torque it shows"}, i.drive);
    low_pass_keys(k, i);
    sample_keys(k, i);
    full_scale_keys(k, i);
    check_sampling(k, i);
  }
  static bool watches(const Instrument& i, const ForceElement& element) {
    return element.kind == ForceElement::Kind::drive && element.name == i.drive;
  }
  static double measure(const Instrument&, const ElementForce& f) { return f.m; }
};

}  // namespace freeplay
