// The list of all kinds of instrument.
#pragma once

#include <tuple>

#include "model/instruments/accelerometer.hpp"
#include "model/instruments/encoder.hpp"
#include "model/instruments/load_cell.hpp"
#include "model/instruments/lvdt.hpp"
#include "model/instruments/torque_sensor.hpp"

namespace freeplay {

using InstrumentKinds = std::tuple<Accelerometer, Lvdt, Encoder, LoadCell, TorqueSensor>;

inline constexpr auto instrument_names = [] {
  return []<class... K>(std::tuple<K...>*) {
    return complete<Instrument::Kind>({{K::kind, K::type, K::meaning}...});
  }(static_cast<InstrumentKinds*>(nullptr));
}();
constexpr std::span<const Choice<Instrument::Kind>> choices(Instrument::Kind) { return instrument_names; }

/// Calls f with the kind of an instrument: f(Encoder{}).
template <class F>
void with_kind(Instrument::Kind kind, F&& f) {
  [&]<class... K>(std::tuple<K...>*) {
    static_cast<void>(((K::kind == kind ? (f(K{}), true) : false) || ...));
  }(static_cast<InstrumentKinds*>(nullptr));
}

inline Sensing sensing_of(Instrument::Kind kind) {
  Sensing senses{};
  with_kind(kind, [&](auto k) { senses = k.senses; });
  return senses;
}
inline bool measures_force(Instrument::Kind kind) { return sensing_of(kind) == Sensing::force; }

}  // namespace freeplay
