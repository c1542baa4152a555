// Algebra of Boost.Odeint for std::vector<double>: its linear combinations, two or four entries at a time.
// Each entry is computed by the same operations in the same order as with Odeint's own algebra, so the
// results are bitwise identical.
#pragma once

#include <boost/numeric/odeint/algebra/algebra_dispatcher.hpp>
#include <boost/numeric/odeint/algebra/default_operations.hpp>
#include <boost/numeric/odeint/algebra/range_algebra.hpp>
#include <cstddef>
#include <vector>

#include "numerics/wide_registers.hpp"

namespace freeplay {

/// Whether an operation of Odeint computes x = Σ αₖ yₖ, which is defined for pairs of doubles, too.
template <class F>
inline constexpr bool is_linear_combination = false;
template <class... F>
inline constexpr bool is_linear_combination<boost::numeric::odeint::default_operations::scale_sum1<F...>> =
    true;
template <class... F>
inline constexpr bool is_linear_combination<boost::numeric::odeint::default_operations::scale_sum2<F...>> =
    true;
template <class... F>
inline constexpr bool is_linear_combination<boost::numeric::odeint::default_operations::scale_sum3<F...>> =
    true;
template <class... F>
inline constexpr bool is_linear_combination<boost::numeric::odeint::default_operations::scale_sum4<F...>> =
    true;
template <class... F>
inline constexpr bool is_linear_combination<boost::numeric::odeint::default_operations::scale_sum5<F...>> =
    true;
template <class... F>
inline constexpr bool is_linear_combination<boost::numeric::odeint::default_operations::scale_sum6<F...>> =
    true;
template <class... F>
inline constexpr bool is_linear_combination<boost::numeric::odeint::default_operations::scale_sum7<F...>> =
    true;

struct VectorAlgebra {
  using Vector = std::vector<double>;

  /// @name f(x[i], y[i], ...) for each entry
  ///@{
  static void for_each1(Vector& x, auto f) { each(f, x); }
  static void for_each2(auto& x, auto& y, auto f) { each(f, x, y); }
  static void for_each3(auto& x, auto& y, auto& z, auto f) { each(f, x, y, z); }
  static void for_each4(auto& x, auto& a, auto& b, auto& c, auto f) { each(f, x, a, b, c); }
  static void for_each5(auto& x, auto& a, auto& b, auto& c, auto& d, auto f) { each(f, x, a, b, c, d); }
  static void for_each6(auto& x, auto& a, auto& b, auto& c, auto& d, auto& e, auto f) {
    each(f, x, a, b, c, d, e);
  }
  static void for_each7(auto& x, auto& a, auto& b, auto& c, auto& d, auto& e, auto& g, auto f) {
    each(f, x, a, b, c, d, e, g);
  }
  static void for_each8(auto& x, auto& a, auto& b, auto& c, auto& d, auto& e, auto& g, auto& h, auto f) {
    each(f, x, a, b, c, d, e, g, h);
  }
  ///@}
  /// @name Longer combinations, which are rare
  ///@{
  template <class... X>
  static void for_each9(X&&... x) {
    Rare::for_each9(x...);
  }
  template <class... X>
  static void for_each10(X&&... x) {
    Rare::for_each10(x...);
  }
  template <class... X>
  static void for_each11(X&&... x) {
    Rare::for_each11(x...);
  }
  template <class... X>
  static void for_each12(X&&... x) {
    Rare::for_each12(x...);
  }
  template <class... X>
  static void for_each13(X&&... x) {
    Rare::for_each13(x...);
  }
  template <class... X>
  static void for_each14(X&&... x) {
    Rare::for_each14(x...);
  }
  template <class... X>
  static void for_each15(X&&... x) {
    Rare::for_each15(x...);
  }
  ///@}
  static double norm_inf(const Vector& x) { return Rare::norm_inf(x); }

 private:
  using Rare = boost::numeric::odeint::range_algebra;
  /// Adjacent doubles at any address of a double.
  using Pair = double __attribute__((vector_size(16), aligned(8), may_alias));
  using Quad = double __attribute__((vector_size(32), aligned(8), may_alias));

  template <class F, class... Y>
  static void each(F f, Vector& x, Y&... y) {
    over(f, x.size(), x.data(), y.data()...);
  }
  template <class F, class... Y>
  static void over(F f, std::size_t n, double* x, Y*... y) {
    std::size_t i = 0;
    if constexpr (is_linear_combination<F>) {
      if (has_wide_registers) return over_wide(f, n, x, y...);
      for (; i + 2 <= n; i += 2) {
        Pair sum;
        f(sum, *reinterpret_cast<const Pair*>(y + i)...);
        *reinterpret_cast<Pair*>(x + i) = sum;
      }
    }
    for (; i < n; ++i) f(x[i], y[i]...);
  }
  template <class F, class... Y>
  FREEPLAY_WIDE static void over_wide(F f, std::size_t n, double* x, Y*... y) {
    std::size_t i = 0;
    for (; i + 4 <= n; i += 4) {
      Quad sum;
      f(sum, *reinterpret_cast<const Quad*>(y + i)...);
      *reinterpret_cast<Quad*>(x + i) = sum;
    }
    for (; i < n; ++i) f(x[i], y[i]...);
  }
};

}  // namespace freeplay

template <>
struct boost::numeric::odeint::algebra_dispatcher_sfinae<std::vector<double>, void> {
  using algebra_type = freeplay::VectorAlgebra;
};
