#include "numerics/saddle_block.hpp"

#include <klu.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace freeplay {
namespace {

// Size ε of the proximal term, relative to the mean diagonal of S.
constexpr double relative_epsilon = 1e-9;
// a smaller ratio of a pivot of S to its diagonal means dependent rows
constexpr double pivot_ratio = 1e-12;
constexpr int most_iterations = 50;
// Relative to the terms of a sum.
constexpr double rounding = 16 * std::numeric_limits<double>::epsilon();

/// In-place Cholesky of the lower triangle of a small dense matrix, column by column. Returns false
/// if the ratio of a pivot to its diagonal is at most `least`. `ratio`: the least such ratio.
bool cholesky(Eigen::MatrixXd& S, double least, double& ratio) {
  ratio = 1;
  const Eigen::Index m = S.rows();
  for (Eigen::Index j = 0; j < m; ++j) {
    const double diagonal = S(j, j);
    double pivot = diagonal;
    for (Eigen::Index k = 0; k < j; ++k) pivot -= S(j, k) * S(j, k);
    ratio = std::min(ratio, pivot / diagonal);
    if (!(pivot > least * diagonal)) return false;
    const double root = std::sqrt(pivot);
    S(j, j) = root;
    for (Eigen::Index i = j + 1; i < m; ++i) {
      double x = S(i, j);
      for (Eigen::Index k = 0; k < j; ++k) x -= S(i, k) * S(j, k);
      S(i, j) = x / root;
    }
  }
  return true;
}

/// (S + εI) λ = G M⁻¹ f − r + ε λ_previous, then a = M⁻¹ (f − Gᵀ λ), in the vectors of `at`. `size`
/// is that of λ, 0 for any; the operations and their order do not depend on it.
template <int size>
void solve_dense(const int* begin, const SaddleBlock::Places& at, const double* value, const double* S,
                 double epsilon, const double* f, const double* r, const double* previous, double* room,
                 double* a, double* lambda) {
  const int n = static_cast<int>(at.columns.size()), m = size > 0 ? size : static_cast<int>(at.rows.size());
  const int *columns = at.columns.data(), *rows = at.rows.data(), *column = at.column.data();
  const double* mobility = at.mobility.data();
  double few[std::max(size, 1)];
  double* x = size > 0 ? few : room;
  if (f)
    for (int i = 0; i < n; ++i) a[columns[i]] = f[columns[i]] * mobility[columns[i]];
  else
    for (int i = 0; i < n; ++i) a[columns[i]] = 0;
#pragma GCC unroll 4
  for (int k = 0; k < m; ++k) {
    double image = 0;
    if (f)
      for (int e = begin[k]; e < begin[k + 1]; ++e) image += value[e] * a[column[e]];
    x[k] = image - (r ? r[rows[k]] : 0) + (previous ? epsilon * previous[k] : 0);
  }
#pragma GCC unroll 4
  for (int j = 0; j < m; ++j) {
    x[j] /= S[j + j * m];
#pragma GCC unroll 4
    for (int i = j + 1; i < m; ++i) x[i] -= S[i + j * m] * x[j];
  }
#pragma GCC unroll 4
  for (int j = m - 1; j >= 0; --j) {
    double y = x[j];
#pragma GCC unroll 4
    for (int i = j + 1; i < m; ++i) y -= S[i + j * m] * x[i];
    x[j] = y / S[j + j * m];
  }
#pragma GCC unroll 4
  for (int k = 0; k < m; ++k) {
    lambda[rows[k]] = x[k];
    for (int e = begin[k]; e < begin[k + 1]; ++e) a[column[e]] -= value[e] * x[k] * mobility[column[e]];
  }
}

/// Saves or restores a vector of known length.
template <class M>
void serialize_fixed(M& m, std::vector<double>& values) {
  const auto size = values.size();
  m(values);
  if (values.size() != size) throw MemoryError("the snapshot's factors belong to another mechanism");
}

}  // namespace

/// The sparse matrix [M Gᵀ; G −εI] by columns, and its KLU factors.
struct SaddleBlock::Klu {
  klu_common common;
  klu_symbolic* symbolic = nullptr;
  klu_numeric* numeric = nullptr;
  std::vector<int> begin{0}, row;
  std::vector<double> value;
  std::vector<double> pivot_value;  // values for which the pivots were chosen
  bool refactored = false;          // whether refactorised since then
  // Places of the entries of G, of Gᵀ and of the diagonal −ε.
  std::vector<int> of_G, of_Gt, of_epsilon;
  Eigen::VectorXd rhs;

