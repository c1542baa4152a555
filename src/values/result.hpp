// What one run amounts to, in the same shape from either formulation.
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

/// One contact. Its statistics, after the discarded start, are those of a ContactStatistics that watched; else 0.
struct ContactSummary {
  std::string name;
  ContactModel model;
  double flight_fraction = 0, impact_fraction = 0, lasting_fraction = 0;  ///< of the time
  long impacts = 0;                                                       ///< all
  long counted_impacts = 0;           ///< with an approach speed of at least a tenth of the fastest
  double impacts_per_revolution = 0;  ///< counted ones; per second when nothing turns at a prescribed speed
  double fastest_approach = 0;        ///< m/s
  double median_approach = 0;         ///< m/s, of all impacts
  double median_impulse = 0, greatest_impulse = 0;  ///< N s
  double penetration = 0;                           ///< m, greatest
  /// Of the clearance; without one of the radius of curvature, of a point of the longest arm.
  double penetration_ratio = 0;
  std::string measure = "clearance";  ///< which of these: "clearance", "radius" or "arm"
  bool has_clearance() const { return measure == "clearance"; }
  /// Duration of impacts over that of the flight before each, both weighted by the impulse; 0 under an impact
  /// law, or when no flight between two contacts was seen.
  double impact_over_flight = 0;
  /// Standard errors of the four, from batches (Result::window); NaN where there are too few.
  double flight_error = NAN, impact_error = NAN, lasting_error = NAN, impacts_error = NAN;
};

/// Energies of a Window as result files name them, in the order of Window::Term.
inline constexpr std::array energy_terms{"work_of_drives",
                                         "work_of_loads",
                                         "dissipated_in_dampers",
                                         "dissipated_in_contacts",
                                         "dissipated_by_friction",
                                         "dissipated_in_films",
                                         "work_of_stabilisation",
                                         "stored",
                                         "closure"};

/// The time that statistics are over, and the energies of that time alone.
struct Window {
  /// What `energy` and `error` hold.
  enum Term { drives, loads, dampers, contacts, friction, films, stabilisation, stored, closure };
  double from = 0, to = 0;  ///< s
  double batch = 0;         ///< s, length of the batches that standard errors come from
  int batches = 0;          ///< whole ones; 0: too few for an error
  std::array<double, energy_terms.size()> energy;  ///< J, in the window
  std::array<double, energy_terms.size()> error;   ///< J, standard errors
};

/// How far the first touches of a time-stepped run may be off, from a companion at a shorter step.
struct TouchDoubt {
  int touches = 0;            ///< judged
  double until = 0;           ///< s, of the last of them
  double step = 0;            ///< s, of the run
  double companion_step = 0;  ///< s
  double factor = 0;          ///< from the companion's difference to what is said
  double time = 0;            ///< said of times, over the time since the touch before
  double speed = 0;           ///< said of approach speeds, relative
  double impulse = 0;         ///< said of normal impulses, relative
  bool missing = false;       ///< the companion's touches are others
  double greatest() const { return missing ? INFINITY : std::max({time, speed, impulse}); }
};

struct Result {
  std::string formulation;
  Ending ending;
  double t_end = 0;     ///< s, reached
  double observed = 0;  ///< s, of them after the discarded start
  State final_state;
  double revolutions = 0;  ///< counted in the statistics; 0 without a drive of prescribed speed
  EnergyLedger ledger;
  Work work;
  Extremes extremes;
  std::vector<ContactSummary> contacts;
  std::vector<std::string> notes;  ///< what a user must read
  std::string assumed;             ///< of the start, where the scene leaves it open; else empty
  std::vector<Event> events;  ///< in the order of time, the first of them when there are more than are kept
  long events_seen = 0;
  /// The list is cut: what follows its last event is not known from it.
  bool events_cut() const { return events_seen > static_cast<long>(events.size()); }
  /// Ideal joints and drives whose reactions mechanics does not determine; found when forces were watched.
  std::vector<std::string> undetermined;
  std::optional<Window> window;              ///< where a WindowStatistics watched
  std::optional<TouchDoubt> first_touches;   ///< where a companion was asked for
  double wall_seconds = 0, cpu_seconds = 0;  ///< CPU time is that of the run's thread
  long peak_memory_kib = 0;                  ///< of the whole process so far
};

}  // namespace freeplay
