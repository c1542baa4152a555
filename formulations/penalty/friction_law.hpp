// Regularised Coulomb friction. Ambrósio (2003), as used by Flores et al. 2011:
//
//     F_T = −μ c_d F_N sgn(v_T),    c_d = 0 below v₀,  (|v_T| − v₀)/(v₁ − v₀) between,  1 above v₁.
//
// It has no stiction: under a tangential load it creeps at up to v₁.
#pragma once

namespace freeplay {

struct AmbrosioFriction {
  double v0 = 0;  ///< m/s
  double v1 = 0;  ///< m/s, > v0

  /// c_d sgn(v_T), in [−1, 1].
  double direction(double v_t) const {
    const double speed = v_t < 0 ? -v_t : v_t;
    if (speed <= v0) return 0;
    const double c = speed >= v1 ? 1 : (speed - v0) / (v1 - v0);
    return v_t < 0 ? -c : c;
  }
};

/// Friction of a preloaded joint: linear up to the regularising velocity, then the bound.
inline double preloaded_friction(double bound, double regularisation, double u) {
  const double x = u / regularisation;
  return -bound * (x > 1 ? 1 : x < -1 ? -1 : x);
}

}  // namespace freeplay
