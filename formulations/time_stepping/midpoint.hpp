// Equations of a step of h (s) between velocities v and v⁺, with all other quantities at its
// middle,
//
//     M (v⁺ − v) + GᵀΛ = h f,        G v⁺ + Φ_t = (h/2) γ    (the rate of Φ at the end of the step)
//
// as the saddle point M v⁺ + GᵀΛ = M v + h f, G v⁺ = −Φ_t + (h/2) γ, and the iteration for the mean
// velocity if f depends on it. These classes use arrays only and know no mechanism, so that they
// can be tested with a few numbers.
#pragma once

#include <vector>

namespace freeplay {

struct MidpointTerms {
  int n = 0, m = 0;               ///< coordinates, constraint rows
  const double* mass = nullptr;   ///< n
  const double* force = nullptr;  ///< n, f
  const double* phi_t = nullptr;  ///< m
  const double* gamma = nullptr;  ///< m

  /// The right-hand sides of the saddle point: `f` of size n, `r` of size m.
  void sides(double h, const double* v, double* f, double* r) const {
    for (int i = 0; i < n; ++i) f[i] = mass[i] * v[i] + h * force[i];
    for (int k = 0; k < m; ++k) r[k] = -phi_t[k] + 0.5 * h * gamma[k];
  }
};

/// MeanVelocity: fixed-point iteration for v_mean = (v + v⁺)/2 where v⁺ depends on it. After each
/// solution v⁺, assess() is called; another solution follows while it returns `again`. Coordinates
/// are x, y and the angle of each body; changes of angular rates are multiplied by the body's
/// radius of gyration.
class MeanVelocity {
 public:
  enum class Verdict {
    met,
    again,      ///< v_mean is the next to try
    unsettled,  ///< films: the iteration oscillates; fixed steps continue with the last value
    unswept,    ///< sweeps: the iteration oscillates; the last value is used
    diverged
  };
  /// Dependencies of v⁺ besides dampers, and whether steps are fixed; they decide how long the
  /// iteration continues.
  struct Kind {
    bool sweeps = false, films = false, fixed = false;
  };
  struct Motion {
    double h;                         ///< s
    const double *q_mid, *v_old, *v;  ///< v: the solution at v_mean
    double reach;                     ///< m, the longest arm of the mechanism
    double film_change;               ///< greatest change of a rate by films
  };

  Verdict assess(int iteration, const MidpointTerms& terms, const Motion& motion, Kind kind,
                 std::vector<double>& v_mean);

  std::vector<double> last;  ///< the previous solution
};

}  // namespace freeplay
