// CurvatureTape: values, first and second derivatives of a traced function y(x) at a point, or enclosures of
// them over a box |x − x₀| ≤ r (interval.hpp). With intervals, the matrices contain the derivatives at every
// point of the box.
//
// The gradient of each output is accumulated in reverse over the operations that it depends on. The second
// derivative of a weighted sum w·y is the derivative of its gradient along each variable (forward over
// reverse; Griewank and Walther, Evaluating Derivatives, 2nd ed. 2008, section 5.1), over the operations that
// depend on that variable.
//
// Usage:
//
//     CurvatureTape<Interval> tape(object, object.function(0));  // one array of inputs, one of outputs
//     if (!tape.evaluate(x)) ...                                 // a comparison is undecided in the box
//     tape.gradient(k, g);
//     tape.second(weights, H);
#pragma once

#include <span>
#include <vector>

#include "numerics/interval.hpp"
#include "numerics/trace.hpp"

namespace freeplay {

/// N: double or Interval.
template <class N>
class CurvatureTape {
 public:
  /// Throws NotTraceable if the function calls code that is not traced.
  CurvatureTape(const TracedObject& object, const TracedFunction& f);

  std::size_t variables() const { return variables_; }
  /// Replaces the constants of the object; entries of tables keep their values.
  void set_constants(std::span<const double> constants);
  /// Evaluates all operations. False if a guard fails, or a derivative may not exist: a comparison or a
  /// piece of a table is undecided, a root reaches zero.
  bool evaluate(std::span<const N> x);
  std::size_t outputs() const { return outputs_.size(); }
  const N& output(std::size_t k) const { return value_[static_cast<std::size_t>(outputs_[k])]; }
  /// ∂y_k/∂x, one entry for each variable; needs evaluate().
  void gradient(std::size_t k, std::span<N> g);
  /// ∂(w·y)/∂x. What cancels among the outputs does so before it is enclosed.
  void gradient(std::span<const N> weights, std::span<N> g);
  /// ∂²(w·y)/∂x², row by row; needs evaluate().
  void second(std::span<const N> weights, std::vector<N>& H);

 private:
  struct Step {
    Operation operation;
    int a, b, c;          // operands; of a look-up b: first entry of its table, c: number of entries
    bool varies = false;  // depends on a variable
  };
  /// First and second partial derivatives of an operation by its operands a and b.
  struct Partials {
    N a = 0, b = 0, aa = 0, ab = 0, bb = 0;
  };
  bool apply(std::size_t i, std::span<const N> x);
  /// Calls f(operand, partial derivative) for each varying operand of a step.
  template <class F>
  void each_operand(int i, F f) const;
  /// Accumulates the adjoints of all steps for a weighted sum of the outputs.
  void accumulate(std::span<const N> weights);
  bool decided(const TracedFunction::Guard& guard) const;

  std::vector<Step> steps_;
  std::vector<TracedFunction::Guard> guards_;
  std::vector<double> tables_;
  std::vector<int> outputs_;             // step of each output
  std::vector<std::vector<int>> below_;  // of each output, the varying steps that it depends on, descending
  std::vector<std::vector<int>> above_;  // of each variable, the steps that depend on it, ascending
  std::vector<char> bent_;               // of each variable, whether a step above is not linear
  std::vector<int> input_;               // step of each variable, −1: unused
  std::size_t variables_ = 0;
  std::vector<N> value_, adjoint_, slope_, bend_;
  std::vector<Partials> partials_;
};

extern template class CurvatureTape<double>;
extern template class CurvatureTape<Interval>;

}  // namespace freeplay
