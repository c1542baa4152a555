// TangentTape: evaluates the derivative of a traced function (trace_tangent.hpp) along several directions at
// once, without a compiler. Operations on numbers are made once. Operations on directions are made for a
// block of directions at a time, so that reading an operation is a small part of its work. Derivatives are
// linear in the directions: their operations are sums, products with numbers, and choices.
//
// Usage:
//
//     TangentTape tape(object.function(0), object.constants(), first_direction);
//     if (!tape.values(in)) ...                       // a comparison has another result: not usable here
//     tape.directions(directions, out);               // blocks of TangentTape::width directions
#pragma once

#include <Eigen/Core>
#include <vector>

#include "numerics/trace.hpp"

namespace freeplay {

class TangentTape {
 public:
  /// Directions of one block. Arrays of directions have a block for each entry.
  static constexpr int width = 8;
  using Block = Eigen::Array<double, width, 1>;

  TangentTape() = default;
  /// Inputs from the array `first_direction` on are directions.
  TangentTape(const TracedFunction& f, const std::vector<double>& constants, int first_direction);

  /// Evaluates all numbers that the derivatives need. False if a guard fails.
  [[nodiscard]] bool values(const double* const* in);
  /// Adds the derivatives along a block of directions to the outputs; in[i] is array `first_direction` + i.
  void directions(const Block* const* in, Block* const* out);
  /// Operations on numbers, and on each block of directions.
  int value_steps() const { return static_cast<int>(value_steps_.size()); }
  int block_steps() const { return static_cast<int>(block_steps_.size()); }

 private:
  struct ValueStep {
    Operation operation;
    int out, a, b, c;
  };
  /// Block `out` from the blocks a and b, and number c:
  enum class Kind { input, add, subtract, negate, multiply, divide, select, add_product, subtract_product };
  struct BlockStep {
    Kind kind;
    int out, a, b, c;
  };
  struct BlockOutput {
    int array, index, block;
  };
  class Builder;

  std::vector<ValueStep> value_steps_;
  std::vector<BlockStep> block_steps_;
  std::vector<TracedFunction::Guard> guards_;
  std::vector<BlockOutput> outputs_;
  std::vector<double> values_;
  std::vector<Block> blocks_;
};

}  // namespace freeplay
