// LaneTape: evaluates a traced function in lanes (trace.hpp) without a compiler. It is called like the
// compiled function and gives its digits: each operation is done for all lanes before the next one, none
// are fused, and functions of the math library are called for each lane.
//
// The operations are a list of addresses: of the code of an operation, of its operands and of its result.
// Inputs and constants are read where they are. A result that is an output is written there at once,
// unless an input or another output has that place; the other results have rooms, which are used again
// after their last reading, so that they stay in the nearest cache. A product that one sum uses
// alone is computed with it. The list is made for the arrays of a call, and made anew for a call with
// other arrays. So a tape belongs to one thread, and is fast for calls with the same arrays.
//
// Usage:
//
//     LaneTape tape(object.function(0), object.lanes());
//     const int failed = tape(constants, in, out);   // bit i: a guard failed in lane i
#pragma once

#include <cstddef>
#include <vector>

#include "numerics/trace.hpp"

namespace freeplay {

class LaneTape {
 public:
  /// Lanes of a tape: eight take about 1.3 times as long as four, because operations wait less for others.
  static constexpr int few = 4, many = 8;
  /// Whether this machine can: not on x86-64 without AVX2.
  static bool usable();
  /// `lanes`: few or many.
  LaneTape(const TracedFunction& f, int lanes);
  /// As CompiledFunction. All arrays begin at multiples of 32 bytes.
  int operator()(const double* constants, const double* const* in, double* const* out);

  /// An operation on blocks of `lanes` numbers; the operands depend on it.
  struct Step {
    const void* code;
    const double *a, *b, *c;
    double* result;
  };

 private:
  /// An operation on nodes of the graph; −1: none.
  struct Call {
    int code, a, b, c, result;
    bool looks_up() const;
    /// Calls f with each operand that is a node.
    void each_operand(auto f) const;
  };
  struct alignas(32) Quad {
    double x[4];
  };
  class Builder;
  class Assembler;
  void assemble(const double* constants, const double* const* in, double* const* out);

  double* room(int number) {
    return rooms_[static_cast<std::size_t>(number) * static_cast<std::size_t>(lanes_ / 4)].x;
  }

  int lanes_;
  int (*evaluate_)(const Step* steps, const void* const** codes);
  std::vector<TracedFunction::Node> nodes_;
  std::vector<TracedFunction::Output> outputs_;
  std::vector<Call> calls_;
  // For the arrays of the last call:
  std::vector<Step> steps_;
  std::vector<Quad> rooms_;
  const double* constants_ = nullptr;
  std::vector<const double*> in_;
  std::vector<double*> out_;
};

}  // namespace freeplay
