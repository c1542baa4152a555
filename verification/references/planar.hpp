// Vectors of the plane for the references of forces: a × b is the number a_x b_y − a_y b_x, and
// ẑ × a is a turned by +90° (counter-clockwise).
#pragma once

#include <cmath>

namespace freeplay::reference {

template <class Real>
struct Planar {
  Real x = 0, y = 0;
  friend Planar operator+(const Planar& a, const Planar& b) { return {a.x + b.x, a.y + b.y}; }
  friend Planar operator-(const Planar& a, const Planar& b) { return {a.x - b.x, a.y - b.y}; }
  friend Planar operator-(const Planar& a) { return {-a.x, -a.y}; }
  friend Planar operator*(Real s, const Planar& a) { return {s * a.x, s * a.y}; }
};

template <class Real>
Real dot(const Planar<Real>& a, const Planar<Real>& b) {
  return a.x * b.x + a.y * b.y;
}
template <class Real>
Real cross(const Planar<Real>& a, const Planar<Real>& b) {
  return a.x * b.y - a.y * b.x;
}
/// ẑ × a.
template <class Real>
Planar<Real> quarter_turn(const Planar<Real>& a) {
  return {-a.y, a.x};
}
template <class Real>
Planar<Real> direction(Real angle) {
  using std::cos, std::sin;
  return {cos(angle), sin(angle)};
}

/// Load of a joint on a body: a force and the moment about the reference point of the joint.
template <class Real>
struct JointLoad {
  Planar<Real> force;  ///< N
  Real moment = 0;     ///< N m
};

}  // namespace freeplay::reference
