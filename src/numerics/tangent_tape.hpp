// TangentTape: evaluates the derivative of a traced function (append_tangent()) along several directions at
// once, without a compiler. Operations on numbers are made once. Operations on directions are made for a
// block of directions at a time, so that reading an operation is a small part of its work. Derivatives are
// linear in the directions: their operations are sums, products with numbers, and choices.
//
// Usage:
//
//     TangentTape tape(object, object.function(0), first_direction);
//     if (!tape.values(in)) ...                       // a comparison has another result: not usable here
//     tape.directions(directions, out);               // blocks of TangentTape::width directions
#pragma once

#include <Eigen/Core>

#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "numerics/trace.hpp"

namespace freeplay {

// Differentiation of a traced function. For a function y(x; c) of inputs x and of the constants c of an
// unshared object, tangent() appends to another object the function
//
//     ẏ = y_x ẋ + y_c ċ
//
// with directions ẋ and ċ as further inputs. It is the chain rule applied to each operation, hence exact to
// rounding. Equal operations are shared and products with 0 vanish, so that only what depends on a direction
// is computed. A comparison of the function is a guard of its derivative.

/// The inputs of a function and of its derivative.
struct TangentInputs {
  /// Samples of the arrays of the function. The derivative has the same arrays.
  std::vector<std::vector<double>> values;
  /// Array of the directions of each array; −1: it is constant.
  std::vector<int> directions;
  /// Of each slot of a constant, its index in the arrays of those that vary, or −1. Slots whose constants are
  /// always equal share an index.
  std::vector<int> varied;
  int varied_values = 0, varied_directions = 0;  ///< these arrays, of c and ċ
  /// Another input with the value of the sine or cosine of an input, if there is one: its array and index.
  std::function<std::optional<std::pair<int, int>>(Operation, int array, int index)> known;
};

/// Appends the derivative of `f`, a function of the unshared object `from`. Its outputs that are always zero
/// are left out. Numbers in tables must not be among the constants that vary.
void append_tangent(TracedObject& to, std::string_view name, const TracedObject& from,
                    const TracedFunction& f, const TangentInputs& inputs);

class TangentTape {
 public:
  /// Directions of one block. Arrays of directions have a block for each entry.
  static constexpr int width = 8;
  using Block = Eigen::Array<double, width, 1>;

  TangentTape() = default;
  /// Inputs from the array `first_direction` on are directions.
  TangentTape(const TracedObject& object, const TracedFunction& f, int first_direction);

  /// Evaluates all numbers that the derivatives need. False if a guard fails.
  bool values(const double* const* in);
  /// Adds the derivatives along a block of directions to the outputs; in[i] is array `first_direction` + i.
  void directions(const Block* const* in, Block* const* out);

 private:
  struct ValueStep {
    Operation operation;
    int out, a, b, c;  // of a look-up a, first number of its table, size; of a call its number
  };
  struct Call {
    std::shared_ptr<const OutsideFunction> function;
    std::vector<int> arguments;
    std::vector<double> x;
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
  std::vector<double> values_, tables_;
  std::vector<Call> calls_;
  std::vector<Block> blocks_;
};

}  // namespace freeplay
