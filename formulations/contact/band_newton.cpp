#include "formulations/contact/band_newton.hpp"

#include <algorithm>
#include <cmath>

#include "formulations/contact/projections.hpp"

namespace freeplay {
namespace {

/// Number of operations of one factorisation above which sweeps are cheaper.
constexpr double most_operations = 3e7;

}  // namespace

int BandNewton::order(const SparseIsland& x) {
  const int rows = static_cast<int>(x.slots.size()), count = static_cast<int>(x.unknowns.size());
  unknown_.assign(rows, 0);
  for (int i = 0; i < count; ++i)
    for (const int row : {x.unknowns[i].normal, x.unknowns[i].tangent})
      if (row >= 0) unknown_[row] = i;
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
          if (int& mark = place_[unknown_[x.column[e]]]; mark == 0) {
            mark = 1;
            walk_.push_back(unknown_[x.column[e]]);
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

/// Computes F of the projections at the present impulses and, if requested, its derivative in the
/// band; returns |F|².
double BandNewton::project(const SparseIsland& x, bool with_derivative, double proximal) {
  struct Rows {
    const SparseIsland& x;
    BandNewton& in;
    double proximal, sum = 0;
    double rate(int r) const { return x.rate(r); }
    double impulse(int r) const { return x.impulse[r]; }
    double rho(int r) const {
      const double d = x.entry(r, r);
      return d > 0 ? 1 / d : 0;
    }
    double& at(int r, int s) { return in.band_.at(in.place_[r], in.place_[s]); }
    void value(int r, double f) {
      in.F_[r] = f;
      sum += f * f;
    }
    void follows(int r, double rho) {
      for (int e = x.begin[r]; e < x.begin[r + 1]; ++e) at(r, x.column[e]) = rho * x.value[e];
      at(r, r) += proximal;
    }
    void free(int r) { at(r, r) = 1; }
    void slides(int r, int n, double c) {
      free(r);
      at(r, n) = c;
    }
  } rows{x, *this, proximal};
  project_on_laws(x.unknowns, rows, with_derivative);
  return rows.sum;
}

SolverSummary BandNewton::solve(SparseIsland& x, double accepted, int most) {
  int steps = 0;
  const int rows = static_cast<int>(x.slots.size()), width = order(x);
  if (static_cast<double>(rows) * width * width > most_operations) return {};
  F_.resize(x.slots.size());
  step_.resize(x.slots.size());
  for (int i = 0; i < most; ++i) {
    ++steps;
    double before = 0;
    // for shared contact forces: the least change
    for (const double proximal : {0.0, 1e-9, 1e-6}) {
      band_.begin(rows, width);
      before = project(x, true, proximal);
      if (!std::isfinite(before)) return {false, steps};
      if (proximal == 0 && x.residual() <= std::max(accepted, x.attainable())) return {true, steps};
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
  return {x.residual() <= std::max(accepted, x.attainable()), steps};
}

bool BandNewton::hold(SparseIsland& x) {
  const int rows = static_cast<int>(x.slots.size()), width = order(x);
  if (static_cast<double>(rows) * width * width > most_operations) return false;
  step_.resize(x.slots.size());
  for (const double proximal : {0.0, 1e-9, 1e-6}) {
    band_.begin(rows, width);
    for (int r = 0; r < rows; ++r) {
      const double d = x.entry(r, r), rho = d > 0 ? 1 / d : 0;
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

}  // namespace freeplay
