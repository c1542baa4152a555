// The rows G of a System on the coordinates that are not held, in a metric W (diagonal):
//
//     min ½ xᵀ W x − fᵀ x   subject to   G x = r,   x_c = 0 for each held coordinate c.
//
// Held coordinates leave rows that depend on others or have no entry. choose() selects independent
// rows (numerics/sparse.hpp); the caller decides by the residual whether the others are satisfied.
#pragma once

#include <memory>
#include <vector>

#include "numerics/saddle_point.hpp"
#include "values/state.hpp"

namespace freeplay {

// Reactions that mechanics does not determine.

class System;

/// Indices into ForceReport::elements of ideal joints and drives whose reactions are not unique
/// at a state: some combination z of their rows has Gᵀz = 0, so any multiple of it may be added to
/// the multipliers.
std::vector<int> undetermined_elements(const System& system, const State& state);

/// Throws ModelError if such a reaction bounds a friction.
void refuse_undetermined_friction(const System& system, const State& state);

/// Weights of the coordinates, and which of them are held (empty: none).
struct Metric {
  std::vector<double> weight;
  std::vector<char> held = {};
};

class MovableRows {
 public:
  /// `redundant`: some rows depend on others. Without held coordinates all rows are in force.
  MovableRows(const System& system, const Metric& metric, bool redundant = false);
  /// With held coordinates: selects the rows in force at G; to be called before factor().
  void choose(const std::vector<double>& G);
  /// Rows that are not in force, ascending.
  std::vector<int> left_out() const;
  [[nodiscard]] bool factor(const std::vector<double>& G);
  bool singular() const { return saddle_ && saddle_->singular(); }
  /// `f` may be null for zero.
  void solve(const double* f, const std::vector<double>& r, std::vector<double>& x);

 private:
  std::vector<double> values(const std::vector<double>& G) const;
  void find_entries();

  const System& system_;
  const Metric& metric_;
  std::vector<int> rows_, columns_, place_;  // in force; movable; place of a coordinate, −1: held
  CsrPattern pattern_;
  std::vector<int> entries_;  // of the system's pattern
  std::vector<double> weight_, f_, r_, x_, lambda_;
  std::unique_ptr<SaddlePoint> saddle_;
};

}  // namespace freeplay
