// Dynamics of mechanism/elements/torque_load.hpp, which states the equations.
#pragma once

#include "dynamics/argument.hpp"
#include "dynamics/elements/dynamics.hpp"
#include "dynamics/phase.hpp"
#include "mechanism/elements/torque_load.hpp"
#include "mechanism/piecewise.hpp"

namespace freeplay {

template <>
struct Dynamics<TorqueLoad> : TorqueLoad {
  Piecewise course = {};  ///< set by prepare()
  ReadJoint read{other.of};

  void prepare(const auto& mechanism) {
    if (factor >= 0) course = mechanism.curves[factor].lay();
  }
  auto link(auto& b) const { return b.free_link({ground, body}, {}); }
  bool does_work() const { return true; }
  bool needs_velocity() const { return factor >= 0 && against != Argument::time; }
  double next_knot(double t) const {
    return factor >= 0 && against == Argument::time ? course.next_knot(t) : INFINITY;
  }
  std::optional<Phase> phase(const Link& link) const {
    return factor < 0 ? std::nullopt : phase_of(course, against, read.or_own(link));
  }
  std::optional<CurveReader> reader(const Link& link) const {
    if (factor < 0) return {};
    return reader_of(name, course, against, read.or_own(link));
  }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    T M = torque;
    if (factor >= 0) {
      const Link& at = read.or_own(link);
      M *= read_at<T>(course, against, m, m.angle(at),
                      [&](const T* v) { return omega(v, at.j) - omega(v, at.i); });
    }
    out.couple(link, M);
    out.power.load += M * m.spin(link);
  }
};

}  // namespace freeplay
