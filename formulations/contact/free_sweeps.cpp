#include "formulations/contact/free_sweeps.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {
namespace {

/// δ of successive attempts. A greater δ converges from further away but takes more rounds.
constexpr std::array deltas{1e-4, 1e-2, 1e-3};

}  // namespace

bool FreeSweeps::gather(const SparseIsland& x, const std::vector<SparseRow>& rows, const SaddlePoint& saddle,
                        int columns) {
  contacts_.clear();
  if (place_of_column_.empty()) place_of_column_.assign(static_cast<std::size_t>(columns), -1);
  columns_.clear();
  bool all = true;
  for (const auto& u : x.unknowns) {
    Contact f;
    const auto take = [&](int row, std::array<double, Contact::most>& along) {
      if (row < 0) return;
      const auto& w = rows[x.slots[row]];
      for (int i = 0; i < w.size; ++i) {
        const int c = w.column[i];
        if (saddle.part_of(c) >= 0) all = false;
        auto& place = place_of_column_[c];
        if (place < 0) {
          place = static_cast<int>(columns_.size());
          columns_.push_back(c);
        }
        int k = 0;
        while (k < f.size && f.column[k] != place) ++k;
        if (k == Contact::most) {
          all = false;
          return;
        }
        if (k == f.size) {
          f.column[k] = place;
          f.mobility[k] = saddle.free_mobility(c);
          ++f.size;
        }
        along[k] += w.value[i];
      }
    };
    take(u.normal, f.normal);
    take(u.tangent, f.tangent);
    for (int k = 0; k < f.size; ++k) {
      f.nn += f.normal[k] * f.normal[k] * f.mobility[k];
      f.nt += f.normal[k] * f.tangent[k] * f.mobility[k];
      f.tt += f.tangent[k] * f.tangent[k] * f.mobility[k];
    }
    f.bn = u.normal >= 0 ? x.b[u.normal] : 0;
    f.bt = u.tangent >= 0 ? x.b[u.tangent] : 0;
    contacts_.push_back(f);
  }
  for (const int c : columns_) place_of_column_[c] = -1;
  return all;
}

/// Computes y of the present impulses anew, without accumulated rounding.
void FreeSweeps::sum(const SparseIsland& x) {
  y_.assign(columns_.size(), 0.0);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const auto& f = contacts_[i];
    const auto& u = x.unknowns[i];
    for (int k = 0; k < f.size; ++k)
      y_[f.column[k]] += f.mobility[k] * (f.normal[k] * u.impulse_n + f.tangent[k] * u.impulse_t);
  }
}

/// contact_residual() with the rates at y.
double FreeSweeps::residual(const SparseIsland& x) const {
  return contact_residual(
      x.unknowns,
      [&](std::size_t i) {
        const auto& f = contacts_[i];
        return RowState{f.rates(y_)[0], f.nn, x.unknowns[i].impulse_n};
      },
      [&](std::size_t i) {
        const auto& f = contacts_[i];
        return RowState{f.rates(y_)[1], f.tt, x.unknowns[i].impulse_t};
      });
}

/// Computes the pattern of the Jacobian, its entries of each contact, and the masses.
void FreeSweeps::analyse() {
  const int count = static_cast<int>(contacts_.size()), columns = static_cast<int>(columns_.size());
  mass_.assign(static_cast<std::size_t>(columns), 0.0);
  auto& [first, of, at, next, begin, column] = lists_;
  first.assign(static_cast<std::size_t>(columns) + 1, 0);
  at.assign(first.size(), -1);
  begin.assign(1, 0);
  column.clear();
  for (const auto& f : contacts_)
    for (int k = 0; k < f.size; ++k) {
      ++first[f.column[k] + 1];
      mass_[f.column[k]] = f.mobility[k] > 0 ? 1 / f.mobility[k] : 0;
    }
  for (int c = 0; c < columns; ++c) first[c + 1] += first[c];
  of.resize(static_cast<std::size_t>(first[columns]));
  next = first;
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < contacts_[i].size; ++k) of[next[contacts_[i].column[k]]++] = i * Contact::most + k;
  entries_.resize(contacts_.size() * Contact::most * Contact::most);
  diagonal_.resize(static_cast<std::size_t>(columns));
  for (int c = 0; c < columns; ++c) {
    for (int e = first[c]; e < first[c + 1]; ++e) {
      const auto& f = contacts_[of[e] / Contact::most];
      for (int l = 0; l < f.size; ++l) {
        int& place = at[f.column[l]];
        if (place < begin.back()) {
          place = static_cast<int>(column.size());
          column.push_back(f.column[l]);
        }
        entries_[of[e] * Contact::most + l] = place;
      }
    }
    diagonal_[c] = at[c];
    begin.push_back(static_cast<int>(column.size()));
  }
  jacobian_.analyse(begin, column);
}

