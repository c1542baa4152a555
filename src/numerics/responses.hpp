// Responses A w of rows w, where A maps forces to accelerations under the constraints
// (saddle_point.hpp). Only nonzero entries are stored: those in the parts of the mechanism that the
// row involves, and in coordinates without constraints.
//
// The cost of `row · A w` and `x += P A w` therefore depends on the size of those parts, not on
// that of the mechanism. Both give the same bits as full vectors.
#pragma once

#include <array>
#include <vector>

#include "numerics/saddle_point.hpp"

namespace freeplay {

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
