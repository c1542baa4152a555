// Arithmetic and logical expressions of named numbers. Studies use them to filter cells and to
// derive columns of results. The grammar is
//
//     or := and {"or" and}      and := not {"and" not}
//     not := "not" not | sum [("<" | "<=" | ">" | ">=" | "==" | "!=") sum]
//     sum := term {("+" | "-") term}      term := sign {("*" | "/") sign}
//     sign := ("-" | "+") sign | atom ["^" sign]
//     atom := number | name | function "(" or {"," or} ")" | "(" or ")"
//
// so that −2^2 = −4 and 2^3^2 = 2^9. Numbers and truth values are different types: `1 < x < 2` and
// `a and 3` are refused. An undefined result (division by zero, root or logarithm outside its
// domain, absent operand) is absent: NaN here and NULL in results. Every other result is finite.
//
// Use: construct from a text and the permitted names, then call with their values. The constructor
// compiles the text to a list of stack operations, which the object owns. An expression only
// computes; it has no other effect (docs/development/decisions/022-expressions.md). A permitted name
// may contain dots, as columns of results do (slider.x).
#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace freeplay {

/// A syntax or type error. `column`: position in the text, from 1.
struct ExpressionError : std::runtime_error {
  ExpressionError(std::size_t at, const std::string& what)
      : std::runtime_error("column " + std::to_string(at) + ": " + what), column(at) {}
  std::size_t column;
};

/// A compiled expression.
class Expression {
 public:
  enum class Type { number, truth };
  static constexpr std::size_t longest = 1000;  ///< limit of the text's length, bytes
  /// Limit of the nesting of parentheses, signs and powers.
  static constexpr int deepest = 32;

  /// Compiles a text. `names`: the permitted names. Throws ExpressionError.
  Expression(std::string_view text, std::span<const std::string> names);

  Type type() const { return type_; }
  /// Evaluates. `values`: of the names, in their order; NaN if absent. A truth value is returned as
  /// 1 or 0, an absent result as NaN.
  double operator()(std::span<const double> values) const;
  /// Whether a truth value is true; false if it is absent.
  bool holds(std::span<const double> values) const { return (*this)(values) == 1; }
  /// Whether the expression contains the name with this index.
  bool uses(std::size_t name) const;

  /// Whether a text can be a name: a letter or _, then letters, digits and _, and not a reserved
  /// word.
  static bool is_name(std::string_view name);
  /// Reserved words: functions, pi, and, or, not.
  static std::vector<std::string> words();

 private:
  friend class ExpressionReader;
  friend class ExpressionDimension;
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
    hypotenuse,
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
