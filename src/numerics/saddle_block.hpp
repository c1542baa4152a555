// The linear system of constrained dynamics
//
//     M a + Gᵀ λ = f,      G a = r,          M diagonal and positive.
//
// Dense path: Cholesky of the Schur complement S = G M⁻¹ Gᵀ; where its pivots cancel, as those of a body of next to no inertia
// do, one step of iterative refinement against G a = r restores the digits. Sparse path: KLU on the whole saddle-point
// matrix. Where rows of G depend on each other the multipliers are not unique; then the proximal iteration
//
//     G a − ε (λ_{i+1} − λ_i) = r,      λ_0 = 0
//
// converges to the a of the consistent system and to the λ of least Euclidean norm, because every increment
// lies in the range of S (Rockafellar, SIAM J. Control Optim. 14 (1976) 877, applied to a quadratic program).
// What f and r leave to rounding no a satisfies in dependent rows: there λ goes on by the same increment for ever,
// and the iteration ends where what is left of G a − r is that rounding.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "numerics/sparse.hpp"
#include "values/memory.hpp"

namespace freeplay {

enum class SolvePath { automatic, dense, sparse };

class SaddleBlock {
 public:
  /// Up to this many rows the dense path is the faster one (measured, docs/development/decisions/003).
  static constexpr int dense_rows = 28;

  /// `mass`: diagonal of M, length G.columns. `redundant`: the rows are known to depend on each other.
  SaddleBlock(std::span<const double> mass, const CsrPattern& G, SolvePath path = SolvePath::automatic,
              bool redundant = false);
  ~SaddleBlock();
  SaddleBlock(SaddleBlock&&) noexcept;
  SaddleBlock(const SaddleBlock&) = delete;

  /// Takes new values of G. False when no factorisation was found (values not finite).
  [[nodiscard]] bool factor(const double* G_values);
  /// The same where the block's values stand at `entries` among others.
  [[nodiscard]] bool factor_at(const double* G_values, const int* entries);
  /// Solves for a (columns) and λ (rows); f and r may be null for zero. Allocates nothing on the dense path.
  void solve(const double* f, const double* r, double* a, double* lambda);
  /// Where a greater system has the block's coordinates and rows.
  struct Places {
    std::vector<int> columns, rows;
    std::vector<int> column;           ///< of each entry
    std::span<const double> mobility;  ///< 1/M of the greater system
  };
  /// The same in a greater system's vectors, of which only the block's places are read and written. The operations are those
  /// of solve(), in the same order. For the dense path without dependent rows (direct()).
  void solve_at(const Places& at, const double* f, const double* r, double* a, double* lambda);
  bool direct() const { return dense_ && !proximal_; }

  /// Rounding of the r that follow, absolute, where it is more than theirs: dependent rows are met to that.
  void expect_noise(double of_r) { noise_ = of_r; }

  bool dense() const { return dense_; }
  /// The last solve satisfied its constraint rows. With dependent rows of very unlike scale the proximal
  /// iteration may not.
  bool converged() const { return converged_; }
  /// The last factorisation met dependent rows.
  bool singular() const { return proximal_; }
  /// How near the rows have come to depending on each other: the least pivot of S over its diagonal since the
  /// start, over that of the first factorisation. 1 on the sparse path.
  double nearest_singular() const { return first_pivot_ > 0 ? least_pivot_ / first_pivot_ : 1; }
  /// All that later calls depend on, the pivots among it (values/memory.hpp); a block of the same making that
  /// reads it goes on bit for bit.
  template <class M>
  void remember(M& m);

 private:
  struct Klu;
  struct Product {  // S(row, col) += G_values[e1] G_values[e2] / M[c]
    int entry, e1, e2, c;
  };
  bool factor_taken();
  bool factor_dense();
  bool factor_sparse();
  void solve_densely(const Places& at, const double* f, const double* r, const double* previous, double* a,
                     double* lambda);
  void refine(const Places& at, const double* r, double* a, double* lambda);
  void solve_once(const double* f, const double* r, const double* previous, double* a, double* lambda);

  const CsrPattern G_;
  std::vector<double> mass_, inverse_mass_, values_;
  bool dense_, redundant_, proximal_ = false, converged_ = true;
  bool lossy_ = false;  // a pivot of the last factorisation lost more than six digits
  double epsilon_ = 0, noise_ = 0;
  double first_pivot_ = 0, least_pivot_ = 1;
  std::vector<Product> products_;
  Places own_;  // each where it is
  std::vector<double> room_;
  Eigen::MatrixXd S_;
  Eigen::VectorXd previous_;
  std::unique_ptr<Klu> klu_;
};

}  // namespace freeplay
