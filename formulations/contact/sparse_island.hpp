// A contact problem of coupled contacts (contact_equations.hpp) with D by rows: an island of many contacts, where D has entries only
// where two rows touch the same part of the mechanism.
#pragma once

#include <vector>

#include "formulations/contact/contact_problem.hpp"

namespace freeplay {

struct SparseIsland {
  double rate(int row) const;
  double entry(int row, int column) const;
  double residual() const;
  /// What rounding leaves of the laws' rates at the present impulses, at most.
  double attainable() const;
  /// Impulses of the rows from those of the unknowns, and back.
  void gather();
  void scatter();

  std::vector<int> ids, members, slots;  // of its unknowns; of its rows
  std::vector<ContactUnknown> unknowns;  // with rows of the island
  std::vector<double> b, impulse;        // of its rows
  std::vector<int> begin, column;        // D by rows
  std::vector<double> value;
  ContactSolution found;
  bool doubtful = false;
};

}  // namespace freeplay
