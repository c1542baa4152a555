#include "study/settings/expression.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>

#include "io/files/escaping.hpp"
#include "io/scene/schema.hpp"

namespace freeplay {
namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

constexpr std::array constants{std::pair{"pi", std::numbers::pi}};
constexpr std::array logic{"and", "or", "not"};

}  // namespace

/// Recursive-descent parser; one function for each rule of the grammar.
class ExpressionReader {
 public:
  using Op = Expression::Op;
  using Type = Expression::Type;

  ExpressionReader(std::string_view text, std::span<const std::string> names,
                   std::vector<Expression::Step>& to)
      : text_(text), names_(names), steps_(to) {}

  Type whole() {
    if (text_.size() > Expression::longest)
      throw ExpressionError(
          Expression::longest + 1,
          fmt::format("is too long; at most {} characters are allowed", Expression::longest));
    const auto type = alternatives();
    if (blanks(); at_ < text_.size()) fail(fmt::format("\"{}\" is not expected here", next()));
    return type;
  }

  struct Function {
    const char* name;
    Op op;
    bool several;  ///< at least two arguments, else one
  };
  static constexpr std::array functions{
      Function{"sqrt", Op::root, false},       Function{"abs", Op::magnitude, false},
      Function{"min", Op::least, true},        Function{"max", Op::greatest, true},
      Function{"hypot", Op::hypotenuse, true}, Function{"sin", Op::sine, false},
      Function{"cos", Op::cosine, false},      Function{"log", Op::logarithm, false},
      Function{"exp", Op::exponential, false}};

 private:
  [[noreturn]] void fail(const std::string& what) const { throw ExpressionError(at_ + 1, what); }
  [[noreturn]] static void fail_at(std::size_t at, const std::string& what) {
    throw ExpressionError(at + 1, what);
  }

  void blanks() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  /// The next token, for a message.
  std::string next() const {
    std::size_t end = at_;
    while (end < text_.size() && (is_letter(text_[end]) || is_digit(text_[end]))) ++end;
    // Include whole UTF-8 characters only.
    if (end == at_) do
        ++end;
      while (end < text_.size() && (text_[end] & 0xC0) == 0x80);
    return visible(std::string(text_.substr(at_, end - at_)));
  }
  bool take(std::string_view symbol) {
    blanks();
    if (!text_.substr(at_).starts_with(symbol)) return false;
    at_ += symbol.size();
    return true;
  }
  std::string_view word() const {
    std::size_t end = at_;
    if (end < text_.size() && is_letter(text_[end]))
      while (end < text_.size() &&
             (is_letter(text_[end]) || is_digit(text_[end]) ||
              (text_[end] == '.' && end + 1 < text_.size() && is_letter(text_[end + 1]))))
        ++end;
    return text_.substr(at_, end - at_);
  }
  bool take_word(std::string_view wanted) {
    blanks();
    if (word() != wanted) return false;
    at_ += wanted.size();
    return true;
  }

  struct Deeper {
    explicit Deeper(ExpressionReader& reader) : of(reader) {
      if (++of.depth_ > Expression::deepest)
        of.fail(fmt::format("is nested {} deep; at most that is allowed", Expression::deepest));
    }
    ~Deeper() { --of.depth_; }
    Deeper(const Deeper&) = delete;
    Deeper& operator=(const Deeper&) = delete;
    ExpressionReader& of;
  };

  void emit(Op op) { steps_.push_back({op, 0, 0}); }
  static void want(Type wanted, Type found, std::size_t at, const std::string& by) {
    if (found == wanted) return;
    fail_at(at, wanted == Type::number ? fmt::format("{} needs numbers, but this is true or false", by)
                                       : fmt::format("{} needs true or false, but this is a number", by));
  }
  std::size_t here() {
    blanks();
    return at_;
  }

