// The least mass-weighted change that takes a state back onto what its mode holds:
//
//     positions:   G Δq = −Φ,           W_Nᵀ Δq = −g       (closed)
//     velocities:  G Δv = −(G v + Φ_t),  W_Nᵀ Δv = −W_Nᵀ v (closed),  W_Tᵀ Δv = −W_Tᵀ v (sticking)
#include "formulations/event_driven/event_dynamics.hpp"

namespace freeplay {

void EventDynamics::project(Vector& x, double t, Forces* book) {
  const int n = system_.n(), m = system_.rows();
  double* q = x.data();
  double* v = q + n;
  const double before = system_.kinetic(v) + system_.potential(q);
  // Least change with G Δ = −r and the active rows Δ = −s.
  const auto move = [&](double* y, auto residual, auto active) {
    for (int k = 0; k < m; ++k) r_[k] = -residual(k);
    saddle_.solve(nullptr, r_.data(), change_.data(), lambda_.data());
    used_ = 0;
    owners_.clear();
    active();
    if (used_ > 0) {
      for (int r = 0; r < used_; ++r) {
        rhs_[r] = -rhs_[r] - rows_[r].dot(change_.data());
        for (int s = 0; s <= r; ++s) K_(r, s) = K_(s, r) = rows_[r].dot(response(s));
      }
      solve_active();
      for (int r = 0; r < used_; ++r)
        for (int i = 0; i < n; ++i) change_[i] += solution_[r] * response(r)[i];
    }
    for (int i = 0; i < n; ++i) y[i] += change_[i];
    if (y == q || !book) return;
    for (int r = 0; r < used_; ++r) {
      for (int k = 0; k < m; ++k) lambda_[k] += solution_[r] * reaction(r)[k];
      const auto& o = owners_[r];
      if (o.contact >= 0)
        system_.report_contact(o.contact, q, e_, contacts_[o.contact].row, o.tangent ? 0 : solution_[r],
                               o.tangent ? solution_[r] : 0, 1, *book);
      else
        system_.report_friction(o.friction, q, v, e_, rows_[r], solution_[r], 1, *book);
    }
    system_.report_rows(q, e_, lambda_.data(), 1, *book);
    for (int i = 0; i < n; ++i) book->acceleration[i] += change_[i];
  };
  place(q, t);
  ++work.factorisations;
  if (!saddle_.factor(e_.G.data())) return;
  move(
      q, [&](int k) { return e_.phi[k]; },
      [&] {
        for (int k = 0; k < system_.contacts(); ++k) {
          auto& c = contacts_[k];
          if (!c.closed && !c.resting) continue;
          system_.contact(k, q, v, e_, c.row);
          // One that has left is an open contact like others.
          if (c.row.gap > closed_gap(k, q)) c.resting = false;
          const bool stays = c.resting && c.row.normal.dot(v) <= speed_tolerance_;
          if (c.closed || stays || c.row.gap < 0) rhs_[add(c.row.normal, nullptr, 0)] = c.row.gap;
        }
      });
  place(q, t);
  move(
      v, [&](int k) { return row_dot(system_.pattern(), e_.G.data(), k, v) + e_.phi_t[k]; },
      [&] {
        for (int k = 0; k < system_.contacts(); ++k) {
          auto& c = contacts_[k];
          if (!c.closed && !c.resting) continue;
          system_.contact(k, q, v, e_, c.row);
          const double rate = c.row.normal.dot(v);
          const auto want = [&](const SparseRow& row, double value, bool tangent) {
            rhs_[add(row, nullptr, 0)] = value;
            owners_.push_back({k, -1, tangent});
          };
          if (c.closed || rate <= speed_tolerance_) want(c.row.normal, rate, false);
          if (!c.closed) continue;
          if (c.slip == 0 && c.row.tangent.size > 0) want(c.row.tangent, c.row.tangent.dot(v), true);
        }
        for (int k = 0; k < system_.frictions(); ++k) {
          if (preloaded_[k].slip != 0) continue;
          system_.friction(k, q, v, e_, preloaded_[k].row);
          rhs_[add(preloaded_[k].row, nullptr, 0)] = preloaded_[k].row.dot(v);
          owners_.push_back({-1, k, true});
        }
      });
  stabilisation += system_.kinetic(v) + system_.potential(q) - before;
}

}  // namespace freeplay
