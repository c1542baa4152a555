// The linear system of constrained dynamics, M a + Gᵀ λ = f, G a = r, solved by blocks. Parts of
// the mechanism that no row of G connects are separate blocks (saddle_block.hpp). A right-hand side
// with few entries, such as the row of a contact, costs only the parts that it involves.
//
// A row with one entry fixes its coordinate (of a guided body or a driven crank). With `eliminate`
// such rows and columns are removed before the blocks are made,
//
//     a_c = r_k/g,      G′a′ = r − G_c a_c,      λ_k = (f_c − m_c a_c − (G′ᵀλ′)_c)/g,
//
// which changes results by rounding only.
//
// Elastic rows B resist with the stiffness 1/Σ: they add BᵀΣ⁻¹B to M (ElasticRows). No elimination and no
// compiled functions are used then.
//
// Usage:
//
//     SaddlePoint saddle(system.mass(), system.pattern());
//     if (!saddle.factor(e.G.data())) return failure;
//     saddle.solve(f, r, a, lambda);
//
// A SaddlePoint owns the blocks, their factors and its work vectors. It copies mass and pattern.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "numerics/saddle_block.hpp"
#include "numerics/sparse.hpp"
#include "numerics/trace.hpp"

namespace freeplay {

// Compiled functions of a SaddlePoint (saddle_trace.cpp), for mechanisms whose blocks all have few
// rows. With the values of G in force and the factors F,
//
//     factor:   in G            out F, pivot ratios       fails for small pivots: use the general path
//     solve:    in F, G, f, r   out a, λ
//     respond:  in F, G, f      out a, λ                  r = 0
//
// The operations and their order are those of the general path.

struct SolveFunctions {
  CompiledFunction factor = nullptr, solve = nullptr, respond = nullptr;
  const double* constants = nullptr;
  bool eliminate = true;    ///< RowFacts::eliminate of the traced SaddlePoint
  int factors = 0;          ///< entries of F
  std::vector<int> ratios;  ///< number of pivot ratios of each block
};

/// Known properties of the rows. Dependent rows are not eliminated.
struct RowFacts {
  bool redundant = false;
  bool eliminate = true;
};

class SaddlePoint {
 public:
  /// `mass`: diagonal of M, G.columns entries. `B`: the pattern of elastic rows, null if there are none.
  SaddlePoint(std::span<const double> mass, const CsrPattern& G, SolvePath path = SolvePath::automatic,
              RowFacts facts = {}, const CsrPattern* B = nullptr);

  /// Uses compiled functions from the time on when `functions`, which must outlive this object, has
  /// them. Their results are bitwise identical.
  void use(const SolveFunctions* functions) { functions_ = functions; }
  /// Traces these functions at values of G; those marked constant have these values always. Adds
  /// nothing and returns false if a block has no dense path without dependent rows. Throws
  /// NotTraceable near dependent rows.
  bool trace(TracedObject& object, std::span<const double> G_values, const std::vector<bool>& constant,
             int& factors, std::vector<int>& ratios) const;
  /// @name Parts of it, to be recorded within larger functions (motion_kernel.cpp,
  /// time_stepping/lane_trace.cpp)
  ///@{
  /// F at G, the entries of all blocks in turn. `ratios` gets the pivot ratios, `counts` their number
  /// for each block.
  std::vector<Traced> trace_factors(const std::vector<Traced>& G, std::vector<Traced>& ratios,
                                    std::vector<int>& counts) const;
  /// solve(); without the multipliers of eliminated rows.
  void trace_solution(const std::vector<Traced>& G, const std::vector<Traced>& F,
                      const std::vector<Traced>& f, std::vector<Traced> r, std::vector<Traced>& a,
                      std::vector<Traced>& lambda) const;
  /// finish()
  void trace_finish(const std::vector<Traced>& G, const std::vector<Traced>& f, const std::vector<Traced>& a,
                    std::vector<Traced>& lambda) const;
  ///@}
  /// Where a larger function puts G, F and the pivot ratios. Not `usable` if its rows are eliminated
  /// otherwise.
  struct CompiledRoom {
    bool usable = false;
    double *G = nullptr, *factors = nullptr, *ratios = nullptr;
    std::size_t ratio_count = 0;
  };
  CompiledRoom compiled_room();
  /// Uses what such a function has put there.
  void take_compiled();
  /// The same, where it gives the least pivot ratio of each block.
  void take_compiled(const double* least);
  /// Records factors that steps in lanes have used since, by their least pivot ratios of each block.
  void factored_elsewhere(const double* least) {
    for (auto& part : parts_) part.block.factored_elsewhere(*least++);
  }

