// AdamsHistory: the history of the method of Adams, Bashforth and Moulton with variable order k and
// step h, and its sums. With the modified divided differences φᵢ of the derivative and the
// coefficients gᵢ and βᵢ of the last steps' lengths, a step is
//
//     predictor    y* = y + Σ_{i<k} h gᵢ βᵢ φᵢ
//     differences  φ*₀ = f(y*),  φ*ᵢ = φ*ᵢ₋₁ − βᵢ₋₁ φᵢ₋₁
//     corrector    y₁ = y* + h g_k φ*_k,  and the differences anew with f(y₁)
//
// Source: Krogh, Shampine and Gordon, as in Boost.Odeint's adaptive_adams_bashforth_moulton, with its
// choice of the order. Each sum has the operations of Odeint in their order, so the digits are the same;
// but it is one pass over the components with all orders at once. Norms are taken of the differences
// and multiplied afterwards, which rounds to the same number.
//
// Usage: see Adams::attempt(). All components are in units of their error scales. A table has, for each
// four components, the differences of all orders in turn, so that a pass reads one stream.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "values/memory.hpp"

namespace freeplay {

struct AdamsSums;  // adams_history.cpp

class AdamsHistory {
 public:
  using Vector = std::vector<double>;
  static constexpr int most_order = 8;

  /// For n components; forgets everything.
  void resize(std::size_t n);
  /// Begins at a state; the next step is of first order.
  void restart(const Vector& x, const Vector& scale);
  /// Begins the next step at the end of the last one.
  void advance() { y_.swap(y_new_); }
  /// Whether the derivative at the beginning of the step is missing: begin().
  bool empty() const { return steps_ == 1; }
  int order() const { return order_; }

  /// The state at the beginning of the step, in its own units.
  void state(Vector& x) const;
  /// Sets the coefficients of a step of length h (s) from t (s).
  void predict(double t, double h);
  /// Enters the first derivative.
  void begin(const Vector& dxdt);
  /// x = y*
  void extrapolate(Vector& x);
  /// x = y₁ by the derivative at y*. Returns the greatest error |h g_k φ*_k|, or NaN.
  double correct(const Vector& dxdt, Vector& x);
  /// Enters the derivative at y₁: the step is accepted.
  void confirm(const Vector& dxdt);
  /// Chooses the order of the next step, of length h (s), by the errors of neighbouring orders.
  void choose_order(double h);

  template <class M>
  void serialize(M& m) {
    const auto size = y_.size(), table = now_.size();
    m(order_, steps_, scale_, y_, y_new_, now_, before_, beta_, times_, error_above_);
    if constexpr (M::reading)
      if (scale_.size() != size || y_.size() != size || y_new_.size() != size || now_.size() != table ||
          before_.size() != table || order_ < 1 || order_ > most_order || steps_ < order_ ||
          steps_ > most_order + 1)
        throw MemoryError("the snapshot's integrator has another size, or is damaged");
  }

 private:
  static constexpr int entries = most_order + 2;  // differences of a component
  static constexpr std::size_t width = 4;         // components side by side

  AdamsSums sums();

  std::size_t n_ = 0;
  int order_ = 1, steps_ = 1;  // steps_: number of times in use
  double h_ = 0;
  Vector scale_, y_, y_new_;  // with room for whole groups of components
  Vector now_, before_;       // differences φ* of this step and φ of the last one
  /// Coefficients β of this step and the last but one, whose upper entries remain.
  std::array<std::array<double, most_order + 1>, 2> beta_{};
  std::array<double, most_order + 1> times_{};  // s, of the last steps
  std::array<double, most_order + 1> g_{};
  /// Norms of the differences of orders k − 2 to k + 1 at the last confirm().
  std::array<double, 4> greatest_{};
  double error_above_ = 0;  // of the order above, when it was last known
};

}  // namespace freeplay
