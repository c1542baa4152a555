// Traced: a number that records the operations on it. A template on the scalar, evaluated once with
// Traced, leaves a graph of its operations in the Trace that is active in the thread (trace.hpp),
// from which a compiled function is made (compiled_function.hpp).
//
// Each number carries its value at the sample at which the trace is made. A comparison returns its
// result at the sample and records a guard: the compiled function refuses a state at which any
// comparison has another result. Operations keep the order of the template, and only 0 and ±1 are
// folded, so that the compiled function is bitwise identical to the template.
//
// The operators are never inlined: [[gnu::flatten]] of the templates would otherwise copy the
// bookkeeping into each of them.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

/// @cond internal

namespace freeplay {

enum class Operation {
  constant,
  input,
  add,
  subtract,
  multiply,
  divide,
  negate,
  sqrt,
  abs,
  sin,
  cos,
  exp,
  tanh,
  floor,
  round,
  atan2,
  max,
  // conditions, of which both operands of `both` and `either` are some; and select
  less,
  less_equal,
  equal,
  both,
  either,
  select,
  // look-ups in a table of constants (locate(), pick()): the first result is a whole number
  locate,
  pick,
  // call_outside(): an argument of a call, after another one; the call, of which this is the last argument;
  // and each of its results
  argument,
  outside,
  result
};
enum class Relation { less, less_equal, equal };

/// Thrown if an evaluation uses a number in a way that no compiled function can follow; what()
/// names it.
struct NotTraceable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Traced {
  double value = 0;  ///< at the sample
  int node = -1;     ///< in the active Trace; −1: a constant, which no trace knows yet

  Traced() = default;
  Traced(double x) : value(x) {}
  Traced& operator+=(const Traced& o);
  Traced& operator-=(const Traced& o);
  Traced& operator*=(const Traced& o);
  Traced& operator/=(const Traced& o);
  bool is_constant() const { return node < 0; }
};

/// @name Records an operation, or a comparison whose result is returned
///@{
[[gnu::noinline]] Traced record(Operation operation, const Traced& a, const Traced& b = {});
[[gnu::noinline]] bool compare(const Traced& a, Relation relation, const Traced& b);
///@}

inline Traced operator+(const Traced& a, const Traced& b) { return record(Operation::add, a, b); }
inline Traced operator-(const Traced& a, const Traced& b) { return record(Operation::subtract, a, b); }
inline Traced operator*(const Traced& a, const Traced& b) { return record(Operation::multiply, a, b); }
inline Traced operator/(const Traced& a, const Traced& b) { return record(Operation::divide, a, b); }
inline Traced operator-(const Traced& a) { return record(Operation::negate, a); }
inline Traced& Traced::operator+=(const Traced& o) { return *this = *this + o; }
inline Traced& Traced::operator-=(const Traced& o) { return *this = *this - o; }
inline Traced& Traced::operator*=(const Traced& o) { return *this = *this * o; }
inline Traced& Traced::operator/=(const Traced& o) { return *this = *this / o; }

inline bool operator<(const Traced& a, const Traced& b) { return compare(a, Relation::less, b); }
inline bool operator>(const Traced& a, const Traced& b) { return compare(b, Relation::less, a); }
inline bool operator<=(const Traced& a, const Traced& b) { return compare(a, Relation::less_equal, b); }
inline bool operator>=(const Traced& a, const Traced& b) { return compare(b, Relation::less_equal, a); }
inline bool operator==(const Traced& a, const Traced& b) { return compare(a, Relation::equal, b); }

inline Traced sqrt(const Traced& x) { return record(Operation::sqrt, x); }
inline Traced abs(const Traced& x) { return record(Operation::abs, x); }
inline Traced sin(const Traced& x) { return record(Operation::sin, x); }
inline Traced cos(const Traced& x) { return record(Operation::cos, x); }
inline Traced exp(const Traced& x) { return record(Operation::exp, x); }
inline Traced tanh(const Traced& x) { return record(Operation::tanh, x); }
inline Traced floor(const Traced& x) { return record(Operation::floor, x); }
inline Traced round(const Traced& x) { return record(Operation::round, x); }
/// std::max(a, b)
inline Traced max(const Traced& a, const Traced& b) { return record(Operation::max, a, b); }
inline Traced atan2(const Traced& y, const Traced& x) { return record(Operation::atan2, y, x); }

/// @name Conditions, which are part of the function: it has both results, and no guard. Their value is 1
/// or 0
///@{
[[gnu::noinline]] Traced holds(const Traced& a, Relation relation, const Traced& b);
inline Traced both(const Traced& a, const Traced& b) { return record(Operation::both, a, b); }
inline Traced either(const Traced& a, const Traced& b) { return record(Operation::either, a, b); }
/// `a` where the condition holds, else `b`.
[[gnu::noinline]] Traced select(const Traced& condition, const Traced& a, const Traced& b);
/// Adds a guard that fails where the condition does not hold.
[[gnu::noinline]] void require(const Traced& condition);
///@}

/// @name Look-ups. The numbers of a table are constants of the function, its size is structure
///@{
/// Number of knots, increasing, that are at most x: std::upper_bound. Only pick() may use it.
[[gnu::noinline]] Traced locate(const Traced& x, std::span<const double> knots);
/// Entry `index` of a column.
[[gnu::noinline]] Traced pick(const Traced& index, std::span<const double> column);
///@}

/// A function of numbers that cannot be traced: a search by iteration, or code outside the program.
struct OutsideFunction {
  std::size_t results = 0;
  std::function<void(const double* x, double* y)> evaluate = {};
  /// Whether its results are only a start for an iteration whose last step is traced. The derivatives of what
  /// follows by x and by constants are then complete.
  bool refined = false;
};
/// Its results at x, as numbers without derivatives. Their derivatives, if there are any, must be among them.
/// Throws NotTraceable with `reason` unless the function is only differentiated (TracedObject::unshared()).
std::vector<Traced> call_outside(OutsideFunction function, std::span<const Traced> x, const char* reason);

/// Throws NotTraceable with `reason` unless the function is only differentiated.
void only_differentiated(const char* reason);

/// The value of a constant. Throws NotTraceable for any other number: a search by iteration has no
/// compiled function.
[[gnu::noinline]] double value_of(const Traced& x);

}  // namespace freeplay

/// @endcond
