// Small expressions of named numbers: what a study filters its cells by and derives from its results.
//
//     or := and {"or" and}      and := not {"and" not}      not := "not" not | sum [("<" | "<=" | ">" | ">=" | "==" | "!=") sum]
//     sum := term {("+" | "-") term}      term := sign {("*" | "/") sign}      sign := ("-" | "+") sign | atom ["^" sign]
//     atom := number | name | function "(" or {"," or} ")" | "(" or ")"
//
// so that −2^2 = −4 and 2^3^2 = 2^9. A truth is no number: `1 < x < 2` and `a and 3` are refused. What has no value (a division by
// zero, the root or logarithm of what has none, an operand that is absent) is absent, which is NaN here and NULL in results;
// nothing else than a finite number comes out. A text is read once into a list of operations on a stack; it names nothing but
// what it is given and does nothing but arithmetic (docs/development/decisions/022-expressions.md).
#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace freeplay {

/// `column`: from 1, where in the text.
struct ExpressionError : std::runtime_error {
  ExpressionError(std::size_t at, const std::string& what)
      : std::runtime_error("column " + std::to_string(at) + ": " + what), column(at) {}
  std::size_t column;
};

class Expression {
 public:
  enum class Type { number, truth };
  static constexpr std::size_t longest = 1000;  ///< bytes
  static constexpr int deepest = 32;            ///< parentheses, signs and powers within each other

  /// Throws ExpressionError; `names`: what it may speak of.
  Expression(std::string_view text, std::span<const std::string> names);

  Type type() const { return type_; }
  /// `values`: of the names, in their order. A truth is 1 or 0; NaN: absent.
  double operator()(std::span<const double> values) const;
  /// Of a truth: false also where it is absent.
  bool holds(std::span<const double> values) const { return (*this)(values) == 1; }
  /// Whether it speaks of the name with this index.
  bool uses(std::size_t name) const;

  /// Whether it can speak of such a name: a letter or _, then letters, digits and _, and none of its own words.
  static bool is_name(std::string_view name);
  /// Its own words: functions, pi, and, or, not.
  static std::vector<std::string> words();

 private:
  friend class ExpressionReader;
  enum class Op : unsigned char {
    number,
    name,
    minus,
    add,
    subtract,
    multiply,
    divide,
    power,
    less,
    at_most,
    more,
    at_least,
    equal,
    differs,
    both,
    either,
    opposite,
    root,
    magnitude,
    least,
    greatest,
    sine,
    cosine,
    logarithm,
    exponential
  };
  struct Step {
    Op op;
    double number = 0;
    std::size_t name = 0;
  };
  static double apply(Op op, double a, double b);

  std::vector<Step> steps_;
  Type type_ = Type::number;
};

}  // namespace freeplay
