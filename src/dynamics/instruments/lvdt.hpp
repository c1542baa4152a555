// Displacement of a body's centre of mass along an axis of the world.
#pragma once

#include "dynamics/instrument_parts.hpp"
#include "dynamics/planar.hpp"

namespace freeplay {

template <>
struct Sensor<Instrument::Kind::lvdt> {
  static constexpr std::string_view type = "lvdt", what = "an LVDT", meaning = "m, position of a body";
  static constexpr auto senses = Sensing::position;

  static void keys(auto& k, auto& i) {
    k.body({"body", "", "body of the instrument"}, i.body);
    k.axis("direction of measurement in the world", i.axis);
    sample_keys(k, i);
    full_scale_keys(k, i);
  }
  static double measure(const Instrument& i, const double* q) {
    return dot(i.axis, planar::position(q, i.body));
  }
};

}  // namespace freeplay
