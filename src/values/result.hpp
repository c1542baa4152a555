// What one run amounts to, in the same shape from either formulation.
#pragma once

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
  double wall_seconds = 0, cpu_seconds = 0;  ///< CPU time is that of the run's thread
  long peak_memory_kib = 0;                  ///< of the whole process so far
};

}  // namespace freeplay