/// Computes the impulses at y about P⁰ in P_, F = M y − Σ W P and, if requested, its Jacobian.
/// Returns the greatest |F| as a rate.
double FreeSweeps::evaluate(SparseIsland& x, double delta, bool with_jacobian) {
  const int count = static_cast<int>(contacts_.size()), columns = static_cast<int>(columns_.size());
  F_.resize(static_cast<std::size_t>(columns));
  for (int c = 0; c < columns; ++c) F_[c] = mass_[c] * y_[c];
  if (with_jacobian) {
    std::ranges::fill(jacobian_.values(), 0.0);
    for (int c = 0; c < columns; ++c) jacobian_.values()[diagonal_[c]] = mass_[c];
  }
  for (int i = 0; i < count; ++i) {
    const auto& f = contacts_[i];
    auto& c = x.unknowns[i];
    const auto [un, ut] = f.rates(y_);
    const double gn = c.normal >= 0 && f.nn > 0 ? 1 / (delta * f.nn) : 0,
                 gt = c.tangent >= 0 && f.tt > 0 ? 1 / (delta * f.tt) : 0;
    const double zn = P_[2 * i] - gn * (un - c.target_n), zt = P_[2 * i + 1] - gt * (ut - c.target_t);
    c.impulse_n = c.normal >= 0 ? std::max(0.0, zn) : 0;
    const double bound = c.bound + c.friction * c.impulse_n;
    c.impulse_t = c.tangent >= 0 ? std::clamp(zt, -bound, bound) : 0;
    if (c.impulse_n == 0 && c.impulse_t == 0) continue;
    for (int k = 0; k < f.size; ++k)
      F_[f.column[k]] -= f.normal[k] * c.impulse_n + f.tangent[k] * c.impulse_t;
    if (!with_jacobian) continue;
    const bool sticks = c.tangent >= 0 && c.impulse_t == zt;
    const double nn = c.impulse_n > 0 ? gn : 0, tt = sticks ? gt : 0,
                 tn = c.tangent >= 0 && !sticks ? (zt > 0 ? c.friction : -c.friction) * nn : 0;
    for (int k = 0; k < f.size; ++k) {
      const double by_n = f.normal[k] * nn + f.tangent[k] * tn, by_t = f.tangent[k] * tt;
      for (int l = 0; l < f.size; ++l)
        jacobian_.values()[entries_[(i * Contact::most + k) * Contact::most + l]] +=
            by_n * f.normal[l] + by_t * f.tangent[l];
    }
  }
  double worst = 0;
  for (int c = 0; c < columns; ++c)
    if (mass_[c] > 0) worst = std::max(worst, std::abs(F_[c]) / mass_[c]);
  return worst;
}

/// Newton steps about the present impulses. Near the solution one or two are enough; if they are
/// not, sweeps approach the solution at less cost.
void FreeSweeps::newton_round(SparseIsland& x, double accepted, double delta, int& steps) {
  const int columns = static_cast<int>(columns_.size());
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    P_[2 * i] = x.unknowns[i].impulse_n;
    P_[2 * i + 1] = x.unknowns[i].impulse_t;
  }
  double off = INFINITY, first = 0;
  for (int i = 0; i < 12 && off > std::max(accepted, 1e-7 * first) && !(i > 1 && off > 0.1 * first); ++i) {
    ++steps;
    const double from = evaluate(x, delta, true);
    if (!std::isfinite(from)) return;
    if (i == 0) first = from;
    if (!jacobian_.factor(0)) return;
    for (int c = 0; c < columns; ++c) step_[c] = -F_[c];
    jacobian_.solve(step_.data());
    double share = 1, taken = 0;
    for (int k = 0; k < 4; ++k, share *= 0.5) {
      for (int c = 0; c < columns; ++c) y_[c] += (share - taken) * step_[c];
      taken = share;
      off = evaluate(x, delta, false);
      if (off < from) break;
    }
  }
}

bool FreeSweeps::newton(SparseIsland& x, double accepted, double delta, int& steps) {
  P_.resize(2 * contacts_.size());
  step_.resize(columns_.size());
  double before = residual(x);
  for (int round = 0; round < 20; ++round) {
    before_newton_ = x.unknowns;
    newton_round(x, accepted, delta, steps);
    sum(x);
    const double left = residual(x);
    if (left <= accepted) return true;
    if (!(left < 0.7 * before)) {  // no progress: continue with sweeps from the better impulses
      if (!(left < before)) x.unknowns = before_newton_;
      sum(x);
      return false;
    }
    before = left;
  }
  return false;
}

/// One sweep: solves each contact exactly with all others fixed. Returns false if friction admits
/// no impulse.
bool FreeSweeps::sweep(SparseIsland& x, bool back, double& moved) {
  const int count = static_cast<int>(contacts_.size());
  for (int n = 0; n < count; ++n) {
    const int i = back ? count - 1 - n : n;
    const auto& f = contacts_[i];
    auto& c = x.unknowns[i];
    const double Pn = c.impulse_n, Pt = c.impulse_t;
    const auto [un, ut] = f.rates(y_);
    if (c.normal >= 0 && Pn == 0 && Pt == 0 && un >= c.target_n && c.bound == 0)
      continue;  // open, and stays open
    if (!solve_one(c, un - f.nn * Pn - f.nt * Pt, ut - f.nt * Pn - f.tt * Pt, f.nn, f.nt, f.tt)) return false;
    const double dn = c.impulse_n - Pn, dt = c.impulse_t - Pt;
    moved = std::max({moved, f.nn * std::abs(dn), f.tt * std::abs(dt)});
    for (int k = 0; k < f.size; ++k)
      y_[f.column[k]] += f.mobility[k] * (f.normal[k] * dn + f.tangent[k] * dt);
  }
  return true;
}

SolverSummary FreeSweeps::solve(SparseIsland& x, double accepted, int most) {
  sum(x);
  bool analysed = false;
  int done = 0, next = 50;  // next: sweep before which Newton's method is tried
  std::size_t attempts = 0;
  for (int n = 0; n < most; ++n) {
    if (n == next) {
      if (!analysed) analyse();
      analysed = true;
      if (newton(x, accepted, deltas[attempts++ % deltas.size()], done)) return {true, done};
      next += std::min(next, 400);
    }
    ++done;
    double moved = 0;
    if (!sweep(x, n % 2 != 0, moved)) return {false, done};
    if (!(moved <= accepted) && n % 20 != 19) continue;
    sum(x);
    if (residual(x) <= accepted) return {true, done};
    if (!std::isfinite(moved)) return {false, done};
  }
  return {false, done};
}

}  // namespace freeplay
