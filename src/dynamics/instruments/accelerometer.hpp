// Acceleration of a body's centre of mass along an axis of the world, through a low-pass.
#pragma once

#include "dynamics/instrument_parts.hpp"
#include "dynamics/planar.hpp"

namespace freeplay {

template <>
struct Sensor<Instrument::Kind::accelerometer> {
  static constexpr std::string_view type = "accelerometer", what = "an accelerometer", meaning = "m/s²";
  static constexpr auto senses = Sensing::velocity;

  static void keys(auto& k, auto& i) {
    k.body({"body", "", "body of the instrument"}, i.body);
    k.axis("direction of measurement in the world", i.axis);
    low_pass_keys(k, i);
    sample_keys(k, i);
    full_scale_keys(k, i);
    check_sampling(k, i);
  }
  /// Velocity along the axis (m/s).
  static double measure(const Instrument& i, const double* v) {
    return dot(i.axis, planar::velocity(v, i.body));
  }
};

}  // namespace freeplay
