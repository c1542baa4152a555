// Traces the factorisation and the solution of a SaddlePoint with dense blocks (solve_functions.hpp).
// Operations and their order are those of saddle_block.cpp and saddle_point.cpp; terms that are
// always zero vanish, so that the elimination is sparse.
#include <cmath>

#include "numerics/saddle_point.hpp"

namespace freeplay {
namespace {

/// The lower triangle of a block's factors, by columns.
struct Factors {
  std::vector<Traced> L;
  std::size_t m = 0;
  Traced& at(std::size_t i, std::size_t j) { return L[i + j * m]; }
};

/// Cholesky factorisation of S as in saddle_block.cpp. `ratios` gets the ratios of pivots to
/// diagonals that are not 1.
void cholesky(Factors& S, std::vector<Traced>& ratios) {
  for (std::size_t j = 0; j < S.m; ++j) {
    const Traced diagonal = S.at(j, j);
    Traced pivot = diagonal;
    for (std::size_t k = 0; k < j; ++k) pivot -= S.at(j, k) * S.at(j, k);
    bool regular = diagonal > Traced(0);
    if (pivot.node != diagonal.node) {
      const Traced ratio = pivot / diagonal;
      regular = ratio >= Traced(lossy_pivot) && regular;
      ratios.push_back(ratio);
    }
    if (!regular) throw NotTraceable("the constraint rows are nearly dependent at the start");
    const Traced root = sqrt(pivot);
    S.at(j, j) = root;
    for (std::size_t i = j + 1; i < S.m; ++i) {
      Traced x = S.at(i, j);
      for (std::size_t k = 0; k < j; ++k) x -= S.at(i, k) * S.at(j, k);
      S.at(i, j) = x / root;
    }
  }
}

}  // namespace

bool SaddlePoint::trace(TracedObject& object, std::span<const double> G_values,
                        const std::vector<bool>& constant, int& factors, std::vector<int>& ratios) const {
  for (const auto& part : parts_)
    if (!part.block.dense()) return false;
  std::vector<Factors> blocks;
  const auto matrix = [&](Trace& trace, int array) {
    auto G = trace.inputs(array, G_values);
    for (std::size_t e = 0; e < G.size(); ++e)
      if (constant[e]) G[e] = G_values[e];
    return G;
  };

  std::vector<Traced> all_ratios;
  {
    Trace trace(object, "factor");
    const auto G = matrix(trace, 0);
    for (const auto& x : fixed_)
      if (!(abs(G[x.entry]) > Traced(0))) throw NotTraceable("a constraint row vanishes at the start");
    Traced none;  // 0 if all couplings are finite
    for (const auto& x : couplings_) none += G[x.entry] - G[x.entry];
    if (!(none == Traced(0))) throw NotTraceable("a constraint row is not finite");
    for (const auto& part : parts_) {
      const auto& block = part.block;
      auto& S = blocks.emplace_back();
      S.m = part.at.rows.size();
      S.L.resize(S.m * S.m);
      const auto value = [&](int e) { return G[part.entries[e]]; };
      for (const auto& p : block.products())
        S.L[p.entry] += value(p.e1) * value(p.e2) * Traced(block.mobility()[p.c]);
      const auto before = all_ratios.size();
      cholesky(S, all_ratios);
      ratios.push_back(static_cast<int>(all_ratios.size() - before));
    }
    factors = 0;
    for (const auto& S : blocks)
      for (const auto& x : S.L) {
        if (!x.is_constant()) trace.output(0, factors, x);
        ++factors;
      }
    trace.outputs(1, all_ratios);
  }

  for (const bool with_r : {true, false}) {
    Trace trace(object, with_r ? "solve" : "respond");
    const auto G = matrix(trace, 1);
    int next = 0;
    auto L = blocks;
    for (auto& S : L)
      for (auto& x : S.L) {
        if (!x.is_constant()) x = trace.input(0, next, x.value);
        ++next;
      }
    const auto f = trace.inputs(2, std::vector<double>(inverse_mass_.size(), 1));
    std::vector<Traced> r(rows_), a(f.size()), lambda(rows_);
    if (with_r) r = trace.inputs(3, std::vector<double>(rows_, 1));
    for (const auto& x : fixed_) a[x.column] = r[x.row] / G[x.entry];
    for (const auto& x : couplings_) r[x.row] -= G[x.entry] * a[fixed_[x.fixed].column];
    for (const int c : free_columns_) a[c] = f[c] * Traced(inverse_mass_[c]);
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const auto& at = parts_[p].at;
      const auto& begin = parts_[p].block.pattern().begin;
      const auto value = [&](int e) { return G[parts_[p].entries[e]]; };
      auto& S = L[p];
      for (const int c : at.columns) a[c] = f[c] * Traced(inverse_mass_[c]);
      std::vector<Traced> x(S.m);
      for (std::size_t k = 0; k < S.m; ++k) {
        for (int e = begin[k]; e < begin[k + 1]; ++e) x[k] += value(e) * a[at.column[e]];
        x[k] -= r[at.rows[k]];
      }
      for (std::size_t j = 0; j < S.m; ++j) {
        x[j] /= S.at(j, j);
        for (std::size_t i = j + 1; i < S.m; ++i) x[i] -= S.at(i, j) * x[j];
      }
      for (std::size_t j = S.m; j-- > 0;) {
        Traced y = x[j];
        for (std::size_t i = j + 1; i < S.m; ++i) y -= S.at(i, j) * x[i];
        x[j] = y / S.at(j, j);
      }
      for (std::size_t k = 0; k < S.m; ++k) {
        lambda[at.rows[k]] = x[k];
        for (int e = begin[k]; e < begin[k + 1]; ++e) {
          const int c = at.column[e];
          a[c] -= value(e) * x[k] * Traced(inverse_mass_[c]);
        }
      }
    }
    for (const auto& x : fixed_) lambda[x.row] = f[x.column] - Traced(x.mass) * a[x.column];
    for (const auto& x : couplings_) lambda[fixed_[x.fixed].row] -= G[x.entry] * lambda[x.row];
    for (const auto& x : fixed_) lambda[x.row] /= G[x.entry];
    trace.outputs(0, a);
    trace.outputs(1, lambda);
  }
  return true;
}

}  // namespace freeplay
