// Structure of a kind of instrument, and keys common to several kinds. A kind is one enumerator of
// Instrument::Kind and one file of instruments/, which specialises Sensor for it with
//
//     type, what, meaning      its word in a scene, its name in messages, its quantity
//     senses                   the quantity it measures (Sensing)
//     keys(k, i)               its keys (see keys.hpp)
//     measure(i, x)            its value from positions, velocities, or the force of an element
//     watches(i, element)      forces only: whether the element contributes to the sum
#pragma once

#include "mechanism/instrument.hpp"

namespace freeplay {

template <Instrument::Kind kind>
struct Sensor;

/// Keys of sampling and noise.
void sample_keys(auto& k, auto& i) {
  k.need({"sampling", "Hz", "samples per second in signals.csv"}, i.sampling, positive);
  k.take({"noise", "of the channel", "standard deviation of a sample's noise"}, i.noise, non_negative);
  if (k.when(i.noise.has_value()))
    k.take({"seed", "",
            "seed of the noise, a whole number; each channel, start and run derives a "
            "different one"},
           i.seed, whole);
}

void full_scale_keys(auto& k, auto& i) {
  k.take({"range", "of the channel",
          "full scale: samples are limited to ± this value, or to the last resolution step within it"},
         i.range, positive);
  k.take({"resolution", "of the channel", "step of the samples, rounded down"}, i.resolution, positive);
}

/// Keys of the Butterworth low-pass before sampling.
void low_pass_keys(auto& k, auto& i) {
  k.need({"bandwidth", "Hz", "−3 dB frequency of its Butterworth low-pass"}, i.bandwidth, positive);
  k.take({"order", "", "order of the low-pass, 1 to 8"}, i.order, one_to_eight);
}
void check_sampling(auto& k, auto& i) {
  k.check(i.sampling > 2 * i.bandwidth, "sampling", "must exceed twice the bandwidth ", i.bandwidth,
          " Hz, is ", i.sampling, " Hz");
}

}  // namespace freeplay