  ~Klu() {
    klu_free_numeric(&numeric, &common);
    klu_free_symbolic(&symbolic, &common);
  }

  Klu(const CsrPattern& G, const std::vector<double>& mass) : rhs(G.columns + G.rows) {
    const int n = G.columns, m = G.rows;
    klu_defaults(&common);
    std::vector<std::vector<std::pair<int, int>>> of_column(n);  // (row of G, entry)
    for (int k = 0; k < m; ++k)
      for (int e = G.begin[k]; e < G.begin[k + 1]; ++e) of_column[G.column[e]].emplace_back(k, e);
    of_G.resize(G.column.size());
    of_Gt.resize(G.column.size());
    const auto push = [&](int r, double x) {
      row.push_back(r);
      value.push_back(x);
      return static_cast<int>(row.size()) - 1;
    };
    for (int c = 0; c < n; ++c) {
      push(c, mass[c]);
      for (auto [k, e] : of_column[c]) of_G[e] = push(n + k, 0);
      begin.push_back(static_cast<int>(row.size()));
    }
    for (int k = 0; k < m; ++k) {
      for (int e = G.begin[k]; e < G.begin[k + 1]; ++e) of_Gt[e] = push(G.column[e], 0);
      of_epsilon.push_back(push(n + k, 0));
      begin.push_back(static_cast<int>(row.size()));
    }
    symbolic = klu_analyze(n + m, begin.data(), row.data(), &common);
  }

  /// Refactorises with the old pivots while these are accurate, else with new ones. Returns false
  /// if the matrix is singular.
  bool factor(const std::vector<double>& G_values, const std::vector<double>& compliance, double epsilon) {
    for (std::size_t e = 0; e < G_values.size(); ++e) value[of_G[e]] = value[of_Gt[e]] = G_values[e];
    for (int e : of_epsilon) value[e] = -epsilon;
    for (std::size_t k = 0; k < compliance.size(); ++k) value[of_epsilon[k]] -= compliance[k];
    if (numeric) {
      refactored = true;
      if (klu_refactor(begin.data(), row.data(), value.data(), symbolic, numeric, &common) &&
          klu_rcond(symbolic, numeric, &common) && common.rcond > pivot_ratio)
        return true;
    }
    pivot_value = value;
    refactored = false;
    choose_pivots();
    return numeric && common.status == KLU_OK && klu_rcond(symbolic, numeric, &common) &&
           common.rcond > (epsilon > 0 ? 0 : pivot_ratio);
  }
  void choose_pivots() {
    klu_free_numeric(&numeric, &common);
    numeric = klu_factor(begin.data(), row.data(), pivot_value.data(), symbolic, &common);
  }

  /// Pivots depend on the history. They are therefore chosen again from the values for which they
  /// were chosen, and the factors are then computed for the present values as before.
  template <class M>
  void serialize(M& m) {
    serialize_fixed(m, value);
    bool chosen = !pivot_value.empty();
    m(chosen, refactored);
    if (!chosen) {
      pivot_value.clear();
      klu_free_numeric(&numeric, &common);
      return;
    }
    pivot_value.resize(value.size());
    serialize_fixed(m, pivot_value);
    if constexpr (!M::reading) return;
    choose_pivots();
    if (numeric && refactored)
      klu_refactor(begin.data(), row.data(), value.data(), symbolic, numeric, &common);
  }
};

SaddleBlock::SaddleBlock(std::span<const double> mass, const CsrPattern& G, SolvePath path, bool redundant)
    : G_(G),
      mass_(mass.begin(), mass.end()),
      taken_(G.column.size()),
      dense_(path == SolvePath::dense || (path == SolvePath::automatic && G.rows <= dense_rows)),
      redundant_(redundant),
      previous_(G.rows) {
  for (double m : mass_) inverse_mass_.push_back(1 / m);
  values_.resize(G.column.size());
  room_.resize(static_cast<std::size_t>(G.rows));
  own_.columns.resize(static_cast<std::size_t>(G.columns));
  own_.rows.resize(static_cast<std::size_t>(G.rows));
  std::iota(own_.columns.begin(), own_.columns.end(), 0);
  std::iota(own_.rows.begin(), own_.rows.end(), 0);
  own_.column = G.column;
  own_.mobility = inverse_mass_;
  if (!dense_) {
    klu_ = std::make_unique<Klu>(G_, mass_);
    return;
  }
  S_.setZero(G.rows, G.rows);
  for (int k = 0; k < G.rows; ++k)
    for (int l = 0; l <= k; ++l)
      for (int e1 = G.begin[k]; e1 < G.begin[k + 1]; ++e1)
        for (int e2 = G.begin[l]; e2 < G.begin[l + 1]; ++e2)
          if (G.column[e1] == G.column[e2]) products_.push_back({k + l * G.rows, e1, e2, G.column[e1]});
}

