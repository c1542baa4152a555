// What a run says of itself in numbers: energies, work done, how well constraints and walls were kept.
#pragma once

#include <cmath>
#include <string>
#include <vector>

namespace freeplay {

/// Energies (J) since the start. With T, V, E the kinetic, potential and elastic energy the balance is, up to
/// `closure()`,
///
///     (T + V + E) − (T₀ + V₀ + E₀) = drive + load + stabilisation − contact − friction − damping − film.
struct EnergyLedger {
  double kinetic = 0, potential = 0, elastic = 0;  ///< now
  double initial = 0;                              ///< kinetic + potential + elastic at the start
  double drive = 0;                                ///< work of the drives
  double load = 0;                                 ///< work of constant forces and torques
  double damping = 0;                              ///< dissipated in dampers, ≥ 0
  double contact = 0;                              ///< dissipated in the normal direction of contacts
  double friction = 0;  ///< dissipated by friction, in contacts and preloaded joints
  double film = 0;      ///< dissipated in lubricant films
  /// Greatest kinetic energy, or work of the drives or of the loads, at the end of any step so far: what the balance of
  /// a motion that ends near rest is judged by. No term of the balance.
  double passed = 0;
  /// Work of constraint forces along constraint errors, and of moving positions back.
  double stabilisation = 0;
  /// What the balance leaves unexplained: the integration error of the energies themselves.
  double closure() const {
    return kinetic + potential + elastic - initial - drive - load - stabilisation + contact + friction +
           damping + film;
  }
  /// The largest of the balance's terms, to judge the closure by.
  double scale() const;

  template <class M>
  void remember(M& m) {
    m(kinetic, potential, elastic, initial, drive, load, damping, contact, friction, film, stabilisation);
  }
};

/// Counts that do not depend on the machine.
struct Work {
  long steps = 0;           ///< accepted
  long rejected = 0;        ///< adaptive steps refused
  long rhs = 0;             ///< right-hand sides, or evaluations of the system in time stepping
  long jacobians = 0;       ///< of the right-hand side (implicit integrators)
  long factorisations = 0;  ///< saddle-point
  long lcp_solves = 0;      ///< complementarity problems with at least one unknown
  long lcp_retries = 0;     ///< solvers of them that failed before another did not
  long pivots = 0;          ///< of Lemke; cases, sweeps or Newton steps of the other solvers
  long events = 0;          ///< located contact events
  long handovers = 0;       ///< to time stepping, by the automatic scheme
  double stepped = 0;       ///< s, of the time, that it took over for

  template <class M>
  void remember(M& m) {
    m(steps, rejected, rhs, jacobians, factorisations, lcp_solves, lcp_retries, pivots, events, handovers,
      stepped);
  }
};

/// How well the run kept its constraints and its walls.
struct Extremes {
  double constraint_length = 0;  ///< m, greatest |Φ| of rows in m
  double constraint_angle = 0;   ///< rad
  double lcp_residual = 0;       ///< greatest relative residual of a complementarity solve
  double lcp_residual_rate = 0;  ///< m/s (m/s² in accelerations), the same before division
  double friction_residual = 0;  ///< greatest of friction bounded by reactions, over its bound
  /// Steps of the shortest flight that ended in one of the run's fastest impacts (time stepping)
  double shortest_flight = INFINITY;
  long ambiguous = 0;               ///< complementarity solves that may have had other solutions (Painlevé)
  long gains = 0;                   ///< impacts that raised the energy by more than rounding
  double greatest_gain = 0;         ///< J, of one of them
  double greatest_kinetic = 0;      ///< J, before an impact: what the rounding of gains is judged by
  std::vector<double> penetration;  ///< m, of each contact

  template <class M>
  void remember(M& m) {
    m(constraint_length, constraint_angle, lcp_residual, lcp_residual_rate, friction_residual,
      shortest_flight, ambiguous, gains, greatest_gain, greatest_kinetic, penetration);
  }
  /// Counts an impact that raised the energy by `gain` (J) if that is more than `share` of the greatest kinetic
  /// energy that impacts have found so far: after a mechanism has come to rest, rounding is no gain.
  void count_gain(double gain, double kinetic, double share) {
    if (kinetic > greatest_kinetic) greatest_kinetic = kinetic;
    if (!(gain > share * greatest_kinetic)) return;
    ++gains;
    if (gain > greatest_gain) greatest_gain = gain;
  }
};

/// What a formulation makes of one contact.
struct ContactModel {
  double restitution_asked = 0;
  double restitution_delivered = 0;
  double stiffness = 0;  ///< N/m^n; 0 for an impact law
  double exponent = 0;
  double chi = 0;
};

/// How a run ended.
struct Ending {
  enum class Status { finished, interrupted, failed };
  Status status = Status::finished;
  std::string reason;  ///< for a failure: what happened and what may help
};

}  // namespace freeplay
