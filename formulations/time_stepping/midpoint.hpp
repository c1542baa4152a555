// The equations of a step of h (s) between velocities v and v⁺, with everything else at its middle,
//
//     M (v⁺ − v) + GᵀΛ = h f,        G v⁺ + Φ_t = (h/2) γ              (the rate of Φ at the end of the step)
//
// as the saddle point M v⁺ + GᵀΛ = M v + h f, G v⁺ = −Φ_t + (h/2) γ, and the iteration that finds the mean velocity where f
// depends on it. Nothing here knows a mechanism: arrays go in, so that three lines of a test are one.
#pragma once

#include <vector>

namespace freeplay {

struct MidpointTerms {
  int n = 0, m = 0;               ///< coordinates, constraint rows
  const double* mass = nullptr;   ///< n
  const double* force = nullptr;  ///< n, f
  const double* phi_t = nullptr;  ///< m
  const double* gamma = nullptr;  ///< m

  /// The right-hand sides of the saddle point: `f` of n, `r` of m.
  void sides(double h, const double* v, double* f, double* r) const {
    for (int i = 0; i < n; ++i) f[i] = mass[i] * v[i] + h * force[i];
    for (int k = 0; k < m; ++k) r[k] = -phi_t[k] + 0.5 * h * gamma[k];
  }
};

/// Finds v_mean = (v + v⁺)/2 where v⁺ depends on it: after each solution v⁺ one call of judge(), and another solution while it
/// says so. Coordinates are x, y and the angle of each body, rates judged at its radius of gyration.
class MeanVelocity {
 public:
  enum class Verdict {
    met,
    again,      ///< v_mean is the next to try
    unsettled,  ///< films: it goes to and fro; fixed steps go on with what they have
    unswept,    ///< sweeps: the same
    diverged
  };
  /// What v⁺ depends on beside dampers, and what decides how long it is looked for.
  struct Kind {
    bool sweeps = false, films = false, fixed = false;
  };
  struct Motion {
    double h;                         ///< s
    const double *q_mid, *v_old, *v;  ///< v: the solution at v_mean
    double reach;                     ///< m, the mechanism's longest arm
    double film_change;               ///< greatest change of a rate by films
  };

  Verdict judge(int iteration, const MidpointTerms& terms, const Motion& motion, Kind kind,
                std::vector<double>& v_mean);

  std::vector<double> last;  ///< the solution before
};

}  // namespace freeplay
