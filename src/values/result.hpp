// Result of one run, with the same structure for both formulations. Simulation::run() returns it,
// and run.json is written from it. Statistics are present only if their observers took part.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "values/event.hpp"
#include "values/ledger.hpp"
#include "values/state.hpp"

namespace freeplay {

// Statistics of the lubricant film of one joint over the time after the discarded start.

/// Of one film; times after the discarded start only.
struct FilmSummary {
  double mean_ratio = 0, greatest_ratio = 0;  ///< eccentricity ratio ε
  double mean_thickness = 0;                  ///< m, of the least film thickness c(1 − ε)
  double least_thickness = 0, least_at = 0;   ///< m, and its time (s)
  double mean_load = 0, greatest_load = 0;    ///< N, magnitude of the film force
  double mean_speed = 0;                      ///< rad/s, of |ω_i + ω_j|
  double attitude = 0;                        ///< rad, direction of the mean of (cos φ, sin φ)
  double sommerfeld = 0;                      ///< of mean load and mean speed; 0 without load
  double mean_loss = 0, greatest_loss = 0;    ///< W, dissipated power
};

/// Wear and pressure of one dry bearing that states wear or has an elastic foundation; times after the
/// discarded start only.
struct BearingSummary {
  /// name of the joint
  std::string joint;
  double time = 0;     ///< s, observed
  double sliding = 0;  ///< m, sliding distance while in contact
  double work = 0;     ///< N m, ∫ F ds: normal force times sliding distance, with impacts
  /// m²/s, worn area of the cross-section over time; empty: the surface does not wear
  std::optional<double> bearing_wear_rate = {}, journal_wear_rate = {};
  double greatest_pressure = 0;  ///< Pa
};

/// One contact. Statistics cover the time after the discarded start and need a ContactStatistics
/// observer; otherwise they are 0.
struct ContactSummary {
  /// of the contact in the scene
  std::string name;
  /// its parameters
  ContactModel model;
  double flight_fraction = 0, impact_fraction = 0, lasting_fraction = 0;  ///< share of the time
  long impacts = 0;                                                       ///< all impacts
  long counted_impacts = 0;  ///< impacts with an approach speed of at least a tenth of the fastest
  /// Counted impacts; per second if no drive prescribes a speed.
  double impacts_per_revolution = 0;
  double fastest_approach = 0;                      ///< m/s
  double median_approach = 0;                       ///< m/s, of all impacts
  double median_impulse = 0, greatest_impulse = 0;  ///< N s
  double penetration = 0;                           ///< m, greatest
  /// Penetration over `measure`: the clearance; without it, the radius of curvature; for a point,
  /// the longest arm.
  double penetration_ratio = 0;
  std::string measure = "clearance";  ///< "clearance", "radius" or "arm"
  /// Whether the contact is that of a joint with clearance.
  bool has_clearance() const { return measure == "clearance"; }
  /// Duration of impacts over that of the flight before each, both weighted by the impulse. 0 with
  /// an impact law, or if no flight between two contacts was observed.
  double impact_over_flight = 0;
  /// Standard errors of the three fractions and of impacts_per_revolution, from batches
  /// (Result::window); NaN if there are too few batches.
  double flight_error = NAN, impact_error = NAN, lasting_error = NAN, impacts_error = NAN;
  std::optional<FilmSummary> film;  ///< of a lubricated joint, with a FilmStatistics observer
};

/// Names of a Window's energies in result files, in the order of Window::Term.
inline constexpr std::array energy_terms{"work_of_drives",
                                         "work_of_loads",
                                         "dissipated_in_dampers",
                                         "dissipated_in_contacts",
                                         "dissipated_by_friction",
                                         "dissipated_in_films",
                                         "work_of_stabilisation",
                                         "stored",
                                         "closure"};

/// The time interval of the statistics and the energies of this interval.
struct Window {
  /// Indices of `energy` and `error`.
  enum Term { drives, loads, dampers, contacts, friction, films, stabilisation, stored, closure };
  double from = 0, to = 0;                         ///< s
  double batch = 0;                                ///< s, length of the batches for standard errors
  int batches = 0;                                 ///< complete ones; 0: too few for an error
  std::array<double, energy_terms.size()> energy;  ///< J, in the window
  std::array<double, energy_terms.size()> error;   ///< J, standard errors
};

/// Estimated errors of the first contact onsets of a time-stepped run, from a companion run with a
/// shorter step.
struct OnsetDoubt {
  int touches = 0;            ///< number of onsets compared
  double until = 0;           ///< s, time of the last one
  double step = 0;            ///< s, of the run
  double companion_step = 0;  ///< s
  double factor = 0;          ///< ratio of the estimate to the difference of the two runs
  double time = 0;            ///< estimate for times, relative to the time since the previous onset
  double speed = 0;           ///< estimate for approach speeds, relative
  double impulse = 0;         ///< estimate for normal impulses, relative
  bool missing = false;       ///< the companion run has other contact onsets
  /// The greatest of the estimates; infinity if an onset is missing.
  double greatest() const { return missing ? INFINITY : std::max({time, speed, impulse}); }
};

/// Compiled functions of the mechanism in a run. They are bitwise identical to the general ones.
struct CompiledRun {
  bool used = false;   ///< whether the run used them
  double from = 0;     ///< s, time of the run from which on
  std::string reason;  ///< why not
  long refused = 0;    ///< calls that the general functions answered, because a guard failed
  std::vector<std::string> general_parts;  ///< parts that cannot be compiled, with the reasons
};

/// Result of a run.
struct Result {
  /// "penalty" or "nonsmooth"
  std::string formulation;
  /// how the run ended
  Ending ending;
  double t_end = 0;     ///< s, time reached
  double observed = 0;  ///< s, after the discarded start
  /// at t_end
  State final_state;
  double revolutions = 0;  ///< in the statistics; 0 without a drive of prescribed speed
  /// energies at t_end and work (J)
  EnergyLedger ledger;
  /// counters of the computation
  Work work;
  /// greatest penetrations, constraint errors and residuals
  Extremes extremes;
  /// statistics of each contact
  std::vector<ContactSummary> contacts;
  std::vector<BearingSummary> bearings;  ///< with a BearingLoadObserver
  std::vector<std::string> notes;        ///< messages for the user
  /// Assumption about the start if the scene leaves it open, else empty.
  std::string assumed;
  /// Events in the order of time; only the first ones if there are more than are kept.
  std::vector<Event> events;
  /// number of all events
  long events_seen = 0;
  /// Whether the list is truncated: events after its last one are then missing.
  bool events_cut() const { return events_seen > static_cast<long>(events.size()); }
  /// Ideal joints and drives whose reactions mechanics does not determine; found if forces were
  /// observed.
  std::vector<std::string> undetermined;
  /// whether the mechanism was compiled
  CompiledRun compiled;
  std::optional<Window> window;              ///< with a WindowStatistics observer
  std::optional<OnsetDoubt> first_touches;   ///< if a companion run was requested
  double wall_seconds = 0, cpu_seconds = 0;  ///< CPU time of the run's thread
  long peak_memory_kib = 0;                  ///< of the whole process so far
};

}  // namespace freeplay
