// Sliding row of a pin of radius r. The surface speed is u = r (ω_j − ω_i), so u̇ = r (α_j − α_i)
// and γ = 0. A force f along the row is the couple r f on the second body and its opposite on the
// first.
#pragma once

#include "dynamics/kinematics.hpp"
#include "numerics/sparse.hpp"

namespace freeplay {

struct SpinRow {
  Link link;
  double radius = 0;  ///< m

  /// Fills the row of u = row·v and returns γ in u̇ = row·a − γ.
  template <class T>
  T rows(const T*, const T*, const EvaluationOf<T>&, SparseRowOf<T>& row) const {
    row.clear();
    if (link.i != ground) row.push(3 * link.i + 2, T(-radius));
    if (link.j != ground) row.push(3 * link.j + 2, T(radius));
    return T(0);
  }
};

}  // namespace freeplay
