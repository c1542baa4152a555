// ShearSpring: tangential compliance of a point contact with slip, in the penalty formulation. The
// tangential stiffness is κ times the normal one, k_T = κ F_el'(δ) with F_el = K δⁿ. In stick, the
// shear force y (N) is a state of the contact; v_T is the sliding speed of the bodies:
//
//     stick   ẏ = k_T v_T + y min(0, k̇_T/k_T),     F_T = −y         while |y| ≤ μ F_N
//     slip    F_T = −σ μ F_N,  σ = ±1                               while σ v_s ≥ 0
//
// While the contact area grows, the force changes by increments; while it shrinks, the force
// decreases in proportion to k_T. A constant force would generate energy in loading cycles (Elata
// and Berryman, Mech. Mater. 24 (1996) 229). κ = 2(1 − ν)/(2 − ν) for equal materials: Mindlin's
// 8 G* a over Hertz's 2 E* a. The sliding velocity v_s of the contact is v_T less the rate of the
// spring's deflection: with g = F_N/F_el (1 without damping)
//
//     v_s = v_T − σ (μ/κ) [g δ̇ + δ ġ/n − (1 − 1/n) g min(0, δ̇)].
//
// Sources: friction/mindlin.hpp; κ in K. L. Johnson, Contact Mechanics (1985), section 7.3;
// docs/theory/tangential-compliance.md.
#pragma once

#include <algorithm>
#include <cmath>

namespace freeplay {

struct ShearSpring {
  double mu = 0;           ///< μ > 0
  double ratio = 1;        ///< κ > 0
  double exponent = 1.5;   ///< n of F_el = K δⁿ
  double least_force = 0;  ///< N, F_el at a penetration of rounding size

  /// F_T along the tangent for the normal force F_N ≥ 0 (N). Zones are 0 for stick and σ for slip.
  template <class T>
  T force(int zone, const T& normal, const T& y) const {
    return zone == 0 ? T(-y) : T(-zone * mu * normal);
  }
  /// ẏ (N/s) at the depth δ > 0 (m) and its rate (m/s).
  template <class T>
  T rate(int zone, const T& delta, const T& delta_rate, const T& elastic, const T& v_t, const T& y) const {
    if (zone != 0) return T(0);
    T rise = ratio * exponent * elastic / delta * v_t;
    if (delta_rate < 0) rise += y * (exponent - 1) * delta_rate / delta;
    return rise;
  }
  /// J, energy of the spring under the force y.
  double energy(double delta, double elastic, double y) const {
    return delta > 0 ? 0.5 * y * y * delta / (ratio * exponent * elastic) : 0;
  }

  /// Zone at contact onset, with δ̇ > 0 and g there.
  int first_zone(double delta_rate, double g, double v_t) const {
    return ratio * std::abs(v_t) <= mu * g * delta_rate ? 0 : v_t < 0 ? -1 : 1;
  }
  /// The force over its bound, within −1 and 1 in stick.
  double load(double normal, double y) const { return y / (mu * (normal + least_force)); }
  /// v_s in slip (m/s).
  double slip(int zone, double delta, double delta_rate, double g, double g_rate, double v_t) const {
    return v_t - zone * mu / ratio *
                     (g * delta_rate + delta * g_rate / exponent -
                      (1 - 1 / exponent) * g * std::min(0.0, delta_rate));
  }
};

}  // namespace freeplay
