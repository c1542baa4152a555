// Choices by value in templates on the scalar. For numbers a condition is a bool and only the chosen branch
// is evaluated. For traced numbers it is part of the compiled
// function, which evaluates both branches, so neither may be refused (numerics/traced.hpp). Thus
//
//     choose(is_below(x, T(0)), [&] { return -x; }, [&] { return x; })
//
// is |x| in all of them.
#pragma once

#include <cmath>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "numerics/traced.hpp"
#include "values/vec2.hpp"

namespace freeplay {

/// Whether operations on numbers of this type are recorded.
template <class T>
inline constexpr bool is_traced = std::is_same_v<T, Traced>;
/// a < b, of which one may be a plain number.
template <class A, class B>
auto is_below(const A& a, const B& b) {
  if constexpr (is_traced<A> || is_traced<B>)
    return holds(a, Relation::less, b);
  else
    return a < b;
}

/// a = b, likewise.
template <class A, class B>
auto is_equal(const A& a, const B& b) {
  if constexpr (is_traced<A> || is_traced<B>)
    return holds(a, Relation::equal, b);
  else
    return a == b;
}

/// a ≤ b, likewise.
template <class A, class B>
auto is_at_most(const A& a, const B& b) {
  if constexpr (is_traced<A> || is_traced<B>)
    return holds(a, Relation::less_equal, b);
  else
    return value_of(a) <= value_of(b);
}
/// The type of these conditions, which both() and either() join.
template <class T>
using ConditionOf = std::conditional_t<is_traced<T>, Traced, bool>;
/// Whether both conditions hold.
inline bool both(bool a, bool b) { return a && b; }
/// Whether one of them holds.
inline bool either(bool a, bool b) { return a || b; }

/// The result of `a` where the condition holds, else of `b`.
template <class A, class B>
auto choose(bool condition, A a, B b) {
  return condition ? a() : b();
}
/// The same for a traced condition.
template <class A, class B>
auto choose(const Traced& condition, A a, B b) {
  if (condition.is_constant()) return condition.value != 0 ? a() : b();
  return select(condition, a(), b());
}

/// std::min(a, b)
template <class T>
T least(const T& a, const T& b) {
  return choose(
      is_below(b, a), [&] { return b; }, [&] { return a; });
}

/// x, limited to ±limit.
template <class T>
T limited(const T& x, double limit) {
  return choose(
      is_below(limit, x), [&] { return T(limit); },
      [&] {
        return choose(
            is_below(x, -limit), [&] { return T(-limit); }, [&] { return x; });
      });
}

/// @name Whole numbers near a place
///@{

/// Greatest whole number that is at most x.
inline double floor_of(double x) { return std::floor(x); }
/// The same for a traced number.
inline Traced floor_of(const Traced& x) { return floor(x); }
/// Nearest whole number; halves away from 0.
inline double round_of(double x) { return std::round(x); }
/// The same for a traced number.
inline Traced round_of(const Traced& x) { return round(x); }
///@}

/// Whether a number is 0 wherever it is evaluated, so that its terms may be omitted.
inline bool vanishes(double x) { return x == 0; }
/// The same for a traced number.
inline bool vanishes(const Traced& x) { return x.is_constant() && x.value == 0; }

/// @name Look-ups
///@{

/// The type of the index of an entry at a place of type P.
template <class P>
using IndexOf = std::conditional_t<is_traced<P>, Traced, std::size_t>;
/// Number of knots that are at most x: std::upper_bound among knot(0), ..., knot(n − 1), which increase.
template <class Knot>
std::size_t interval_of(std::size_t n, double x, Knot knot) {
  std::size_t i = 0;
  while (n > 0) {
    const std::size_t half = n / 2;
    if (x < knot(i + half)) {
      n = half;
    } else {
      i += half + 1;
      n -= half + 1;
    }
  }
  return i;
}
/// Entry i of entry(0), ..., entry(n − 1).
template <class Entry>
double entry_of(std::size_t, std::size_t i, Entry entry) {
  return entry(i);
}
/// The entries as a list.
template <class Entry>
std::vector<double> column_of(std::size_t n, Entry entry) {
  std::vector<double> column;
  for (std::size_t i = 0; i < n; ++i) column.push_back(entry(i));
  return column;
}
/// The same, as an operation of a compiled function.
template <class Knot>
Traced interval_of(std::size_t n, const Traced& x, Knot knot) {
  return locate(x, column_of(n, knot));
}
/// The same, as an operation of a compiled function.
template <class Entry>
Traced entry_of(std::size_t n, const Traced& i, Entry entry) {
  return pick(i, column_of(n, entry));
}
///@}

}  // namespace freeplay
