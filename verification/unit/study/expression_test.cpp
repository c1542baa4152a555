// Expressions of a study: their values, undefined values, and refusals with their place.
#include "study/settings/expression.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

const std::vector<std::string> names{"clearance", "speed", "peak_max", "x"};

double value(const std::string& text, const std::vector<double>& values = {2e-4, 100, 50, -3}) {
  return Expression(text, names)(values);
}
std::string refusal(const std::string& text) {
  return test::refusal_of<ExpressionError>([&] { Expression(text, names); });
}

}  // namespace

TEST_CASE("expressions have the values of arithmetic", "[expression]") {
  CHECK(value("1 + 2*3 - 4/2") == 5);
  CHECK(value("(1 + 2)*3") == 9);
  CHECK(value("2 - 3 - 4") == -5);
  CHECK(value("16/4/2") == 2);
  CHECK(value("-2^2") == -4);
  CHECK(value("2^3^2") == 512);
  CHECK(value("2^-1") == 0.5);
  CHECK(value("--x") == -3);
  CHECK(value("1.5e-3") == 1.5e-3);
  CHECK(value(".5") == 0.5);
  CHECK(value("abs(x) + min(3, 1, 2) + max(1, 2)") == 6);
  CHECK(value("sqrt(16)") == 4);
  CHECK(value("cos(pi)") == -1);
  CHECK(value("sin(pi/6)") == Approx(0.5));
  CHECK(value("log(exp(1.5))") == Approx(1.5));
  CHECK(value("speed*clearance") == 100 * 2e-4);
  CHECK(value("clearance < 2e-3 and speed*clearance > 1") == 0);
  CHECK(value("clearance < 2e-3 and speed*clearance > 1e-2") == 1);
  CHECK(value("not x > 0 or 1 == 2") == 1);
  CHECK(value("not (x < 0 and speed >= 100)") == 0);
  CHECK(value("1 <= 1 and 1 != 2 and 1 >= 1") == 1);
  CHECK(value("2 < 1 or 1 < 2 and 2 < 1") == 0);  // and takes precedence
  CHECK(Expression("x < 1", names).type() == Expression::Type::truth);
  CHECK(Expression("x + 1", names).type() == Expression::Type::number);
  CHECK(Expression("x + speed", names).uses(3));
  CHECK_FALSE(Expression("x + speed", names).uses(0));
}

TEST_CASE("an undefined value is absent and propagates", "[expression]") {
  for (const char* text : {"1/0", "1/(speed - 100)", "0/0", "sqrt(x)", "log(0)", "log(x)", "x^0.5",
                           "exp(1e6)", "1e308*10", "0*(1/0)", "min(1, 1/0)", "(1/0)^0", "abs(sqrt(x))"})
    CHECK(std::isnan(value(text)));
  for (const char* text :
       {"1/0 > 1", "1/0 < 1", "1/0 != 1", "not 1/0 > 1", "1/0 > 1 or 1 < 2", "1/0 > 1 and 1 < 2"}) {
    CAPTURE(text);
    const Expression e(text, names);
    const std::vector<double> values{1, 1, 1, 1};
    CHECK(std::isnan(e(values)));
    CHECK_FALSE(e.holds(values));
  }
  CHECK(std::isnan(value("peak_max + 1", {1, 1, std::nan(""), 1})));
  CHECK(std::isnan(value("max(peak_max, 1)", {1, 1, std::nan(""), 1})));
  CHECK(value("speed + 1", {1, 1, std::nan(""), 1}) == 2);
}

TEST_CASE("an invalid expression is refused at its column", "[expression]") {
  const auto says = [](const std::string& text, const std::string& what) {
    CAPTURE(text, refusal(text));
    CHECK_THAT(refusal(text), Contains(what));
  };
  says("spede + 1", "column 1: \"spede\" is not a known name, did you mean speed?");
  says("1 + spede", "column 5: \"spede\"");
  says("1 +", "column 4: ends where a number, a name or \"(\" is expected");
  says("", "column 1: ends where");
  says("(1 + 2", "column 7: ends where \")\" is expected");
  says("1 + 2)", "column 6: \")\" is not expected here");
  says("1 2", "column 3: \"2\" is not expected here");
  says("2 mm", "column 3: \"mm\" is not expected here");
  says("2mm", "column 2: \"mm\" follows a number; numbers have no units here");
  says("1.2.3", "follows a number");
  says("1e400", "is out of the range of numbers");
  says("1 < x < 2", "column 7: compares true or false");
  says("x = 1", "column 3: \"=\" is not a comparison; use ==");
  says("x and speed > 1", "column 1: and needs true or false, but this is a number");
  says("speed > 1 and x", "column 15: and needs true or false");
  says("(x > 1) + 1", "column 1: + needs numbers, but this is true or false");
  says("-(x > 1)", "a sign needs numbers");
  says("not x", "column 5: not needs true or false");
  says("sqrt(1, 2)", "sqrt takes one number, not 2");
  says("min(1)", "min takes two numbers or more, not 1");
  says("sqrt 4", "the \"(\" of sqrt(...) is expected");
  says("tan(1)", "\"tan\" is not a known name");
  says("system(1)", "\"system\" is not a known name");
  says("x; 1", "column 2: \";\" is not expected here");
  says("\"a\"", "column 1: \"\"\" is found where a number");
  says("x \xc3\xa9", "column 3:");
  says(std::string(1001, '1'), "column 1001: is too long; at most 1000 characters are allowed");
  says(fmt::format("{:(>100}1{:)>100}", "", ""), "deep; at most that is allowed");
  says(fmt::format("{:->500}1", ""), "deep; at most that is allowed");
  says(
      "not not not not not not not not not not not not not not not not not not not not x > 1 or not not "
      "not not not "
      "not not not not not not not not not not not not not not not not not not not not not not not not "
      "not not x > 1",
      "deep; at most that is allowed");
  // As long as it may be, and as flat, it is read.
  std::string sum = "1";
  while (sum.size() + 2 <= Expression::longest) sum += "+1";
  const auto ones = sum.size() / 2 + 1;
  CHECK(value(sum) == static_cast<double>(ones));
}

TEST_CASE("names that expressions accept", "[expression]") {
  for (const char* good : {"a", "_x1", "Peak"}) CHECK(Expression::is_name(good));
  for (const char* bad : {"", "1a", "a-b", "a b", "pi", "and", "sqrt", "\xc3\xa9"})
    CHECK_FALSE(Expression::is_name(bad));
}
