// A fixed relative angle, or one with a prescribed speed. One row, γ = 0:
//
//     Φ = θ_j − θ_i − angle,     Φ = θ_j − θ_i − angle − speed·t,   Φ_t = −speed
#pragma once

#include "dynamics/kinematics.hpp"

namespace freeplay {

struct AngleRow {
  Link link;
  int row = 0;
  double angle = 0;  ///< rad

  template <class T>
  void place(const T&, const T* q, EvaluationOf<T>& e) const {
    e.phi[row] = theta(q, link.j) - theta(q, link.i) - angle;
  }
};

struct SpeedRow {
  Link link;
  int row = 0;
  double angle = 0;  ///< rad, at t = 0
  double speed = 0;  ///< rad/s

  template <class T>
  void place(const T& t, const T* q, EvaluationOf<T>& e) const {
    e.phi[row] = theta(q, link.j) - theta(q, link.i) - angle - speed * t;
  }
};

}  // namespace freeplay
