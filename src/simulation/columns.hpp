// The columns of a run's tables, once: what trajectory.csv and forces.csv call them, and where each is found in what an
// observer is shown.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "simulation/observer.hpp"

namespace freeplay {

struct Column {
  /// mean: of a force since the row before; acceleration: of a body
  enum class Of { time, position, velocity, contact, force, mean, acceleration };
  std::string owner;  ///< body, contact, joint, drive or load; none of t
  const char* part = "";
  Of of = Of::time;
  std::size_t index = 0;  ///< into q, v, Layout::contacts, Layout::forces or Forces::acceleration
  double ContactPlace::*place = nullptr;
  double ElementForce::*force = nullptr;

  /// As a header has it: gudgeon.gap, gudgeon.fn, big_end.fx_mean, t.
  std::string name() const;
};

/// Of trajectory.csv, t first.
std::vector<Column> trajectory_columns(const Layout& layout);
/// Of forces.csv, t first.
std::vector<Column> force_columns(const Layout& layout);
/// A line of names, with its end.
std::string header_of(const std::vector<Column>& columns);

/// Columns of forces are found by their names: throws ModelError where two elements share one.
void refuse_shared_names(const Layout& layout);

/// Of one element of forces.csv: at an instant, and of means.
struct ForceParts {
  std::vector<std::pair<const char*, double ElementForce::*>> now, mean;
};
ForceParts force_parts(ForceElement::Kind kind);

}  // namespace freeplay
