// All kinds of instrument. The build lists the files of instruments/. An enumerator without a file,
// or a file without an enumerator, is a compile error.
#pragma once

#include "dynamics/instrument_parts.hpp"
#include "generated/instruments.hpp"

namespace freeplay {

inline constexpr auto instrument_names =
    each_enumerator<Instrument::Kind, std::array<Choice<Instrument::Kind>,
                                                 static_cast<std::size_t>(enumerators<Instrument::Kind>())>>(
        [](auto kind) {
          return Choice<Instrument::Kind>{kind(), Sensor<kind()>::type, Sensor<kind()>::meaning};
        });
constexpr std::span<const Choice<Instrument::Kind>> choices(Instrument::Kind) { return instrument_names; }

/// Calls f with the Sensor of a kind.
template <class F>
void with_kind(Instrument::Kind kind, F&& f) {
  each_enumerator<Instrument::Kind, std::array<bool, instrument_names.size()>>([&](auto k) {
    if (k() == kind) f(Sensor<k()>{});
    return k() == kind;
  });
}

inline Sensing sensing_of(Instrument::Kind kind) {
  Sensing senses{};
  with_kind(kind, [&](auto sensor) { senses = sensor.senses; });
  return senses;
}

}  // namespace freeplay
