// Islands of bodies that no joint holds, as discs in a box are: Gauss–Seidel in their velocities. With the impulses P so far
// the bodies' velocities have changed by
//
//     y = M⁻¹ Σ W P,     u = b + Wᵀ y
//
// so that a contact reads and changes those of its two bodies alone: 60 operations whatever else touches them, where D by
// rows has an entry for every contact of either (Jean, Comput. Methods Appl. Mech. Eng. 177 (1999) 235). Sweeps go to and
// fro, for weight is handed down through a pile in one that goes along with it.
//
// They find soon who presses, sticks and slides, and late how much. So between them Newton's method looks for the y with
//
//     M y = Σ W P(u),   P_N = (P_N⁰ − (u_N − target)/(δ D_NN))⁺,   P_T = clamp(P_T⁰ − (u_T − target)/(δ D_TT), ±(bound + μ P_N))
//
// about the impulses P⁰ so far, which are those of the problem where P = P⁰ (Rockafellar, Math. Oper. Res. 1 (1976) 97): δ makes
// forces unique that contacts share, and an error of the problem's is δ times as much in the next round. Its matrix has
// three rows a body, in a band along a breadth-first walk.
#include <algorithm>
#include <cmath>

#include "formulations/contact/contact_islands.hpp"

namespace freeplay {

/// free_ of an island; false where a joint holds one of its bodies.
bool ContactIslands::gather_free(const Island& x, const std::vector<SparseRow>& rows) {
  free_.clear();
  if (place_of_column_.empty()) place_of_column_.assign(island_of_cluster_.size(), -1);
  columns_.clear();
  bool all = true;
  for (const auto& u : x.unknowns) {
    Free f;
    const auto take = [&](int row, std::array<double, Free::most>& along) {
      if (row < 0) return;
      const auto& w = rows[x.slots[row]];
      for (int i = 0; i < w.size; ++i) {
        const int c = w.column[i];
        if (saddle_->part_of(c) >= 0) all = false;
        auto& place = place_of_column_[c];
        if (place < 0) {
          place = static_cast<int>(columns_.size());
          columns_.push_back(c);
        }
        int k = 0;
        while (k < f.size && f.column[k] != place) ++k;
        if (k == Free::most) {
          all = false;
          return;
        }
        if (k == f.size) {
          f.column[k] = place;
          f.mobility[k] = saddle_->free_mobility(c);
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
    free_.push_back(f);
  }
  for (const int c : columns_) place_of_column_[c] = -1;
  return all;
}

/// y of the present impulses.
void ContactIslands::sum_free(const Island& x) {
  y_.assign(columns_.size(), 0.0);
  for (std::size_t i = 0; i < free_.size(); ++i) {
    const auto& f = free_[i];
    const auto& u = x.unknowns[i];
    for (int k = 0; k < f.size; ++k)
      y_[f.column[k]] += f.mobility[k] * (f.normal[k] * u.impulse_n + f.tangent[k] * u.impulse_t);
  }
}

/// ContactProblem::residual with the rates that y gives.
double ContactIslands::residual_free(const Island& x) const {
  double worst = 0;
  const auto take = [&](double value) {
    if (!(std::abs(value) <= worst)) worst = std::isnan(value) ? INFINITY : std::abs(value);
  };
  for (std::size_t i = 0; i < free_.size(); ++i) {
    const auto& f = free_[i];
    const auto& c = x.unknowns[i];
    double un = f.bn, ut = f.bt;
    for (int k = 0; k < f.size; ++k) {
      un += f.normal[k] * y_[f.column[k]];
      ut += f.tangent[k] * y_[f.column[k]];
    }
    if (c.normal >= 0) take(std::min(f.nn * c.impulse_n, un - c.target_n));
    if (c.tangent < 0) continue;
    const double u = ut - c.target_t, bound = c.bound + c.friction * std::max(0.0, c.impulse_n);
    take(std::min(std::abs(u), f.tt * std::abs(c.impulse_t + std::copysign(bound, u))));
    take(f.tt * std::max(0.0, std::abs(c.impulse_t) - bound));
  }
  return worst;
}

namespace {

/// δ of one attempt after the other: the greater, the further away it may begin, and the more rounds it takes.
constexpr std::array deltas{1e-4, 1e-2, 1e-3};
/// Operations of one factorisation beyond which sweeps are the cheaper way.
constexpr double most_operations = 4e8;

}  // namespace

bool ContactIslands::sweep_free(Island& x, double accepted, int most) {
  sum_free(x);
  const int count = static_cast<int>(free_.size()), columns = static_cast<int>(columns_.size());
  double delta = 0;
  int attempts = 0;
  auto& before_newton = small_.unknowns;  // room for them
  int width = -1;                         // of the band, not known yet
  // Columns in the order of a breadth-first walk over bodies, begun at the end of another.
  const auto order = [&] {
    auto &begin = seen_, &of = next_;  // unknowns of each column
    begin.assign(static_cast<std::size_t>(columns) + 1, 0);
    for (const auto& f : free_)
      for (int k = 0; k < f.size; ++k) ++begin[f.column[k] + 1];
    for (int c = 0; c < columns; ++c) begin[c + 1] += begin[c];
    of.resize(static_cast<std::size_t>(begin[columns]));
    place_.assign(begin.begin(), begin.end());
    for (int i = 0; i < count; ++i)
      for (int k = 0; k < free_[i].size; ++k) of[place_[free_[i].column[k]]++] = i;
    int start = 0;
    for (int walk = 0; walk < 2; ++walk) {
      place_.assign(static_cast<std::size_t>(columns), -1);
      walk_.assign(1, start);
      place_[start] = 0;
      for (std::size_t n = 0; n < walk_.size(); ++n)
        for (int e = begin[walk_[n]]; e < begin[walk_[n] + 1]; ++e)
          for (int k = 0; k < free_[of[e]].size; ++k)
            if (const int c = free_[of[e]].column[k]; place_[c] < 0) {
              place_[c] = static_cast<int>(walk_.size());
              walk_.push_back(c);
            }
      start = walk_.back();
    }
    width = 0;
    for (const auto& f : free_)
      for (int k = 0; k < f.size; ++k)
        for (int l = 0; l < k; ++l)
          width = std::max(width, std::abs(place_[f.column[k]] - place_[f.column[l]]));
    if (static_cast<int>(walk_.size()) < columns || 2.0 * columns * width * width > most_operations)
      width = columns;
    u_.assign(static_cast<std::size_t>(columns), 0.0);  // masses
    for (const auto& f : free_)
      for (int k = 0; k < f.size; ++k) u_[f.column[k]] = f.mobility[k] > 0 ? 1 / f.mobility[k] : 0;
  };
  // The impulses that y gives about P⁰ in P_: F = M y − Σ W P, its Jacobian where asked for; the greatest rate that F is.
  const auto evaluate = [&](bool with_jacobian) {
    F_.resize(static_cast<std::size_t>(columns));
    for (int c = 0; c < columns; ++c) F_[c] = u_[c] * y_[c];
    if (with_jacobian) {
      band_.begin(columns, width);
      for (int c = 0; c < columns; ++c) band_.at(place_[c], place_[c]) = u_[c];
    }
    for (int i = 0; i < count; ++i) {
      const auto& f = free_[i];
      auto& c = x.unknowns[i];
      double un = f.bn, ut = f.bt;
      for (int k = 0; k < f.size; ++k) {
        un += f.normal[k] * y_[f.column[k]];
        ut += f.tangent[k] * y_[f.column[k]];
      }
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
          band_.at(place_[f.column[k]], place_[f.column[l]]) += by_n * f.normal[l] + by_t * f.tangent[l];
      }
    }
    double worst = 0;
    for (int c = 0; c < columns; ++c)
      if (u_[c] > 0) worst = std::max(worst, std::abs(F_[c]) / u_[c]);
    return worst;
  };
  const auto newton = [&] {
    if (width < 0) order();
    if (width >= columns) return false;
    delta = deltas[static_cast<std::size_t>(attempts++) % deltas.size()];
    P_.resize(2 * free_.size());
    step_.resize(static_cast<std::size_t>(columns));
    double before = residual_free(x);
    for (int round = 0; round < 20; ++round) {
      before_newton = x.unknowns;
      for (int i = 0; i < count; ++i) {
        P_[2 * i] = x.unknowns[i].impulse_n;
        P_[2 * i + 1] = x.unknowns[i].impulse_t;
      }
      double off = INFINITY, first = 0;
      // Near the solution one step or two meet it; where they do not, sweeps come nearer at less cost.
      for (int i = 0;
           i < 12 && off > std::max(0.01 * accepted, 1e-7 * first) && !(i > 1 && off > 0.1 * first); ++i) {
        ++x.found.pivots;
        const double from = evaluate(true);
        if (!std::isfinite(from)) break;
        if (i == 0) first = from;
        if (!band_.factor(0)) break;
        for (int c = 0; c < columns; ++c) step_[place_[c]] = -F_[c];
        band_.solve(step_.data());
        double share = 1, taken = 0;
        for (int k = 0; k < 4; ++k, share *= 0.5) {
          for (int c = 0; c < columns; ++c) y_[c] += (share - taken) * step_[place_[c]];
          taken = share;
          off = evaluate(false);
          if (off < from) break;
        }
      }
      sum_free(x);
      const double left = residual_free(x);
      if (left <= accepted) return true;
      if (!(left < 0.7 * before)) {  // no nearer: sweeps have a better place to go on from
        if (!(left < before)) x.unknowns = before_newton;
        sum_free(x);
        return false;
      }
      before = left;
    }
    return false;
  };
  int next = 50;  // sweep before which Newton's method is tried
  for (int sweep = 0; sweep < most; ++sweep) {
    if (sweep == next) {
      if (newton()) return true;
      next += std::min(next, 400);
    }
    ++x.found.pivots;
    double moved = 0;
    for (int n = 0; n < count; ++n) {
      const int i = sweep % 2 == 0 ? n : count - 1 - n;
      const auto& f = free_[i];
      auto& c = x.unknowns[i];
      const double Pn = c.impulse_n, Pt = c.impulse_t;
      double un = f.bn, ut = f.bt;
      for (int k = 0; k < f.size; ++k) {
        const double y = y_[f.column[k]];
        un += f.normal[k] * y;
        ut += f.tangent[k] * y;
      }
      if (c.normal >= 0 && Pn == 0 && Pt == 0 && un >= c.target_n && c.bound == 0)
        continue;  // open, and stays so
      if (!ContactProblem::solve_one(c, un - f.nn * Pn - f.nt * Pt, ut - f.nt * Pn - f.tt * Pt, f.nn, f.nt,
                                     f.tt))
        return false;
      const double dn = c.impulse_n - Pn, dt = c.impulse_t - Pt;
      moved = std::max({moved, f.nn * std::abs(dn), f.tt * std::abs(dt)});
      for (int k = 0; k < f.size; ++k)
        y_[f.column[k]] += f.mobility[k] * (f.normal[k] * dn + f.tangent[k] * dt);
    }
    if (!(moved <= accepted) && sweep % 20 != 19) continue;
    sum_free(x);  // without what rounding has left
    if (residual_free(x) <= accepted) return true;
    if (!std::isfinite(moved)) return false;
  }
  return false;
}

}  // namespace freeplay
