// Numbers that a run reports on itself: the energy balance, counts of work, the greatest errors of
// constraints and contacts, and how the run ended. A formulation fills them; Result and run.json
// contain them.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace freeplay {

/// Energies (J) since the start. With the kinetic, potential and elastic energy T, V, E the balance
/// is, up to `closure()`,
///
///     (T + V + E) − (T₀ + V₀ + E₀) =
///         drive + load + stabilisation − contact − friction − damping − film.
struct EnergyLedger {
  double kinetic = 0, potential = 0, elastic = 0;  ///< at the present state
  double initial = 0;                              ///< kinetic + potential + elastic at the start
  double drive = 0;                                ///< work of the drives
  double load = 0;                                 ///< work of constant forces and torques
  double damping = 0;                              ///< dissipated in dampers, ≥ 0
  /// Dissipated in the normal direction of contacts.
  double contact = 0;
  /// Dissipated by friction, in contacts and joints.
  double friction = 0;
  double film = 0;  ///< dissipated in lubricant films
  /// Greatest kinetic energy, work of the drives or work of the loads at the end of any step so
  /// far: the scale of the balance for a motion that ends near rest. Not a term of the balance.
  double passed = 0;
  /// Sum over the steps of |work of the drives| + |work of the loads|, the scale of the integration
  /// error of both.
  double exchanged = 0;
  /// Work of constraint forces along constraint errors, and of projections of the positions.
  double stabilisation = 0;
  /// Residual of the balance: the integration error of the energies.
  double closure() const {
    return kinetic + potential + elastic - initial - drive - load - stabilisation + contact + friction +
           damping + film;
  }
  /// The greatest term of the balance, the scale of closure().
  double scale() const {
    return std::max({std::abs(kinetic), std::abs(initial), std::abs(drive), std::abs(load), std::abs(contact),
                     std::abs(friction), std::abs(damping),
                     std::abs(kinetic + potential + elastic - initial)});
  }

  template <class M>
  void serialize(M& m) {
    m(kinetic, potential, elastic, initial, drive, load, damping, contact, friction, film, stabilisation);
  }
};

/// Counts of work, independent of the machine.
struct Work {
  long steps = 0;     ///< accepted
  long rejected = 0;  ///< rejected adaptive steps
  /// Evaluations of the right-hand side, or of the system in time stepping.
  long rhs = 0;
  long jacobians = 0;       ///< of the right-hand side (implicit integrators)
  long factorisations = 0;  ///< saddle-point
  long lcp_solves = 0;      ///< solved complementarity problems with at least one unknown
  long lcp_retries = 0;     ///< solvers that failed before another succeeded
  long pivots = 0;          ///< Lemke's pivots; cases, sweeps or Newton steps of the other solvers
  long events = 0;          ///< located contact events
  long handovers = 0;       ///< switches of the automatic scheme to time stepping
  double stepped = 0;       ///< s, simulated time during these switches

  template <class M>
  void serialize(M& m) {
    m(steps, rejected, rhs, jacobians, factorisations, lcp_solves, lcp_retries, pivots, events, handovers,
      stepped);
  }
};

/// Greatest errors of constraints and contacts during the run.
struct Extremes {
  double constraint_length = 0;  ///< m, greatest |Φ| of rows in m
  double constraint_angle = 0;   ///< rad
  double lcp_residual = 0;       ///< greatest relative residual of a complementarity solve
  double lcp_residual_rate = 0;  ///< m/s (m/s² in accelerations), the same before division
  /// Greatest residual of friction bounded by reactions, relative to its bound.
  double friction_residual = 0;
  /// Steps of the shortest flight before one of the fastest impacts (time stepping)
  double shortest_flight = INFINITY;
  /// Complementarity problems that may have several solutions (Painlevé).
  long ambiguous = 0;
  long gains = 0;                   ///< impacts that increased the energy beyond rounding
  double greatest_gain = 0;         ///< J, greatest of these increases
  double greatest_kinetic = 0;      ///< J, before an impact: the scale of rounding for `gains`
  std::vector<double> penetration;  ///< m, greatest of each contact

  template <class M>
  void serialize(M& m) {
    m(constraint_length, constraint_angle, lcp_residual, lcp_residual_rate, friction_residual,
      shortest_flight, ambiguous, gains, greatest_gain, greatest_kinetic, penetration);
  }
  /// Counts an impact that increased the energy by `gain` (J), if that exceeds `share` of the
  /// greatest kinetic energy before any impact so far. After the mechanism has come to rest,
  /// rounding is therefore not counted.
  void count_gain(double gain, double kinetic, double share) {
    if (kinetic > greatest_kinetic) greatest_kinetic = kinetic;
    if (!(gain > share * greatest_kinetic)) return;
    ++gains;
    if (gain > greatest_gain) greatest_gain = gain;
  }
};

/// Parameters of one contact in a formulation.
struct ContactModel {
  /// of the surface
  double restitution_asked = 0;
  /// effective restitution of the law
  double restitution_delivered = 0;
  double stiffness = 0;  ///< N/m^n; 0 for an impact law
  /// n of K δⁿ
  double exponent = 0;
  /// χ, damping factor of the contact law
  double chi = 0;
};

/// How a run ended.
struct Ending {
  /// Status of a run.
  enum class Status { finished, interrupted, failed };
  /// status of the run
  Status status = Status::finished;
  std::string reason;  ///< for a failure: its cause and possible remedies
};

}  // namespace freeplay
