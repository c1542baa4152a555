// Angle of a joint in whole counts.
#pragma once

#include <numbers>

#include "dynamics/instrument_parts.hpp"
#include "dynamics/kinematics.hpp"

namespace freeplay {

template <>
struct Sensor<Instrument::Kind::encoder> {
  static constexpr std::string_view type = "encoder", what = "an encoder", meaning = "rad, angle of a joint";
  static constexpr auto senses = Sensing::position;

  static double from_counts(double counts) { return 2 * std::numbers::pi / counts; }

  static void keys(auto& k, auto& i) {
    k.any_joint({"joint", "", "the joint whose angle it shows"}, i.joint, i.pair);
    sample_keys(k, i);
    k.either({"counts", "", "counts per revolution: a resolution of 2π/counts; or resolution"}, one_or_more,
             from_counts, {"resolution", "of the channel", "step of the samples, rounded down"}, positive,
             i.resolution);
  }
  static double measure(const Instrument& i, const double* q) {
    return theta(q, i.pair[1]) - theta(q, i.pair[0]);
  }
};

}  // namespace freeplay
