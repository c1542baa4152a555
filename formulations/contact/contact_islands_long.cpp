// Islands of many contacts: Newton's method with band factors, and Gauss–Seidel over D by rows.
#include <algorithm>
#include <cmath>

#include "formulations/contact/contact_islands.hpp"

namespace freeplay {
namespace {

/// Operations of one factorisation beyond which sweeps are the cheaper way.
constexpr double most_operations_of_long_islands = 3e7;
/// Unknowns of an island of loose bodies beyond which dense matrices are no way out.
constexpr int most_loose = 64;
/// Half-bandwidth of D, in rows, up to which loose bodies hang in a chain: Newton's method meets it in a few steps, where
/// sweeps hand what happens at one end down a link at a time.
constexpr int most_narrow = 16;

}  // namespace

double ContactIslands::attainable(const Island& x) {
  double most = 0;
  for (std::size_t r = 0; r + 1 < x.begin.size(); ++r) {
    double sum = std::abs(x.b[r]);
    for (int e = x.begin[r]; e < x.begin[r + 1]; ++e) sum += std::abs(x.value[e] * x.impulse[x.column[e]]);
    most = std::max(most, sum);
  }
  return 1e-13 * most;
}

/// ContactProblem::residual of the present impulses.
double ContactIslands::residual(const Island& x) {
  double worst = 0;
  const auto take = [&](double value) {
    if (!(std::abs(value) <= worst)) worst = std::isnan(value) ? INFINITY : std::abs(value);
  };
  for (const auto& c : x.unknowns) {
    const double pressed = c.normal >= 0 ? x.impulse[c.normal] : 0;
    if (c.normal >= 0)
      take(std::min(entry(x, c.normal, c.normal) * pressed, rate_of(x, c.normal) - c.target_n));
    if (c.tangent < 0) continue;
    const double u = rate_of(x, c.tangent) - c.target_t, Dtt = entry(x, c.tangent, c.tangent),
                 rubbed = x.impulse[c.tangent], bound = c.bound + c.friction * std::max(0.0, pressed);
    take(std::min(std::abs(u), Dtt * std::abs(rubbed + std::copysign(bound, u))));
    take(Dtt * std::max(0.0, std::abs(rubbed) - bound));
  }
  return worst;
}

/// place_ of each row in the order of a breadth-first walk over unknowns, begun at the end of another; the half-bandwidth.
int ContactIslands::order_rows(const Island& x) {
  const int rows = static_cast<int>(x.slots.size()), count = static_cast<int>(x.unknowns.size());
  seen_.assign(rows, 0);  // the unknown of each row
  for (int i = 0; i < count; ++i)
    for (const int row : {x.unknowns[i].normal, x.unknowns[i].tangent})
      if (row >= 0) seen_[row] = i;
  place_.resize(std::max(count, rows));
  int start = 0;
  for (int walk = 0; walk < 2; ++walk) {
    std::fill_n(place_.begin(), count, 0);
    walk_.assign(1, start);
    place_[start] = 1;
    for (std::size_t k = 0; k < walk_.size(); ++k) {
      const auto& u = x.unknowns[walk_[k]];
      for (const int row : {u.normal, u.tangent})
        for (int e = row >= 0 ? x.begin[row] : 0; row >= 0 && e < x.begin[row + 1]; ++e)
          if (int& mark = place_[seen_[x.column[e]]]; mark == 0) {
            mark = 1;
            walk_.push_back(seen_[x.column[e]]);
          }
    }
    start = walk_.back();
  }
  int at = 0;
  for (const int i : walk_)
    for (const int row : {x.unknowns[i].normal, x.unknowns[i].tangent})
      if (row >= 0) place_[row] = at++;
  int width = 0;
  for (int r = 0; r < rows; ++r)
    for (int e = x.begin[r]; e < x.begin[r + 1]; ++e)
      width = std::max(width, std::abs(place_[r] - place_[x.column[e]]));
  return at == rows ? width : rows;
}

/// F of the projections at the present impulses and, where asked for, its Jacobian in the band; |F|².
double ContactIslands::project(const Island& x, bool with_jacobian, double proximal) {
  double sum = 0;
  const auto fill = [&](int row, double rho) {
    for (int e = x.begin[row]; e < x.begin[row + 1]; ++e)
      band_.at(place_[row], place_[x.column[e]]) = rho * x.value[e];
    band_.at(place_[row], place_[row]) += proximal;
  };
  for (const auto& c : x.unknowns) {
    const int n = c.normal, t = c.tangent;
    double pressed = 0;
    if (n >= 0) {
      const double d = entry(x, n, n), rho = d > 0 ? 1 / d : 0;
      pressed = x.impulse[n];
      const double trial = d > 0 ? pressed - rho * (rate_of(x, n) - c.target_n) : 0;
      F_[n] = pressed - std::max(0.0, trial);
      if (with_jacobian && trial > 0)
        fill(n, rho);
      else if (with_jacobian)
        band_.at(place_[n], place_[n]) = 1;
      sum += F_[n] * F_[n];
    }
    if (t < 0) continue;
    const double d = entry(x, t, t), rho = d > 0 ? 1 / d : 0,
                 bound = c.bound + c.friction * std::max(0.0, pressed);
    const double trial = d > 0 ? x.impulse[t] - rho * (rate_of(x, t) - c.target_t) : 0;
    const double kept = std::clamp(trial, -bound, bound);
    F_[t] = x.impulse[t] - kept;
    sum += F_[t] * F_[t];
    if (!with_jacobian) continue;
    if (kept == trial && d > 0) {
      fill(t, rho);
    } else {
      band_.at(place_[t], place_[t]) = 1;
      if (n >= 0 && pressed > 0) band_.at(place_[t], place_[n]) = trial > 0 ? -c.friction : c.friction;
    }
  }
  return sum;
}

bool ContactIslands::newton(Island& x, double accepted, int most) {
  const int rows = static_cast<int>(x.slots.size()), width = order_rows(x);
  if (static_cast<double>(rows) * width * width > most_operations_of_long_islands) return false;
  F_.resize(x.slots.size());
  step_.resize(x.slots.size());
  for (int i = 0; i < most; ++i) {
    ++x.found.pivots;
    double before = 0;
    for (const double proximal : {0.0, 1e-9, 1e-6}) {  // forces that contacts share: the least change of them
      band_.begin(rows, width);
      before = project(x, true, proximal);
      if (!std::isfinite(before)) return false;
      if (proximal == 0 && residual(x) <= std::max(accepted, attainable(x))) return true;
      if (band_.factor(1e-11)) break;
    }
    for (int r = 0; r < rows; ++r) step_[place_[r]] = -F_[r];
    band_.solve(step_.data());
    P_ = x.impulse;
    double share = 1;
    for (int k = 0; k < 12; ++k, share *= 0.5) {
      for (int r = 0; r < rows; ++r) x.impulse[r] = P_[r] + share * step_[place_[r]];
      if (project(x, false, 0) < before) break;
    }
  }
  return residual(x) <= std::max(accepted, attainable(x));
}

bool ContactIslands::hold(Island& x) {
  const int rows = static_cast<int>(x.slots.size()), width = order_rows(x);
  if (static_cast<double>(rows) * width * width > most_operations_of_long_islands) return false;
  step_.resize(x.slots.size());
  for (const double proximal : {0.0, 1e-9, 1e-6}) {
    band_.begin(rows, width);
    for (int r = 0; r < rows; ++r) {
      const double d = entry(x, r, r), rho = d > 0 ? 1 / d : 0;
      for (int e = x.begin[r]; e < x.begin[r + 1]; ++e)
        band_.at(place_[r], place_[x.column[e]]) = rho * x.value[e];
      band_.at(place_[r], place_[r]) += d > 0 ? proximal : 1;
      step_[place_[r]] = -rho * x.b[r];
    }
    if (!band_.factor(1e-11)) continue;
    band_.solve(step_.data());
    x.impulse.resize(x.slots.size());
    for (int r = 0; r < rows; ++r) x.impulse[r] = step_[place_[r]];
    return std::ranges::all_of(x.impulse, [](double impulse) { return std::isfinite(impulse); });
  }
  return false;
}

bool ContactIslands::gauss_seidel(Island& x, double accepted, int most) {
  u_.resize(x.slots.size());
  for (std::size_t r = 0; r < u_.size(); ++r) u_[r] = rate_of(x, static_cast<int>(r));
  const auto change = [&](int row, double by) {  // D is symmetric
    if (row < 0 || by == 0) return;
    x.impulse[row] += by;
    for (int e = x.begin[row]; e < x.begin[row + 1]; ++e) u_[x.column[e]] += by * x.value[e];
  };
  for (int sweep = 0; sweep < most; ++sweep) {
    ++x.found.pivots;
    double moved = 0;
    for (auto& c : x.unknowns) {
      const int n = c.normal, t = c.tangent;
      const double Pn = n >= 0 ? x.impulse[n] : 0, Pt = t >= 0 ? x.impulse[t] : 0,
                   Dnn = n >= 0 ? entry(x, n, n) : 0, Dtt = t >= 0 ? entry(x, t, t) : 0,
                   Dnt = n >= 0 && t >= 0 ? entry(x, n, t) : 0;
      const double bn = n >= 0 ? u_[n] - Dnn * Pn - Dnt * Pt : 0,
                   bt = t >= 0 ? u_[t] - Dtt * Pt - Dnt * Pn : 0;
      if (!ContactProblem::solve_one(c, bn, bt, Dnn, Dnt, Dtt)) return false;
      change(n, c.impulse_n - Pn);
      change(t, c.impulse_t - Pt);
      moved = std::max({moved, Dnn * std::abs(c.impulse_n - Pn), Dtt * std::abs(c.impulse_t - Pt)});
    }
    if (moved <= 0.1 * accepted && residual(x) <= accepted) return true;
  }
  return false;
}

void ContactIslands::solve_long(Island& x, ContactProblem& whole, const std::vector<SparseRow>& rows) {
  x.found = {};
  const double size = whole.scale(), accepted = tolerance_ * size;
  gather(x);
  given_ = x.impulse;
  const auto restart = [&] { std::ranges::fill(x.impulse, 0.0); };
  bool solved = false;
  double best_rate = 1e-6 * size;  // rounding may keep all from the tolerance: less is owed than nothing
  best_.clear();
  const auto attempt = [&](auto way) {
    if (solved) return;
    solved = way();
    if (solved) return;
    ++x.found.retries;
    if (const double left = residual(x); left < best_rate) {
      best_rate = left;
      best_ = x.impulse;
    }
  };
  const bool loose = gather_free(x, rows), heap = loose && static_cast<int>(x.unknowns.size()) > most_loose;
  if (loose) {
    if (heap) best_rate = 1e-3 * size;  // nothing else would come nearer in its time; the run says how near
    if (order_rows(x) <= most_narrow) {
      attempt([&] { return newton(x, accepted, 20); });
      if (!solved) x.impulse = given_;
    }
    attempt([&] {
      const bool met =
          sweep_free(x, accepted, static_cast<int>(x.unknowns.size()) > most_whole ? 4000 : 20000);
      gather(x);
      return met;
    });
  }
  if (solver_ == LcpSolver::gauss_seidel) attempt([&] { return gauss_seidel(x, accepted, 2000); });
  attempt([&] { return newton(x, accepted, 20); });
  if (!heap) {
    attempt([&] {
      x.impulse = given_;
      return gauss_seidel(x, accepted, 5000);
    });
    attempt([&] {
      restart();
      return newton(x, accepted, 100);
    });
  }
  if (!solved && !heap && static_cast<int>(x.unknowns.size()) <= most_whole) {
    const int pivots = x.found.pivots, retries = x.found.retries;
    solve_small(x, whole);
    x.found.pivots += pivots;
    x.found.retries += retries;
    if (x.found.solved) return;
  }
  if (!solved && !best_.empty()) {
    x.impulse = best_;
    solved = true;
  }
  x.found.solved = solved;
  x.found.residual_rate = residual(x);
  x.found.residual = size > 0 ? x.found.residual_rate / size : x.found.residual_rate;
  x.doubtful = false;
  for (auto& c : x.unknowns) {
    c.impulse_n = c.normal >= 0 ? x.impulse[c.normal] : 0;
    c.impulse_t = c.tangent >= 0 ? x.impulse[c.tangent] : 0;
    if (c.normal >= 0 && c.tangent >= 0 && c.impulse_n > 0)
      x.doubtful |= entry(x, c.normal, c.normal) <= c.friction * std::abs(entry(x, c.normal, c.tangent));
  }
  x.found.undecided = x.doubtful;
}

}  // namespace freeplay
