// SparseIsland: a contact problem of coupled contacts (contact_equations.hpp) with D stored by
// rows, for islands of many contacts. D has entries only where two rows involve the same part of
// the mechanism.
#pragma once

#include <vector>

#include "formulations/contact/contact_problem.hpp"

namespace freeplay {

struct SparseIsland {
  double rate(int row) const;
  double entry(int row, int column) const;
  double residual() const;
  /// Upper bound of the rounding error of the rates with the present impulses.
  double attainable() const;
  /// Copies the impulses of the unknowns to the rows (gather) and back (scatter).
  void gather();
  void scatter();

  std::vector<int> ids, members, slots;  // ids and members of its unknowns; slots of its rows
  std::vector<ContactUnknown> unknowns;  // with row numbers of the island
  std::vector<double> b, impulse;        // of its rows
  std::vector<int> begin, column;        // D by rows
  std::vector<double> value;
  ContactSolution found;
  bool doubtful = false;
};

}  // namespace freeplay
