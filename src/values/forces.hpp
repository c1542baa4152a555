// Resulting forces: of every ideal joint, contact, drive and load, and the accelerations of every
// body.
//
// An element acts on two bodies. Its force F and moment m are those on the second body. In the
// plane, with c the centre of mass of a body (the world's origin for the ground) and P the
// element's point on the second body:
//
//     m_second = m + (P − c_second) × F,     m_first likewise for the action on the first body.
//
// Newton and Euler: m_b a_b = m_b g + Σ ±F,  J_b α_b = Σ m_first or m_second, over the elements of
// a body. The same structures store impulses (N s, N m s, J); accelerations are then changes of
// velocity.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

namespace freeplay {

/// An element whose forces a step reports.
struct ForceElement {
  /// drive: torque of a drive; push: force of a drive along a translational joint; force and
  /// torque: loads; section: an element of a beam
  enum class Kind { joint, contact, drive, push, force, torque, section };
  /// of the element in the scene
  std::string name;
  /// kind of element
  Kind kind = Kind::joint;
  std::array<int, 2> bodies{-1, -1};  ///< first and second; −1: ground
  int joint = -1;                     ///< index of its joint; −1: none
  /// False if constraint rows are dependent. Mechanics then determines only the sum of such
  /// reactions, and the reported ones have the least norm.
  bool determined = true;
};

/// Force of one element on its second body.
struct ElementForce {
  double fx = 0, fy = 0;  ///< N, on the second body, world
  double m = 0;           ///< N m, on the second body, about the element's point
  /// N m, on the first and second body, about its centre of mass
  double m_first = 0, m_second = 0;
  /// N. Contacts: normal (≥ 0: repulsion) and along the sliding rate. Sections of beams: normal (≥ 0: tension) and
  /// shear force.
  double fn = 0, ft = 0;
  double bending = 0;  ///< N m, bending moment of a section
  double power = 0;    ///< W, power of drives and loads into the mechanism

  /// Adds `weight` times f.
  void add(double weight, const ElementForce& f) {
    fx += weight * f.fx;
    fy += weight * f.fy;
    m += weight * f.m;
    m_first += weight * f.m_first;
    m_second += weight * f.m_second;
    fn += weight * f.fn;
    ft += weight * f.ft;
    bending += weight * f.bending;
    power += weight * f.power;
  }
  template <class M>
  void serialize(M& memory) {
    memory(fx, fy, m, m_first, m_second, fn, ft, bending, power);
  }
};

/// Forces of all elements and accelerations at one time, or their sums over time.
struct Forces {
  std::vector<ElementForce> elements;  ///< in the order of Layout::forces
  std::vector<double> acceleration;    ///< m/s², rad/s², as State::v

  /// Sets all values to 0 and keeps the sizes.
  void clear() {
    for (auto& f : elements) f = {};
    for (auto& a : acceleration) a = 0;
  }
  /// Adds `weight` times `other`; an empty object takes its size.
  void add(double weight, const Forces& other) {
    elements.resize(other.elements.size());
    acceleration.resize(other.acceleration.size());
    for (std::size_t i = 0; i < elements.size(); ++i) elements[i].add(weight, other.elements[i]);
    for (std::size_t i = 0; i < acceleration.size(); ++i) acceleration[i] += weight * other.acceleration[i];
  }
  template <class M>
  void serialize(M& m) {
    m(elements, acceleration);
  }
};

/// Change of the velocities by the impacts within a time step, all at time t. Other steps have no
/// impacts within.
struct StepImpacts {
  double t = 0;               ///< s; the end of the step if it has no impacts
  std::span<const double> v;  ///< m/s, rad/s: change of the velocities; empty: none
};

}  // namespace freeplay
