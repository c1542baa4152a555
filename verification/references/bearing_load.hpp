// The load that a joint with the ground, or with a rotating carrier, exerts on one body whose
// motion is given.
//
// Rotor: revolute joint with the ground at O, centre of mass at the distance a in the direction e_r
// of θ:
//
//     C = a e_r,     C̈ = a (α e_θ − ω² e_r)
//     F = m (C̈ − g)                             at constant speed m (−a ω² e_r − g)
//     τ = (J + m a²) α − C × m g                at constant speed, g = (0, −g): m g a cos θ
//
// Welded body: its carrier turns about O; joint at Q, centre of mass at Q + d, both fixed in the
// carrier:
//
//     C = Q + d,     C̈ = α ẑ × C − ω² C
//     F = m (C̈ − g),     M_Q = d × m (C̈ − g) + J α
//
// Slider: translational joint along t = (cos β, sin β), n = ẑ × t. The body does not turn and its
// reference point Q has the acceleration s̈ t; centre of mass at Q + c, a constant force P at
// Q + p, a drive D t at Q:
//
//     along the axis     D = m (s̈ − g·t) − P·t
//                        sliding freely, D = 0:  s̈ = g·t + P·t/m
//     across             N = −n·(m g + P)
//     moments about Q    M_Q = c × m (s̈ t − g) − p × P
//
// Sign convention: world axes; angles, rates and moments counter-clockwise; every force, moment and
// torque is that on the body named (rotor, welded body, slider), by the joint or the drive. Moments
// are about the joint's point on that body (O or Q). e_r, Q and d are given in the carrier's frame,
// which is the world's at θ = 0; c and p in the world's. g is the acceleration of gravity, (0, −9.81)
// where it points down. No friction. Units: m, kg, s, rad, N.
// Source: the momentum theorems of a rigid body; any text of dynamics.
#pragma once

#include "verification/references/planar.hpp"

namespace freeplay::reference {

/// Position of a body that turns about a fixed axis.
template <class Real>
struct Turning {
  Real angle = 0;         ///< θ, rad
  Real speed = 0;         ///< ω, rad/s
  Real acceleration = 0;  ///< α, rad/s²
};

template <class Real>
struct Rotor {
  Real mass = 0;          ///< m, kg
  Real eccentricity = 0;  ///< a, m, of the centre of mass; 0: balanced
  Real inertia = 0;       ///< J, kg m², about the centre of mass; without effect at constant speed
};

template <class Real>
struct RotorLoad {
  Planar<Real> reaction;  ///< F, N, of the ground on the rotor at O
  Real torque = 0;        ///< τ, N m, of the drive on the rotor
};

template <class Real>
RotorLoad<Real> rotor_load(const Rotor<Real>& rotor, const Turning<Real>& at, const Planar<Real>& gravity) {
  const Real m = rotor.mass, a = rotor.eccentricity;
  const Planar<Real> e_r = direction(at.angle), e_theta = quarter_turn(e_r);
  return {m * (a * (at.acceleration * e_theta - at.speed * at.speed * e_r) - gravity),
          (rotor.inertia + m * a * a) * at.acceleration - m * a * cross(e_r, gravity)};
}

template <class Real>
struct WeldedBody {
  Real mass = 0;          ///< m, kg
  Real inertia = 0;       ///< J, kg m², about the centre of mass
  Planar<Real> joint{};   ///< Q, m, from the axis, in the carrier's frame
  Planar<Real> centre{};  ///< d, m, from the joint to the centre of mass, in the carrier's frame
};

/// Force and moment about the joint's point that the weld exerts on the body.
template <class Real>
JointLoad<Real> weld_load(const WeldedBody<Real>& body, const Turning<Real>& at,
                          const Planar<Real>& gravity) {
  const Planar<Real> e = direction(at.angle);
  const auto turned = [&](const Planar<Real>& v) { return v.x * e + v.y * quarter_turn(e); };
  const Planar<Real> c = turned(body.joint + body.centre), d = turned(body.centre);
  const Planar<Real> c2 = at.acceleration * quarter_turn(c) - at.speed * at.speed * c;
  const Planar<Real> force = body.mass * (c2 - gravity);
  return {force, cross(d, force) + body.inertia * at.acceleration};
}

template <class Real>
struct GuidedBody {
  Real mass = 0;           ///< m, kg
  Real axis_angle = 0;     ///< β, rad
  Planar<Real> centre{};   ///< c, m, from the joint's point to the centre of mass, world axes
  Planar<Real> load{};     ///< P, N
  Planar<Real> load_at{};  ///< p, m, from the joint's point to where P acts, world axes
};

template <class Real>
struct GuideLoad {
  JointLoad<Real> joint;  ///< N n and M_Q, on the slider, about its joint's point
  Real drive = 0;         ///< D, N, force along t at the joint's point required for s̈
};

/// s̈ (m/s²) of the freely sliding slider.
template <class Real>
Real guided_acceleration(const GuidedBody<Real>& body, const Planar<Real>& gravity) {
  const Planar<Real> t = direction(body.axis_angle);
  return dot(gravity, t) + dot(body.load, t) / body.mass;
}

/// Loads at the acceleration s̈ (m/s²) along the axis.
template <class Real>
GuideLoad<Real> guide_load(const GuidedBody<Real>& body, Real acceleration, const Planar<Real>& gravity) {
  const Planar<Real> t = direction(body.axis_angle), n = quarter_turn(t);
  const Real m = body.mass;
  GuideLoad<Real> out;
  out.joint.force = -dot(n, m * gravity + body.load) * n;
  out.joint.moment = m * cross(body.centre, acceleration * t - gravity) - cross(body.load_at, body.load);
  out.drive = m * (acceleration - dot(gravity, t)) - dot(body.load, t);
  return out;
}

}  // namespace freeplay::reference
