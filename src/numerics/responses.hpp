// Responses A w of rows w (saddle_point.hpp: A takes forces to accelerations, the constraints kept), stored where they are
// not zero: in the parts of the mechanism that the row touches, and in coordinates that no constraint touches.
//
// What `row · A w` and `x += P A w` cost then depends on the size of those parts, not on that of the mechanism; both give
// the same bits as the whole vectors would.
#pragma once

#include <array>
#include <vector>

#include "numerics/saddle_point.hpp"

namespace freeplay {

class Responses {
 public:
  /// Of up to `rows` rows.
  explicit Responses(int rows) : of_(static_cast<std::size_t>(rows)) {}
  void make_room(int rows) {
    if (static_cast<std::size_t>(rows) > of_.size()) of_.resize(static_cast<std::size_t>(rows));
  }
  /// The saddle point that all calls until the next use() belong to; it stays where it is so long.
  void use(SaddlePoint& saddle) { saddle_ = &saddle; }

  /// Takes the response of `row` + factor·`beside` (null: none), with the saddle point's present factors, as number r.
  void take(int r, const SparseRow& row, const SparseRow* beside = nullptr, double factor = 0);
  /// row · A w_r
  double along(const SparseRow& row, int r) const;
  /// a += by A w_r
  void add(int r, double by, double* a) const;

 private:
  static constexpr int most = 2 * SparseRow::max_size;
  struct One {
    int size = 0;  // of the load w
    std::array<int, most> column{};
    std::array<double, most> load{};
    int parts = 0;  // as many as coordinates at most: without elimination each may be its own
    std::array<int, most> part{}, begin{};  // begin: of the part's coordinates in a
    std::vector<double> a;
  };
  SaddlePoint* saddle_ = nullptr;
  std::vector<One> of_;
};

}  // namespace freeplay
