#include "study/settings/expression_dimension.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

namespace freeplay {

/// The stack machine of Expression, on dimensions.
class ExpressionDimension {
 public:
  using Op = Expression::Op;

  static Dimension of(const Expression& expression, std::span<const Dimension> names) {
    std::vector<Operand> stack;
    for (const auto& step : expression.steps_) {
      if (step.op == Op::number) {
        stack.push_back({pure, step.number});
      } else if (step.op == Op::name) {
        stack.push_back({names[step.name], {}});
      } else {
        const bool one = step.op == Op::minus || step.op == Op::opposite || step.op == Op::root ||
                         step.op == Op::magnitude || step.op >= Op::sine;
        const auto b = one ? Operand{} : stack.back();
        if (!one) stack.pop_back();
        stack.back() = apply(step.op, stack.back(), b);
      }
    }
    return stack.back().dimension;
  }

 private:
  static constexpr Dimension pure{}, angle{0, 0, 0, 1, 0};
  struct Operand {
    Dimension dimension{};
    std::optional<double> constant{};  ///< value of a number
  };

  /// a + power · b, without the radian if another quantity is left.
  static Dimension product(const Dimension& a, const Dimension& b, double power) {
    Dimension d;
    for (std::size_t i = 0; i < d.size(); ++i) d[i] = a[i] + power * b[i];
    if (d[0] != 0 || d[1] != 0 || d[4] != 0) d[3] = 0;
    return d;
  }
  static Dimension alike(const char* what, const Dimension& a, const Dimension& b) {
    if (a == b || (a == angle && b == pure)) return a;
    if (a == pure && b == angle) return b;
    throw std::invalid_argument(
        fmt::format("{} needs equal dimensions, is of {} and {}{}", what, name_of(a), name_of(b),
                    a == pure || b == pure ? "; numbers have no unit: multiply or divide by one" : ""));
  }
  static void need(const char* what, const Dimension& a, bool fits, const char* wanted) {
    if (!fits) throw std::invalid_argument(fmt::format("{} needs {}, is of {}", what, wanted, name_of(a)));
  }

  static Operand apply(Op op, const Operand& a, const Operand& b) {
    const auto &x = a.dimension, &y = b.dimension;
    switch (op) {
      case Op::minus:
        return {x, a.constant ? std::optional(-*a.constant) : std::nullopt};
      case Op::magnitude:
        return {x, {}};
      case Op::add:
      case Op::subtract:
        return {alike(op == Op::add ? "+" : "-", x, y), {}};
      case Op::multiply:
        return {product(x, y, 1), {}};
      case Op::divide:
        return {product(x, y, -1),
                a.constant && b.constant ? std::optional(*a.constant / *b.constant) : std::nullopt};
      case Op::power:
        need("an exponent", y, y == pure && (b.constant || x == pure), "a number");
        return {product(pure, x, b.constant.value_or(1)), {}};
      case Op::root:
        return {product(pure, x, 0.5), {}};
      case Op::least:
      case Op::greatest:
        return {alike(op == Op::least ? "min" : "max", x, y), {}};
      case Op::hypotenuse:
        return {alike("hypot", x, y), {}};
      case Op::sine:
      case Op::cosine:
        need(op == Op::sine ? "sin" : "cos", x, x == pure || x == angle, "an angle");
        return {};
      case Op::logarithm:
      case Op::exponential:
        need(op == Op::logarithm ? "log" : "exp", x, x == pure, "a pure number");
        return {};
      case Op::less:
      case Op::at_most:
      case Op::more:
      case Op::at_least:
      case Op::equal:
      case Op::differs:
        alike("a comparison", x, y);
        return {};
      case Op::both:
      case Op::either:
      case Op::opposite:
      case Op::number:
      case Op::name:
        break;
    }
    return {};
  }
};

Dimension dimension_of(const Expression& expression, std::span<const Dimension> names) {
  return ExpressionDimension::of(expression, names);
}

}  // namespace freeplay
