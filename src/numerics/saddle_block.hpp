// The linear system of constrained dynamics
//
//     M a + Gᵀ λ = f,      G a − Σ λ = r,          M diagonal and positive, Σ diagonal.
//
// Σ is 0 but for elastic rows (SaddlePoint). Dense path: Cholesky factorisation of S = G M⁻¹ Gᵀ + Σ. If its pivots cancel, as
// those of a body with a very small inertia do, one step of iterative refinement against G a = r
// restores the accuracy. Sparse path: KLU on the whole saddle-point matrix.
//
// If rows of G are dependent, the multipliers are not unique. The proximal iteration
//
//     G a − ε (λ_{i+1} − λ_i) = r,      λ_0 = 0
//
// then converges to the a of the consistent system and to the λ of least Euclidean norm, because
// every increment is in the range of S (Rockafellar, SIAM J. Control Optim. 14 (1976) 877, applied
// to a quadratic program). Rounding errors of f and r make dependent rows inconsistent: λ then
// changes by the same increment without end. The iteration stops once the residual G a − r is of
// the size of that rounding.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "numerics/sparse.hpp"
#include "values/memory.hpp"

namespace freeplay {

/// A smaller ratio of a pivot of S to its diagonal loses more than six digits, which refinement
/// restores.
inline constexpr double lossy_pivot = 1e-6;

enum class SolvePath { automatic, dense, sparse };

class SaddleBlock {
 public:
  /// Number of rows up to which the dense path is faster (measured,
  /// docs/development/decisions/003).
  static constexpr int dense_rows = 28;

  /// `mass`: diagonal of M, G.columns entries. `redundant`: the rows are known to be dependent.
  SaddleBlock(std::span<const double> mass, const CsrPattern& G, SolvePath path = SolvePath::automatic,
              bool redundant = false);
  ~SaddleBlock();
  SaddleBlock(SaddleBlock&&) noexcept;
  SaddleBlock(const SaddleBlock&) = delete;

  /// Makes the last rows elastic: factorisations do not read their entries of G from outside any more.
  void make_elastic(int rows);
  /// Their values and Σ, from the next factorisation on.
  void set_elastic(std::span<const double> values, std::span<const double> compliance);
  /// Factorises with new values of G. Returns false if that is impossible (values not finite).
  [[nodiscard]] bool factor(const double* G_values);
  /// factor() for a block whose values are at `entries` of a larger array.
  [[nodiscard]] bool factor_at(const double* G_values, const int* entries);
  /// Solves for a (columns) and λ (rows); f and r may be null for zero. Allocates nothing on the
  /// dense path.
  void solve(const double* f, const double* r, double* a, double* lambda);
  /// Coordinates and rows of the block within a larger system.
  struct Places {
    std::vector<int> columns, rows;
    std::vector<int> column;           ///< column of each entry
    std::span<const double> mobility;  ///< 1/M of the larger system
  };
  /// solve() in the vectors of a larger system; only the entries of the block are read and written.
  /// The operations and their order are those of solve(). For the dense path without dependent rows
  /// (direct()).
  void solve_at(const Places& at, const double* f, const double* r, double* a, double* lambda);
  bool direct() const { return dense_ && !proximal_; }

  /// Absolute rounding error of the following r, if it exceeds their own rounding. Dependent rows
  /// are satisfied to that accuracy.
  void expect_noise(double of_r) { noise_ = of_r; }

  /// @name For compiled factors (saddle_trace.cpp)
  ///@{
  struct Product {  // S(row, col) += G_values[e1] G_values[e2] / M[c], entry = row + col·rows
    int entry, e1, e2, c;
  };
  const std::vector<Product>& products() const { return products_; }
  const CsrPattern& pattern() const { return G_; }
  const std::vector<double>& mobility() const { return inverse_mass_; }
  /// Records a successful factorisation elsewhere and its least pivot ratio.
  void factored_elsewhere(double ratio) {
    proximal_ = lossy_ = false;
    epsilon_ = 0;
    if (first_pivot_ == 0) first_pivot_ = ratio;
    if (ratio < least_pivot_) least_pivot_ = ratio > 0 ? ratio : 0;
  }
  ///@}

  bool dense() const { return dense_; }
  /// Whether the last solve satisfied its constraint rows. With dependent rows of very different
  /// scale the proximal iteration may fail to.
  bool converged() const { return converged_; }
  /// Whether the last factorisation found dependent rows.
  bool singular() const { return proximal_; }
  /// Nearness to dependent rows: the least ratio of a pivot of S to its diagonal since the start,
  /// divided by that of the first factorisation. 1 on the sparse path.
  double nearest_singular() const { return first_pivot_ > 0 ? least_pivot_ / first_pivot_ : 1; }
  /// Saves or restores everything that later calls depend on, the pivots included
  /// (values/memory.hpp). A block of the same construction that restores it continues bit for bit.
  template <class M>
  void serialize(M& m);

 private:
  struct Klu;
  bool factor_taken();
  bool factor_dense();
  bool factor_sparse();
  void solve_densely(const Places& at, const double* f, const double* r, const double* previous, double* a,
                     double* lambda);
  void refine(const Places& at, const double* r, double* a, double* lambda);
  void solve_once(const double* f, const double* r, const double* previous, double* a, double* lambda);

  const CsrPattern G_;
  std::vector<double> mass_, inverse_mass_, values_;
  std::size_t taken_ = 0;           // entries of G from outside
  std::vector<double> compliance_;  // Σ of all rows; empty: 0
  bool dense_, redundant_, proximal_ = false, converged_ = true;
  bool lossy_ = false;  // whether a pivot of the last factorisation lost more than six digits
  double epsilon_ = 0, noise_ = 0;
  double first_pivot_ = 0, least_pivot_ = 1;
  std::vector<Product> products_;
  Places own_;  // identity: the block is the whole system
  std::vector<double> room_;
  Eigen::MatrixXd S_;
  Eigen::VectorXd previous_;
  std::unique_ptr<Klu> klu_;
};

}  // namespace freeplay
