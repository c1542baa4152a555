// The linear system of constrained dynamics, M a + Gᵀ λ = f, G a = r, in blocks: parts of the mechanism that
// no row of G connects are solved apart (saddle_block.hpp), however many there are. A right-hand side of a
// few entries, as a contact's row is, costs only the parts that it touches.
//
// A row with one entry fixes its coordinate (a guided body's, a driven crank's): with `eliminate` such rows
// and columns leave the blocks beforehand,
//
//     a_c = r_k/g,      G′a′ = r − G_c a_c,      λ_k = (f_c − m_c a_c − (G′ᵀλ′)_c)/g,
//
// which changes no result but its rounding.
#pragma once

#include <span>
#include <vector>

#include "numerics/saddle_block.hpp"
#include "numerics/sparse.hpp"

namespace freeplay {

/// What is known of the rows. Dependent ones are not eliminated.
struct RowFacts {
  bool redundant = false;
  bool eliminate = true;
};

class SaddlePoint {
 public:
  /// `mass`: diagonal of M, length G.columns.
  SaddlePoint(std::span<const double> mass, const CsrPattern& G, SolvePath path = SolvePath::automatic,
              RowFacts facts = {});

  /// Takes new values of G. False when no factorisation was found (values not finite).
  [[nodiscard]] bool factor(const double* G_values);
  /// Which multipliers a solve gives. Those of eliminated rows cost as much as the rest, and what only moves has no use for
  /// them; finish() finds them from the others.
  enum class Multipliers { all, kept };
  /// Solves for a (columns) and λ (rows); f and r may be null for zero. Allocates nothing with dense blocks.
  void solve(const double* f, const double* r, double* a, double* lambda,
             Multipliers which = Multipliers::all);
  /// The same with r = 0 and f = `row` + factor·`beside` (null: none).
  void respond(const SparseRow& row, const SparseRow* beside, double factor, double* a, double* lambda,
               Multipliers which = Multipliers::all);
  /// Multipliers of the eliminated rows to a and the other multipliers that f gave (null: zero).
  void finish(const double* f, const double* a, double* lambda) const;
  /// The same to what `row` gave.
  void finish(const SparseRow& row, const double* a, double* lambda);

  /// SaddleBlock::expect_noise of all blocks.
  void expect_noise(double of_r) {
    for (auto& part : parts_) part.block.expect_noise(of_r);
  }

  /// @name Responses of a part alone, for mechanisms of many parts
  ///@{
  /// The part of a coordinate; −1: no row touches it, or it was eliminated.
  int part_of(int column) const { return part_of_column_[column]; }
  /// Its place among the part's coordinates.
  int place_of(int column) const { return place_of_column_[column]; }
  int part_size(int part) const { return static_cast<int>(parts_[part].at.columns.size()); }
  const std::vector<int>& columns_of(int part) const { return parts_[part].at.columns; }
  /// Of a coordinate that no row touches 1/M, of others 0.
  double free_mobility(int column) const { return free_mobility_[column]; }
  /// What respond() gives in the part's coordinates: `load`, a few entries of f, of which those of other parts are left out.
  void respond_in(int part, std::span<const int> columns, std::span<const double> load, double* a);
  ///@}

  /// Coordinates (and as many rows) that were eliminated.
  const std::vector<int>& eliminated() const { return fixed_columns_; }
  int blocks() const { return static_cast<int>(parts_.size()); }
  /// Rows of the largest block.
  int largest_block() const { return largest_; }
  /// Every block is factorised densely.
  bool dense() const;
  /// The last solve satisfied its constraint rows (SaddleBlock::converged).
  bool converged() const { return converged_; }
  /// The least of the blocks' SaddleBlock::nearest_singular.
  double nearest_singular() const;
  /// The last factorisation met dependent rows.
  bool singular() const;
  /// All that later calls depend on (SaddleBlock::remember). What is not here is filled before it is read.
  template <class M>
  void remember(M& m) {
    m.part("saddle point");
    const auto fixed = fixed_value_.size(), couplings = coupling_value_.size();
    m(fixed_value_, coupling_value_, converged_);
    if (fixed_value_.size() != fixed || coupling_value_.size() != couplings)
      throw MemoryError("the snapshot's factors are of another mechanism");
    for (auto& part : parts_) m(part.block);
  }

 private:
  struct Part {
    SaddleBlock::Places at;    // of the whole, in the order of the block
    std::vector<int> entries;  // of G
    SaddleBlock block;
  };
  struct Fixed {  // row k has the one entry `entry`, in `column`
    int row, column, entry;
    double mass;
  };
  struct Coupling {  // an entry of a row that stays, in the column of fixed_[fixed]
    int row, fixed, entry;
  };
  void find_fixed(std::span<const double> mass, const CsrPattern& G);
  const double* know(const double* r, double* a);
  void solve_part(Part& part, const double* f, const double* r, double* a, double* lambda);

  std::vector<Fixed> fixed_;
  std::vector<int> fixed_columns_;
  std::vector<Coupling> couplings_;
  std::vector<double> fixed_value_, coupling_value_, reduced_r_;
  std::vector<Part> parts_;
  std::vector<int> part_of_column_;  // −1: no row touches it
  std::vector<int> place_of_column_;
  std::vector<double> free_mobility_;
  std::vector<int> free_columns_;
  std::vector<double> inverse_mass_;
  std::vector<double> f_, r_, a_, lambda_;  // of one block
  std::vector<double> whole_;               // f of respond()
  int largest_ = 0;
  bool converged_ = true;
};

}  // namespace freeplay
