// Dynamics of mechanism/elements/torque_load.hpp, which states the equations.
#pragma once

#include "dynamics/argument.hpp"
#include "dynamics/elements/dynamics.hpp"
#include "dynamics/phase.hpp"
#include "mechanism/elements/torque_load.hpp"
#include "mechanism/piecewise.hpp"

namespace freeplay {

template <>
struct Dynamics<TorqueLoad> : CurveDynamics<TorqueLoad> {
  auto link(auto& b) const { return b.free_link({ground, body}, {}); }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    T M = torque;
    if (reads()) M *= read_turning<T>(m, link);
    out.couple(link, M);
    out.power.load += M * m.spin(link);
  }
};

}  // namespace freeplay