  /// Operands that `next` reads, joined by operators of one rank, from the left.
  Type joined(Type (ExpressionReader::*next)(), Type wanted,
              std::initializer_list<std::pair<const char*, Op>> operators) {
    const auto begin = here();
    const auto type = (this->*next)();
    for (bool more = true; more;) {
      more = false;
      for (const auto& [name, op] : operators) {
        if (!(wanted == Type::truth ? take_word(name) : take(name))) continue;
        want(wanted, type, begin, name);
        const auto second = here();
        want(wanted, (this->*next)(), second, name);
        emit(op);
        more = true;
      }
    }
    return type;
  }
  Type alternatives() {
    const Deeper deeper(*this);
    return joined(&ExpressionReader::conditions, Type::truth, {{"or", Op::either}});
  }
  Type conditions() { return joined(&ExpressionReader::condition, Type::truth, {{"and", Op::both}}); }
  Type condition() {
    const Deeper deeper(*this);
    if (take_word("not")) {
      const auto begin = here();
      want(Type::truth, condition(), begin, "not");
      emit(Op::opposite);
      return Type::truth;
    }
    const auto begin = here();
    const auto type = sum();
    const auto op = comparison();
    if (!op) return type;
    want(Type::number, type, begin, "a comparison");
    const auto second = here();
    want(Type::number, sum(), second, "a comparison");
    emit(*op);
    if (const auto behind = here(); comparison())
      fail_at(behind, "compares true or false; write a < x and x < b");
    return Type::truth;
  }
  std::optional<Op> comparison() {
    for (const auto& [symbol, op] :
         {std::pair{"<=", Op::at_most}, {">=", Op::at_least}, {"==", Op::equal}, {"!=", Op::differs}})
      if (take(symbol)) return op;
    if (take("<")) return Op::less;
    if (take(">")) return Op::more;
    if (take("=")) {
      --at_;
      fail("\"=\" is not a comparison; use ==");
    }
    return std::nullopt;
  }
  Type sum() { return joined(&ExpressionReader::term, Type::number, {{"+", Op::add}, {"-", Op::subtract}}); }
  Type term() {
    return joined(&ExpressionReader::sign, Type::number, {{"*", Op::multiply}, {"/", Op::divide}});
  }
  Type sign() {
    const Deeper deeper(*this);
    const bool minus = take("-");
    if (minus || take("+")) {
      const auto begin = here();
      want(Type::number, sign(), begin, "a sign");
      if (minus) emit(Op::minus);
      return Type::number;
    }
    const auto begin = here();
    const auto type = atom();
    if (!take("^")) return type;
    want(Type::number, type, begin, "^");
    const auto second = here();
    want(Type::number, sign(), second, "^");
    emit(Op::power);
    return Type::number;
  }
  Type atom() {
    if (take("(")) {
      const auto type = alternatives();
      if (!take(")")) expected("\")\"");
      return type;
    }
    if (at_ < text_.size() && (is_digit(text_[at_]) || text_[at_] == '.')) return number();
    const auto name = word();
    if (name.empty()) expected("a number, a name or \"(\"");
    if (const auto found = std::ranges::find(names_, name); found != names_.end()) {
      at_ += name.size();
      steps_.push_back({Op::name, 0, static_cast<std::size_t>(found - names_.begin())});
      return Type::number;
    }
    for (const auto& [constant, value] : constants)
      if (name == constant) {
        at_ += name.size();
        steps_.push_back({Op::number, value, 0});
        return Type::number;
      }
    if (const auto f = std::ranges::find(functions, name, &Function::name); f != functions.end())
      return call(*f);
    std::vector<std::string> known(names_.begin(), names_.end());
    std::ranges::copy(Expression::words(), std::back_inserter(known));
    const auto near = nearest_word(name, known);
    fail(fmt::format("\"{}\" is not a known name{}; there {} {}", name,
                     near.empty() ? "" : fmt::format(", did you mean {}?", near),
                     names_.size() == 1 ? "is" : "are",
                     names_.empty() ? "none" : fmt::format("{}", fmt::join(names_, ", "))));
  }
  [[noreturn]] void expected(const std::string& what) {
    blanks();
    if (at_ == text_.size()) fail(fmt::format("ends where {} is expected", what));
    fail(fmt::format("\"{}\" is found where {} is expected", next(), what));
  }
  Type number() {
    double value = 0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc() || !std::isfinite(value)) fail("is out of the range of numbers");
    at_ = static_cast<std::size_t>(end - text_.data());
    if (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]) || text_[at_] == '.'))
      fail(fmt::format(
          "\"{}\" follows a number; numbers have no units here, they are in the units of the keys", next()));
    steps_.push_back({Op::number, value, 0});
    return Type::number;
  }
  Type call(const Function& f) {
    at_ += std::string_view(f.name).size();
    if (!take("(")) expected(fmt::format("the \"(\" of {}(...)", f.name));
    int arguments = 0;
    do {
      const auto begin = here();
      want(Type::number, alternatives(), begin, f.name);
      if (++arguments > 1 && f.several) emit(f.op);
    } while (take(","));
    if (!take(")")) expected("\")\"");
    if (f.several ? arguments < 2 : arguments != 1)
      fail(fmt::format("{} takes {}, not {}", f.name, f.several ? "two numbers or more" : "one number",
                       arguments));
    if (!f.several) emit(f.op);
    return Type::number;
  }

  std::string_view text_;
  std::span<const std::string> names_;
  std::vector<Expression::Step>& steps_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