  /// Values of the elastic rows and their compliances Σ, from the next factorisation on.
  void set_elastic(std::span<const double> values, std::span<const double> compliance);
  /// Factorises with new values of G. Returns false if that is impossible (values not finite).
  [[nodiscard]] bool factor(const double* G_values);
  /// Multipliers that a solve computes. Those of eliminated rows cost as much as the remaining
  /// solve and are not needed for motion alone; finish() computes them from the others.
  enum class Multipliers { all, kept };
  /// Solves for a (columns) and λ (rows); f and r may be null for zero. Allocates nothing with
  /// dense blocks.
  void solve(const double* f, const double* r, double* a, double* lambda,
             Multipliers which = Multipliers::all);
  /// solve() with r = 0 and f = `row` + factor·`beside` (null: none).
  void respond(const SparseRow& row, const SparseRow* beside, double factor, double* a, double* lambda,
               Multipliers which = Multipliers::all);
  /// Multipliers of the eliminated rows, from a and the other multipliers of a solve with f (null:
  /// zero).
  void finish(const double* f, const double* a, double* lambda) const;
  /// finish() after respond() with `row`.
  void finish(const SparseRow& row, const double* a, double* lambda);

  /// Applies SaddleBlock::expect_noise to all blocks.
  void expect_noise(double of_r) {
    for (auto& part : parts_) part.block.expect_noise(of_r);
  }

  /// @name Responses of one part, for mechanisms of many parts
  ///@{
  /// The part of a coordinate; −1 if no row involves it or if it was eliminated.
  int part_of(int column) const { return part_of_column_[column]; }
  /// Index of a coordinate within its part.
  int place_of(int column) const { return place_of_column_[column]; }
  int part_size(int part) const { return static_cast<int>(parts_[part].at.columns.size()); }
  const std::vector<int>& columns_of(int part) const { return parts_[part].at.columns; }
  /// 1/M for a coordinate without rows, 0 for the others.
  double free_mobility(int column) const { return free_mobility_[column]; }
  /// respond() within one part. `load` are a few entries of f; those of other parts are ignored.
  void respond_in(int part, std::span<const int> columns, std::span<const double> load, double* a);
  ///@}

  /// Eliminated coordinates; as many rows were eliminated.
  const std::vector<int>& eliminated() const { return fixed_columns_; }
  int blocks() const { return static_cast<int>(parts_.size()); }
  /// Rows of the largest block.
  int largest_block() const { return largest_; }
  /// Whether every block uses the dense path.
  bool dense() const;
  /// Whether the last solve satisfied its constraint rows (SaddleBlock::converged).
  bool converged() const { return converged_; }
  /// The least SaddleBlock::nearest_singular of all blocks.
  double nearest_singular() const;
  /// Whether the last factorisation found dependent rows.
  bool singular() const;
  /// Saves or restores everything that later calls depend on (SaddleBlock::serialize). The other
  /// members are set before they are read.
  template <class M>
  void serialize(M& m) {
    m.part("saddle point");
    use_blocks();
    const auto fixed = fixed_value_.size(), couplings = coupling_value_.size();
    m(fixed_value_, coupling_value_, converged_);
    if (fixed_value_.size() != fixed || coupling_value_.size() != couplings)
      throw MemoryError("the snapshot's factors belong to another mechanism");
    for (auto& part : parts_) m(part.block);
  }

