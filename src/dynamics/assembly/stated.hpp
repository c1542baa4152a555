// Initial values that a scene states. The start keeps them, and determines absent ones:
//
//     1. stated values held, absent ones nearest to rest, or to the bodies' attached pose
//        (other_starts.hpp), in the metric of the masses;
//     2. if no such start satisfies the constraints, the stated values change by the least
//        mass-weighted amount, and absent ones follow.
//
// The velocities satisfy G v + Φ_t = 0 at the positions. A change above 1e-9 of a value's scale is
// reported, above 1 % refused (Configuration::approximate).
#pragma once

#include <string>
#include <vector>

#include "dynamics/assembly/closure.hpp"
#include "dynamics/assembly/movable_rows.hpp"
#include "values/state.hpp"

namespace freeplay {

struct Mechanism;
class System;

/// Relative changes of stated values: up to `silent` they are rounding; `most` is the default limit.
inline constexpr double silent_change = 1e-9, most_change = 1e-2;

/// Whether each coordinate, or rate, is stated.
std::vector<char> stated_positions(const Mechanism& mechanism);
std::vector<char> stated_velocities(const Mechanism& mechanism);
/// The stated values; 0 for absent ones.
State stated_state(const Mechanism& mechanism);
bool any(const std::vector<char>& stated);

/// Metric of the masses in which absent values are light: their movement costs nothing beside that
/// of stated ones.
Metric light_where_absent(const System& system, const std::vector<char>& stated);

/// A stated value that the start changed.
struct Change {
  std::string key;
  double amount = 0, relative = 0;  ///< in the value's unit; of its scale
  const char* unit = "";
};
/// The changes of positions and angles, greatest first; scales: the length (m), and a radian.
std::vector<Change> changed_positions(const Mechanism& mechanism, const std::vector<double>& q,
                                      double length);
/// The changes of velocities, greatest first. The scale of a value is its own size, and at least a
/// hundredth of `speed` (m/s), that of the start.
std::vector<Change> changed_velocities(const Mechanism& mechanism, const std::vector<double>& v,
                                       double length, double speed);
/// Speed scale (m/s) of a start: the greatest of its velocities, the stated ones and the rates of
/// drives, and at least 1e-3 lengths (m) per second. Rates of angles are multiplied by the length.
double speed_scale(const Mechanism& mechanism, const std::vector<double>& v, double length);

/// Number of changes that listed() names.
inline constexpr std::size_t listed_changes = 3;
/// The greatest changes as text: "bodies.rod.angle by 0.21 rad, bodies.crank.angle by 0.1 rad".
std::string listed(const std::vector<Change>& changes);
/// Adds a note on changes above rounding to `note`; throws ModelError above `limit`. `open`: the
/// constraint that the stated values violate; `per`: "" for positions, "/s" for velocities.
void report_changes(const Mechanism& mechanism, const std::vector<Change>& changes, const OpenJoint& open,
                    const char* per, double limit, std::string& note);

/// Completes the velocities of s at its positions. `stated` ones are kept, or change by the least
/// mass-weighted amount if they contradict the constraints; the others change least from those in s.
/// Returns the row that the stated velocities violate most (m/s, rad/s). Throws ModelError if no
/// velocities satisfy all rows.
OpenJoint assemble_velocities(const Mechanism& mechanism, const System& system,
                              const std::vector<char>& stated, State& s);

}  // namespace freeplay