Expression::Expression(std::string_view text, std::span<const std::string> names) {
  type_ = ExpressionReader(text, names, steps_).whole();
}

double Expression::apply(Op op, double a, double b) {
  switch (op) {
    case Op::minus:
      return -a;
    case Op::add:
      return a + b;
    case Op::subtract:
      return a - b;
    case Op::multiply:
      return a * b;
    case Op::divide:
      return a / b;
    case Op::power:
      return std::pow(a, b);
    case Op::less:
      return a < b;
    case Op::at_most:
      return a <= b;
    case Op::more:
      return a > b;
    case Op::at_least:
      return a >= b;
    case Op::equal:
      return a == b;
    case Op::differs:
      return a != b;
    case Op::both:
      return a * b;
    case Op::either:
      return std::max(a, b);
    case Op::opposite:
      return 1 - a;
    case Op::root:
      return std::sqrt(a);
    case Op::magnitude:
      return std::abs(a);
    case Op::least:
      return std::min(a, b);
    case Op::greatest:
      return std::max(a, b);
    case Op::hypotenuse:
      return std::hypot(a, b);
    case Op::sine:
      return std::sin(a);
    case Op::cosine:
      return std::cos(a);
    case Op::logarithm:
      return std::log(a);
    case Op::exponential:
      return std::exp(a);
    case Op::number:
    case Op::name:
      break;
  }
  throw std::logic_error("no such operation");
}

double Expression::operator()(std::span<const double> values) const {
  std::vector<double> stack;
  for (const auto& step : steps_) {
    if (step.op == Op::number || step.op == Op::name) {
      stack.push_back(step.op == Op::number ? step.number : values[step.name]);
    } else {
      const bool one = step.op == Op::minus || step.op == Op::opposite || step.op == Op::root ||
                       step.op == Op::magnitude || step.op >= Op::sine;
      const double b = one ? 0 : stack.back();
      if (!one) stack.pop_back();
      double& a = stack.back();
      // Comparisons, min and pow(NaN, 0) would return a number for an absent operand.
      a = std::isnan(a) || std::isnan(b) ? std::nan("") : apply(step.op, a, b);
    }
    if (!std::isfinite(stack.back())) stack.back() = std::nan("");
  }
  return stack.back();
}

bool Expression::uses(std::size_t name) const {
  return std::ranges::any_of(steps_, [&](const Step& s) { return s.op == Op::name && s.name == name; });
}

std::vector<std::string> Expression::words() {
  std::vector<std::string> list;
  for (const auto& f : ExpressionReader::functions) list.emplace_back(f.name);
  for (const auto& constant : constants) list.emplace_back(constant.first);
  list.insert(list.end(), logic.begin(), logic.end());
  return list;
}

bool Expression::is_name(std::string_view name) {
  return !name.empty() && is_letter(name.front()) &&
         std::ranges::all_of(name, [](char c) { return is_letter(c) || is_digit(c); }) &&
         std::ranges::count(words(), std::string(name)) == 0;
}

}  // namespace freeplay
