#include "formulations/contact/free_sweeps.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "formulations/contact/newton.hpp"

namespace freeplay {
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

/// A proximal point with this δ, about the present impulses.
class FreeSweeps::ProximalPoint {
 public:
  ProximalPoint(FreeSweeps& in, SparseIsland& x, double delta, double accepted)
      : in_(in), x_(x), delta_(delta), negligible_(0.1 * accepted) {
    for (std::size_t i = 0; i < in_.contacts_.size(); ++i) {
      in_.P_[2 * i] = x.unknowns[i].impulse_n;
      in_.P_[2 * i + 1] = x.unknowns[i].impulse_t;
    }
  }

  double evaluate(bool with_jacobian);
  bool solved() const { return size_ <= 1e-2 * first_ || greatest_ <= negligible_; }
  bool find_step() {
    if (!in_.jacobian_.factor(0)) return false;
    std::ranges::transform(in_.F_, in_.step_.begin(), std::negate());
    in_.jacobian_.solve(in_.step_.data());
    in_.y_before_ = in_.y_;
    return true;
  }
  void move(double share) {
    for (std::size_t c = 0; c < in_.y_.size(); ++c) in_.y_[c] = in_.y_before_[c] + share * in_.step_[c];
  }

 private:
  FreeSweeps& in_;
  SparseIsland& x_;
  double delta_, negligible_;
  double first_ = -1, size_ = 0, greatest_ = 0;  // √(Fᵀ M⁻¹ F) at first and now; greatest |F| as a rate
};

/// Computes the impulses at y, F = M y − Σ W P and, if requested, its Jacobian.
double FreeSweeps::ProximalPoint::evaluate(bool with_jacobian) {
  const auto& y = in_.y_;
  auto &F = in_.F_, &J = in_.jacobian_.values();
  const int count = static_cast<int>(in_.contacts_.size()), columns = static_cast<int>(y.size());
  F.resize(y.size());
  for (int c = 0; c < columns; ++c) F[c] = in_.mass_[c] * y[c];
  if (with_jacobian) {
    std::ranges::fill(J, 0.0);
    for (int c = 0; c < columns; ++c) J[in_.diagonal_[c]] = in_.mass_[c];
  }
  for (int i = 0; i < count; ++i) {
    const auto& f = in_.contacts_[i];
    auto& c = x_.unknowns[i];
    const auto [un, ut] = f.rates(y);
    const double gn = c.normal >= 0 && f.nn > 0 ? 1 / (delta_ * f.nn) : 0,
                 gt = c.tangent >= 0 && f.tt > 0 ? 1 / (delta_ * f.tt) : 0;
    const double zn = in_.P_[2 * i] - gn * (un - c.target_n), zt = in_.P_[2 * i + 1] - gt * (ut - c.target_t);
    c.impulse_n = c.normal >= 0 ? std::max(0.0, zn) : 0;
    const double bound = c.bound + c.friction * c.impulse_n;
    c.impulse_t = c.tangent >= 0 ? std::clamp(zt, -bound, bound) : 0;
    if (c.impulse_n == 0 && c.impulse_t == 0) continue;
    for (int k = 0; k < f.size; ++k) F[f.column[k]] -= f.normal[k] * c.impulse_n + f.tangent[k] * c.impulse_t;
    if (!with_jacobian) continue;
    const bool sticks = c.tangent >= 0 && c.impulse_t == zt;
    const double nn = c.impulse_n > 0 ? gn : 0, tt = sticks ? gt : 0,
                 tn = c.tangent >= 0 && !sticks ? (zt > 0 ? c.friction : -c.friction) * nn : 0;
    for (int k = 0; k < f.size; ++k) {
      const double by_n = f.normal[k] * nn + f.tangent[k] * tn, by_t = f.tangent[k] * tt;
      for (int l = 0; l < f.size; ++l)
        J[in_.entries_[(i * Contact::most + k) * Contact::most + l]] +=
            by_n * f.normal[l] + by_t * f.tangent[l];
    }
  }
  double squares = 0;
  greatest_ = 0;
  for (int c = 0; c < columns; ++c) {
    if (!(in_.mass_[c] > 0)) continue;
    squares += F[c] * F[c] / in_.mass_[c];
    greatest_ = std::max(greatest_, std::abs(F[c]) / in_.mass_[c]);
  }
  size_ = std::sqrt(squares);
  if (first_ < 0) first_ = size_;
  return size_;
}

/// Proximal points from the present impulses.
bool FreeSweeps::newton(SparseIsland& x, double accepted, int& steps) {
  constexpr int most = 150, most_of_round = 5, halvings = 6, few = 3, many = 5;
  constexpr double least_delta = 1e-5, greatest_delta = 3;
  P_.resize(2 * contacts_.size());
  step_.resize(columns_.size());
  double delta = 0.1;
  for (const int end = steps + most; steps < end;) {
    before_ = x.unknowns;
    ProximalPoint point(*this, x, delta, accepted);
    const auto found = newton_steps(point, most_of_round, halvings);
    steps += found.iterations;
    const bool solved = found.solved || point.solved();
    if (!solved) x.unknowns = before_;
    sum(x);
    if (!solved)
      delta = std::min(4 * delta, greatest_delta);
    else if (residual(x) <= accepted)
      return true;
    else if (found.iterations <= few)
      delta = std::max(0.4 * delta, least_delta);
    else if (found.iterations >= many)
      delta *= 1.5;
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
  int done = 0, next = 100;  // next: sweep before which Newton's method is tried
  for (int n = 0; n < most; ++n) {
    if (n == next) {
      if (n == 100) analyse();
      if (newton(x, accepted, done)) return {true, done};
      next *= 4;
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
