// Strain of a section of a beam at a distance from its neutral axis, through a low-pass:
// ε = N/(EA) − y M/(EI), y to the left of the beam's direction.
#pragma once

#include "dynamics/instrument_parts.hpp"

namespace freeplay {

template <>
struct Sensor<Instrument::Kind::strain_gauge> {
  static constexpr std::string_view type = "strain-gauge", what = "a strain gauge",
                                    meaning = "strain of a beam, positive if it is longer";
  static constexpr auto senses = Sensing::force;

  static void keys(auto& k, auto& i) {
    k.gauge(
        {"beam", "", "the beam whose strain it shows"},
        {"place", "m", "along the beam from its first end; the nearest boundary of pieces, or end, is taken"},
        i);
    k.take({"offset", "m", "from the neutral axis, positive to the left of the beam's direction"}, i.offset);
    low_pass_keys(k, i);
    sample_keys(k, i);
    full_scale_keys(k, i);
    check_sampling(k, i);
  }
  static bool watches(const Instrument& i, const ForceElement& element) {
    return element.kind == ForceElement::Kind::section && element.name == i.element;
  }
  static double measure(const Instrument& i, const ElementForce& f) {
    return f.fn / i.axial - i.offset * f.bending / i.bending;
  }
};

}  // namespace freeplay