 private:
  struct Part {
    SaddleBlock::Places at;    // of the block, within the whole system
    std::vector<int> entries;  // its entries of G
    SaddleBlock block;
  };
  struct Fixed {  // row k has one entry, `entry`, in `column`
    int row, column, entry;
    double mass;
  };
  struct Coupling {  // an entry of a remaining row in the column of fixed_[fixed]
    int row, fixed, entry;
  };
  bool factor_compiled(const double* G_values);
  bool factor_blocks(const double* G_values);
  /// Factorises the blocks if compiled factors are in force.
  void use_blocks();
  void make_parts(std::span<const double> mass, const CsrPattern& G, SolvePath path);
  void find_fixed(std::span<const double> mass, const CsrPattern& G);
  void solve_elastic(const double* f, const double* r, double* a, double* lambda);
  const double* know(const double* r, double* a);
  void solve_part(Part& part, const double* f, const double* r, double* a, double* lambda);

  std::vector<Fixed> fixed_;
  std::vector<int> fixed_columns_;
  std::vector<Coupling> couplings_;
  std::vector<double> fixed_value_, coupling_value_, reduced_r_;
  std::vector<Part> parts_;
  std::vector<int> part_of_column_;  // −1: no row involves it
  std::vector<int> place_of_column_;
  std::vector<double> free_mobility_;
  std::vector<int> free_columns_;
  std::vector<double> inverse_mass_;
  std::vector<double> f_, r_, a_, lambda_;  // work vectors of one block
  std::vector<double> whole_;               // work vector: f of respond()
  int largest_ = 0;
  bool converged_ = true;
  RowFacts facts_;
  std::size_t rows_ = 0;  // of G
  bool elastic_ = false;
  std::vector<double> elastic_values_, elastic_r_,
      elastic_lambda_;  // work vectors; the others of rows of G and B
  const SolveFunctions* functions_ = nullptr;
  bool compiled_ = false;                            // whether the factors in force are those of `functions_`
  std::vector<double> G_values_, factors_, ratios_;  // of compiled factors
};

/// Responses A w of rows w, where A maps forces to accelerations under the constraints
/// (SaddlePoint). Only nonzero entries are stored: those in the parts of the mechanism that the
/// row involves, and in coordinates without constraints.
///
/// The cost of `row · A w` and `x += P A w` therefore depends on the size of those parts, not on
/// that of the mechanism. Both give the same bits as full vectors.
class Responses {
 public:
  /// Makes room for `rows` rows.
  explicit Responses(int rows) : of_(static_cast<std::size_t>(rows)) {}
  void make_room(int rows) {
    if (static_cast<std::size_t>(rows) > of_.size()) of_.resize(static_cast<std::size_t>(rows));
  }
  /// Sets the saddle point of all calls until the next use(). It must stay at its address
  /// meanwhile.
  void use(SaddlePoint& saddle) { saddle_ = &saddle; }

  /// Computes response r: that of `row` + factor·`beside` (null: none), with the present factors of
  /// the saddle point.
  void take(int r, const SparseRow& row, const SparseRow* beside = nullptr, double factor = 0);
  /// row · A w_r.
  double along(const SparseRow& row, int r) const;
  /// a += by A w_r.
  void add(int r, double by, double* a) const;

 private:
  static constexpr int most = 2 * SparseRow::max_size;
  struct One {
    int size = 0;  // of the load w
    std::array<int, most> column{};
    std::array<double, most> load{};
    // Parts involved: at most one for each coordinate, the case without elimination.
    int parts = 0;
    std::array<int, most> part{}, begin{};  // begin: first entry of the part in a
    std::vector<double> a;
  };
  SaddlePoint* saddle_ = nullptr;
  std::vector<One> of_;
};

}  // namespace freeplay
