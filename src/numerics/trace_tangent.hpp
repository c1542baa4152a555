// Differentiation of a traced function. For a function y(x; c) of inputs x and of the constants c of an
// unshared object, tangent() appends to another object the function
//
//     ẏ = y_x ẋ + y_c ċ
//
// with directions ẋ and ċ as further inputs. It is the chain rule applied to each operation, hence exact to
// rounding. Equal operations are shared and products with 0 vanish, so that only what depends on a direction
// is computed. A comparison of the function is a guard of its derivative.
#pragma once

#include <functional>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "numerics/trace.hpp"

namespace freeplay {

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

/// Appends the derivative of `f`, a function of an unshared object with these constants. Its outputs that
/// are always zero are left out.
void append_tangent(TracedObject& to, std::string_view name, const TracedFunction& f,
                    const std::vector<double>& constants, const TangentInputs& inputs);

}  // namespace freeplay
