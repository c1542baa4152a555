// Traces the factorisation and the solution of a SaddlePoint with dense blocks (saddle_point.hpp).
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

std::vector<Traced> SaddlePoint::trace_factors(const std::vector<Traced>& G, std::vector<Traced>& ratios,
                                               std::vector<int>& counts) const {
  std::vector<Traced> F;
  for (const auto& x : fixed_)
    if (!(abs(G[x.entry]) > Traced(0))) throw NotTraceable("a constraint row vanishes at the start");
  Traced none;  // 0 if all couplings are finite
  for (const auto& x : couplings_) none += G[x.entry] - G[x.entry];
  if (!(none == Traced(0))) throw NotTraceable("a constraint row is not finite");
  for (const auto& part : parts_) {
    const auto& block = part.block;
    Factors S;
    S.m = part.at.rows.size();
    S.L.resize(S.m * S.m);
    const auto value = [&](int e) { return G[part.entries[e]]; };
    for (const auto& p : block.products())
      S.L[p.entry] += value(p.e1) * value(p.e2) * Traced(block.mobility()[p.c]);
    const auto before = ratios.size();
    cholesky(S, ratios);
    counts.push_back(static_cast<int>(ratios.size() - before));
    F.insert(F.end(), S.L.begin(), S.L.end());
  }
  return F;
}

void SaddlePoint::trace_solution(const std::vector<Traced>& G, const std::vector<Traced>& F,
                                 const std::vector<Traced>& f, std::vector<Traced> r, std::vector<Traced>& a,
                                 std::vector<Traced>& lambda) const {
  a.assign(f.size(), {});
  lambda.assign(rows_, {});
  for (const auto& x : fixed_) a[x.column] = r[x.row] / G[x.entry];
  for (const auto& x : couplings_) r[x.row] -= G[x.entry] * a[fixed_[x.fixed].column];
  for (const int c : free_columns_) a[c] = f[c] * Traced(inverse_mass_[c]);
  const Traced* block = F.data();
  for (const auto& part : parts_) {
    const auto& at = part.at;
    const auto m = at.rows.size();
    const auto& begin = part.block.pattern().begin;
    const auto value = [&](int e) { return G[part.entries[e]]; };
    const auto L = [&](std::size_t i, std::size_t j) { return block[i + j * m]; };
    for (const int c : at.columns) a[c] = f[c] * Traced(inverse_mass_[c]);
    std::vector<Traced> x(m);
    for (std::size_t k = 0; k < m; ++k) {
      for (int e = begin[k]; e < begin[k + 1]; ++e) x[k] += value(e) * a[at.column[e]];
      x[k] -= r[at.rows[k]];
    }
    for (std::size_t j = 0; j < m; ++j) {
      x[j] /= L(j, j);
      for (std::size_t i = j + 1; i < m; ++i) x[i] -= L(i, j) * x[j];
    }
    for (std::size_t j = m; j-- > 0;) {
      Traced y = x[j];
      for (std::size_t i = j + 1; i < m; ++i) y -= L(i, j) * x[i];
      x[j] = y / L(j, j);
    }
    for (std::size_t k = 0; k < m; ++k) {
      lambda[at.rows[k]] = x[k];
      for (int e = begin[k]; e < begin[k + 1]; ++e) {
        const int c = at.column[e];
        a[c] -= value(e) * x[k] * Traced(inverse_mass_[c]);
      }
    }
    block += m * m;
  }
}

void SaddlePoint::trace_finish(const std::vector<Traced>& G, const std::vector<Traced>& f,
                               const std::vector<Traced>& a, std::vector<Traced>& lambda) const {
  for (const auto& x : fixed_) lambda[x.row] = f[x.column] - Traced(x.mass) * a[x.column];
  for (const auto& x : couplings_) lambda[fixed_[x.fixed].row] -= G[x.entry] * lambda[x.row];
  for (const auto& x : fixed_) lambda[x.row] /= G[x.entry];
}

bool SaddlePoint::trace(TracedObject& object, std::span<const double> G_values,
                        const std::vector<bool>& constant, int& factors, std::vector<int>& ratios) const {
  if (!dense()) return false;
  const auto matrix = [&](Trace& trace, int array) {
    auto G = trace.inputs(array, G_values);
    for (std::size_t e = 0; e < G.size(); ++e)
      if (constant[e]) G[e] = G_values[e];
    return G;
  };

  std::vector<Traced> F;
  {
    Trace trace(object, "factor");
    std::vector<Traced> all_ratios;
    F = trace_factors(matrix(trace, 0), all_ratios, ratios);
    factors = static_cast<int>(F.size());
    for (int i = 0; i < factors; ++i)
      if (!F[i].is_constant()) trace.output(0, i, F[i]);
    trace.outputs(1, all_ratios);
  }

  for (const bool with_r : {true, false}) {
    Trace trace(object, with_r ? "solve" : "respond");
    const auto G = matrix(trace, 1);
    auto L = F;
    for (int i = 0; i < factors; ++i)
      if (!L[i].is_constant()) L[i] = trace.input(0, i, L[i].value);
    const auto f = trace.inputs(2, std::vector<double>(inverse_mass_.size(), 1));
    std::vector<Traced> r(rows_), a, lambda;
    if (with_r) r = trace.inputs(3, std::vector<double>(rows_, 1));
    trace_solution(G, L, f, r, a, lambda);
    trace_finish(G, f, a, lambda);
    trace.outputs(0, a);
    trace.outputs(1, lambda);
  }
  return true;
}

}  // namespace freeplay