SaddleBlock::~SaddleBlock() = default;
SaddleBlock::SaddleBlock(SaddleBlock&&) noexcept = default;

/// Σ enters S as squares of further values with the mobility 1.
void SaddleBlock::make_elastic(int rows) {
  taken_ = static_cast<std::size_t>(G_.begin[G_.rows - rows]);
  compliance_.assign(static_cast<std::size_t>(G_.rows), 0);
  if (!dense_) return;
  const int one = static_cast<int>(inverse_mass_.size());
  inverse_mass_.push_back(1);
  own_.mobility = inverse_mass_;
  for (int k = G_.rows - rows; k < G_.rows; ++k) {
    const int e = static_cast<int>(values_.size());
    values_.push_back(0);
    products_.push_back({k + k * G_.rows, e, e, one});
  }
}

void SaddleBlock::set_elastic(std::span<const double> values, std::span<const double> compliance) {
  std::ranges::copy(values, values_.begin() + static_cast<std::ptrdiff_t>(taken_));
  std::ranges::copy(compliance, compliance_.end() - std::ssize(compliance));
  if (dense_)
    std::ranges::transform(compliance, values_.end() - std::ssize(compliance),
                           [](double x) { return std::sqrt(x); });
}

bool SaddleBlock::factor(const double* G_values) {
  std::copy_n(G_values, taken_, values_.begin());
  return factor_taken();
}

bool SaddleBlock::factor_at(const double* G_values, const int* entries) {
  for (std::size_t e = 0; e < taken_; ++e) values_[e] = G_values[entries[e]];
  return factor_taken();
}

bool SaddleBlock::factor_taken() {
  double none = 0;  // 0 if all values are finite
  for (const double x : values_) none += x - x;
  if (none != 0) return false;
  proximal_ = redundant_;
  epsilon_ = 0;
  return dense_ ? factor_dense() : factor_sparse();
}

bool SaddleBlock::factor_dense() {
  const auto assemble = [&] {
    double* S = S_.data();
    const double *value = values_.data(), *mobility = inverse_mass_.data();
    std::fill_n(S, S_.size(), 0.0);
    for (const auto& p : products_) S[p.entry] += value[p.e1] * value[p.e2] * mobility[p.c];
  };
  if (G_.rows == 0) return true;
  assemble();
  if (!proximal_) {
    double ratio = 1;
    const bool regular = cholesky(S_, pivot_ratio, ratio);
    if (first_pivot_ == 0) first_pivot_ = ratio;
    least_pivot_ = std::min(least_pivot_, std::max(ratio, 0.0));
    lossy_ = ratio < lossy_pivot;
    if (regular) return true;
    proximal_ = true;
    lossy_ = false;
    assemble();
  }
  epsilon_ = relative_epsilon * S_.diagonal().mean();
  S_.diagonal().array() += epsilon_;
  double ignored = 1;
  return cholesky(S_, 0, ignored);
}

bool SaddleBlock::factor_sparse() {
  if (!proximal_) {
    if (klu_->factor(values_, compliance_, 0)) return true;
    proximal_ = true;
  }
  double trace = 0;
  for (std::size_t e = 0; e < values_.size(); ++e)
    trace += values_[e] * values_[e] * inverse_mass_[G_.column[e]];
  epsilon_ = relative_epsilon * trace / std::max(1, G_.rows);
  return klu_->factor(values_, compliance_, epsilon_);
}

/// Uses kernels of fixed size for small blocks, which most mechanisms consist of.
void SaddleBlock::solve_densely(const Places& at, const double* f, const double* r, const double* previous,
                                double* a, double* lambda) {
  const auto by = [&](auto kernel) {
    kernel(G_.begin.data(), at, values_.data(), S_.data(), epsilon_, f, r, previous, room_.data(), a, lambda);
  };
  switch (G_.rows) {
    case 1:
      by(solve_dense<1>);
      break;
    case 2:
      by(solve_dense<2>);
      break;
    case 3:
      by(solve_dense<3>);
      break;
    case 4:
      by(solve_dense<4>);
      break;
    default:
      by(solve_dense<0>);
  }
  if (lossy_) refine(at, r, a, lambda);
}

