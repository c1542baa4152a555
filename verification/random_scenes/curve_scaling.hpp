// What the transformations of scenes share: visitors, and curves multiplied by factors.
#pragma once

#include <stdexcept>

#include "mechanism/scene.hpp"

namespace freeplay::verification::random_scenes {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

/// The curve with x and y multiplied by these, as an additional curve of the mechanism; returns its
/// index.
inline int scaled_curve(Mechanism& m, int curve, double x, double y) {
  auto c = m.curves[static_cast<std::size_t>(curve)];
  c.name += "_";
  for (auto* value : {&c.value, &c.from, &c.to, &c.mean, &c.amplitude}) *value *= y;
  for (auto* length : {&c.start, &c.rise, &c.dwell, &c.fall, &c.rest, &c.period}) *length *= x;
  for (auto& [at, value] : c.points) at *= x, value *= y;
  m.curves.push_back(c);
  return static_cast<int>(m.curves.size()) - 1;
}
inline void scale(Mechanism& m, CurveOr& value, double x, double y) {
  value.constant *= y;
  if (value.curve >= 0) value.curve = scaled_curve(m, value.curve, x, y);
}
/// Requires that a drive's or load's curve is over time.
inline void need_time(Argument against) {
  if (against != Argument::time)
    throw std::logic_error("curves against angles and speeds are not transformed");
}

}  // namespace freeplay::verification::random_scenes
