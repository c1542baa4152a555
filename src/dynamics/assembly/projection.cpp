#include "dynamics/assembly/projection.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "numerics/saddle_point.hpp"
#include "values/state.hpp"

namespace freeplay {

bool project_onto_constraints(const System& system, State& s) {
  constexpr int most = 20;
  auto e = system.make_evaluation();
  SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic,
                     {!redundant_rows(system, s.q).empty()});
  std::vector<double> change(s.q.size()), lambda(e.phi.size()), r(e.phi.size());
  double last = INFINITY;
  for (int i = 0;; ++i) {
    system.place(s.t, s.q.data(), e);
    double open = 0;
    for (std::size_t k = 0; k < r.size(); ++k) {
      r[k] = -e.phi[k];
      open = std::max(open, std::abs(r[k]));
    }
    if (!std::isfinite(open) || i == most) return false;
    // Converged to rounding: a further step no longer reduces the residual.
    if (open == 0 || (open >= 0.5 * last && open < 1e-12)) break;
    last = open;
    if (!saddle.factor(e.G.data())) return false;
    saddle.solve(nullptr, r.data(), change.data(), lambda.data());
    for (std::size_t c = 0; c < change.size(); ++c) s.q[c] += change[c];
  }
  if (!saddle.factor(e.G.data())) return false;
  for (int i = 0; i < 2; ++i) {  // the second pass removes the rounding of the first
    for (int k = 0; k < system.rows(); ++k)
      r[static_cast<std::size_t>(k)] =
          -e.phi_t[static_cast<std::size_t>(k)] - row_dot(system.pattern(), e.G.data(), k, s.v.data());
    saddle.solve(nullptr, r.data(), change.data(), lambda.data());
    for (std::size_t c = 0; c < change.size(); ++c) s.v[c] += change[c];
  }
  return true;
}

}  // namespace freeplay