/// S dλ = G a − Σλ − r, λ += dλ, a −= M⁻¹Gᵀ dλ.
void SaddleBlock::refine(const Places& at, const double* r, double* a, double* lambda) {
  auto x = Eigen::Map<Eigen::VectorXd>(room_.data(), G_.rows);
  for (int k = 0; k < G_.rows; ++k) {
    x[k] = r ? -r[at.rows[k]] : 0;
    if (!compliance_.empty()) x[k] -= compliance_[static_cast<std::size_t>(k)] * lambda[at.rows[k]];
    for (int e = G_.begin[k]; e < G_.begin[k + 1]; ++e) x[k] += values_[e] * a[at.column[e]];
  }
  S_.triangularView<Eigen::Lower>().solveInPlace(x);
  S_.triangularView<Eigen::Lower>().transpose().solveInPlace(x);
  for (int k = 0; k < G_.rows; ++k) {
    lambda[at.rows[k]] += x[k];
    for (int e = G_.begin[k]; e < G_.begin[k + 1]; ++e)
      a[at.column[e]] -= values_[e] * x[k] * at.mobility[at.column[e]];
  }
}

void SaddleBlock::solve_at(const Places& at, const double* f, const double* r, double* a, double* lambda) {
  solve_densely(at, f, r, nullptr, a, lambda);
}

void SaddleBlock::solve_once(const double* f, const double* r, const double* previous, double* a,
                             double* lambda) {
  const int n = G_.columns, m = G_.rows;
  if (dense_) {
    solve_densely(own_, f, r, previous, a, lambda);
    return;
  }
  auto& x = klu_->rhs;
  for (int c = 0; c < n; ++c) x[c] = f ? f[c] : 0;
  for (int k = 0; k < m; ++k) x[n + k] = (r ? r[k] : 0) - (previous ? epsilon_ * previous[k] : 0);
  klu_solve(klu_->symbolic, klu_->numeric, n + m, 1, x.data(), &klu_->common);
  for (int c = 0; c < n; ++c) a[c] = x[c];
  for (int k = 0; k < m; ++k) lambda[k] = x[n + k];
}

void SaddleBlock::solve(const double* f, const double* r, double* a, double* lambda) {
  solve_once(f, r, nullptr, a, lambda);
  converged_ = true;
  if (!proximal_) return;
  double size = 0, terms = 0;  // of G M⁻¹f − r, and of its terms
  for (int k = 0; k < G_.rows; ++k) {
    double x = r ? -r[k] : 0, sum = std::abs(x);
    for (int e = G_.begin[k]; f && e < G_.begin[k + 1]; ++e) {
      const double term = values_[e] * f[G_.column[e]] * inverse_mass_[G_.column[e]];
      x += term;
      sum += std::abs(term);
    }
    size = std::max(size, std::abs(x));
    terms = std::max(terms, sum);
  }
  const double noise = std::max(rounding * terms, noise_);
  Eigen::Map<Eigen::VectorXd> now(lambda, G_.rows);
  for (int i = 0; i < most_iterations; ++i) {
    previous_ = now;
    solve_once(f, r, previous_.data(), a, lambda);
    if ((now - previous_).norm() <= 1e-13 * now.norm()) break;
    // Rounding makes dependent rows inconsistent: λ would change without end.
    if (epsilon_ * (now - previous_).lpNorm<Eigen::Infinity>() <= noise) break;
  }
  // The residual G a − r is ε times the last change of λ.
  converged_ = epsilon_ * (now - previous_).lpNorm<Eigen::Infinity>() <= std::max(1e-6 * size, 1e3 * noise);
}

template <class M>
void SaddleBlock::serialize(M& m) {
  serialize_fixed(m, values_);
  if (!compliance_.empty()) serialize_fixed(m, compliance_);
  m(proximal_, lossy_, converged_, epsilon_, first_pivot_, least_pivot_);
  if (dense_)
    m.raw(S_.data(), static_cast<std::size_t>(S_.size()) * sizeof(double));
  else
    klu_->serialize(m);
}
template void SaddleBlock::serialize(MemoryWriter&);
template void SaddleBlock::serialize(MemoryReader&);

}  // namespace freeplay
