// The columns of a run's tables: names in trajectory.csv and forces.csv, and the place of each
// value in the data that an observer receives. Writers, ensembles and studies all use these lists.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "simulation/observer.hpp"

namespace freeplay {

struct Column {
  /// mean: mean of a force since the previous row; acceleration: of a body
  enum class Of { time, position, velocity, contact, force, mean, acceleration };
  std::string owner;  ///< name of the body, contact, joint, drive or load; empty for t
  const char* part = "";
  Of of = Of::time;
  /// Index into q, v, Layout::contacts, Layout::forces or Forces::acceleration.
  std::size_t index = 0;
  double ContactPlace::*place = nullptr;
  double ElementForce::*force = nullptr;

  /// Name in a header: gudgeon.gap, gudgeon.fn, big_end.fx_mean, t.
  std::string name() const;
};

/// Columns of trajectory.csv, t first.
std::vector<Column> trajectory_columns(const Layout& layout);
/// Columns of forces.csv, t first.
std::vector<Column> force_columns(const Layout& layout);

/// The data of a run at one time, from which columns are read.
struct ColumnData {
  std::vector<double> q, v;
  std::vector<ContactPlace> contacts;
  Forces now, sum;  ///< forces, and their impulses since the previous row

  /// Sets the sizes.
  void begin(const Layout& layout, const State& state);
  /// Value of a column at the time t (s) of the data; of a mean, the impulse.
  double value(const Column& column, double t) const;
  /// Replaces `row` by the values of the columns.
  void row(const std::vector<Column>& columns, double t, std::vector<double>& row) const;
};

/// Throws ModelError if two elements have the same name, because columns of forces are found by
/// name.
void refuse_shared_names(const Layout& layout);

/// Columns of one element of forces.csv: values at an instant, and means.
struct ForceParts {
  std::vector<std::pair<const char*, double ElementForce::*>> now, mean;
};
ForceParts force_parts(ForceElement::Kind kind);

}  // namespace freeplay
