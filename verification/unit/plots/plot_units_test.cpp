// Units, expressions and folding of plotted columns, against values computed by hand; and the
// choice of a style.
#include "io/scene/quantity.hpp"
#include "plots/drawing/axis.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/drawing/style.hpp"
#include "plots/tables/columns.hpp"
#include "study/settings/expression.hpp"
#include "study/settings/expression_dimension.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

Dimension of(const char* unit) { return dimension_of(unit).value(); }

}  // namespace

TEST_CASE("the dimension of an expression follows from its names", "[figures][plot]") {
  const std::vector<std::string> names{"x", "v", "w", "a.b", "f", "n"};
  const std::vector<Dimension> units{of("m"), of("m/s"), of("rad/s"), of("rad"), of("N"), of("")};
  const auto unit = [&](const char* text) { return si_unit(dimension_of(Expression(text, names), units)); };
  CHECK(unit("hypot(x, 2 * x)") == "m");
  CHECK(unit("w * x - v") == "m/s");
  CHECK(unit("f * v") == "W");
  CHECK(unit("sqrt(x^2 + x * x)") == "m");
  CHECK(unit("a.b - pi / 2") == "rad");
  CHECK(unit("sin(a.b) * n + 1").empty());
  CHECK(unit("f / x") == "N/m");
  for (const char* text : {"x + v", "x + 1", "hypot(x, f)", "max(x, v)", "sin(x)", "exp(f)", "2^x", "x^n"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(unit(text), std::invalid_argument);
  }
  CHECK(Expression("hypot(x, v, f)", names)(std::vector<double>{2, 3, 0, 0, 6, 0}) == Approx(7));
  CHECK(Expression("a.b + 1", names)(std::vector<double>{0, 0, 0, 2, 0, 0}) == 3);
}

TEST_CASE("units of axes are chosen, and fit by themselves", "[figures][plot]") {
  CHECK(plots::fitting_unit("m", 2.5e-4).name == "µm");
  CHECK(plots::fitting_unit("m", 2.5e-4).size == Approx(1e-6));
  CHECK(plots::fitting_unit("m", 0.05).name == "mm");
  CHECK(plots::fitting_unit("m", 0.35).name == "m");
  CHECK(plots::fitting_unit("m", 2e5).name == "10³ m");
  CHECK(plots::fitting_unit("N", 5e4).name == "kN");
  CHECK(plots::fitting_unit("m/s²", 5e6).name == "10⁶ m/s²");
  CHECK(plots::fitting_unit("N", 0).size == 1);
  CHECK(plots::unit_named("rpm", "rad/s").size == Approx(2 * std::numbers::pi / 60));
  CHECK(plots::unit_named("deg", "rad").name == "°");
  CHECK(plots::printed("m/s2") == "m/s²");
  CHECK(plots::printed("kg m^-3") == "kg m⁻³");
  CHECK_THROWS_AS(plots::unit_named("kg", "m"), SceneError);
}

TEST_CASE("tics of an axis are few and short", "[figures][plot]") {
  // A constant, with its rounding: the range is about it, and no label has more than four letters.
  const auto constant = plots::with_tics(plots::axis_of(20.943951023, 20.943951025), 6);
  CHECK(constant.low < 20.5);
  CHECK(constant.high > 21.4);
  CHECK(plots::longest_label(constant) <= 4);
  for (const double range : {1.0, 0.37, 1234.0, 9e-5}) {
    const auto axis = plots::with_tics({0, range}, 5);
    CHECK(range / axis.step <= 5);
    CHECK(range / axis.step > 1.9);
  }
  // Labels tell neighbouring tics apart: 10.00012 has seven digits, eight letters.
  const auto fine = plots::with_tics({10.0001, 10.0002}, 5);
  CHECK(fine.step == Approx(2e-5));
  CHECK(plots::longest_label(fine) == 8);
  CHECK_THAT(plots::commands(fine, "x").text(), Contains("set format x '%.7g'"));
  // 0 to 360°, with 3 letters and a gap of 1.7 for a tic: 45 letters have room for tics at 45°, at 30° they
  // would have 3.75 letters each; 30 letters have room for tics at 60°.
  plots::Axis turn{0, 360};
  turn.turn = true;
  CHECK(plots::with_tics(turn, 10, 45).step == 45);
  CHECK(plots::with_tics(turn, 10, 30).step == 60);
  CHECK(plots::shortened("a long name of a folder", 11) == "a lon…older");
  CHECK(plots::letters("µm²") == 3);
  CHECK(plots::key_grid({"penalty", "nonsmooth", "ideal joint"}, 50).rows == 1);
  CHECK(plots::key_grid({"penalty", "nonsmooth", "ideal joint"}, 35).rows == 2);
}

TEST_CASE("a long key of a single-column figure is in small letters and in the columns that these permit",
          "[figures]") {
  // On 84 mm a key has 8.4 − 4·0.12 = 7.92 cm; a title needs its letters and five more, of 0.157 cm each,
  // or 0.138 cm in small letters (0.88): twelve letters 2.67 cm or 2.35 cm, 23 letters 4.40 cm or 3.87
  // cm, 30 letters 5.50 cm or 4.84 cm.
  plots::Style style;
  style.width = 84;
  const auto script_for = [&](std::size_t length, std::size_t count = 9) {
    plots::PanelStack stack{
        .abscissa = {plots::time_title(), {0, 1}},
        .panels = {{.title = plots::AxisTitle::of("gap", "m"), .axis = {0, 1}, .curves = {}}}};
    stack.panels[0].curves.push_back({plots::Script().add("x with lines"), ""});
    for (std::size_t i = 0; i < count; ++i)
      stack.key.push_back({plots::Script().add("with lines"), std::string(length, 'k')});
    plots::Figure figure{.name = "keyed"};
    plots::add_panels(figure, style, stack);
    CHECK(figure.width_cm == Approx(8.4));
    return figure.script.text();
  };
  const auto usual = script_for(12), narrow = script_for(23), widest = script_for(30);
  // Two columns of five rows would be long; small letters permit three.
  CHECK_THAT(usual, Contains("maxcols 3 maxrows 3") && Contains("spacing 1 font SMALL"));
  CHECK_THAT(narrow, Contains("maxcols 2 maxrows 5") && Contains("spacing 1 font SMALL") &&
                         Contains("set key font ''"));
  CHECK_THAT(widest, Contains("maxcols 1 maxrows 9") && Contains("font SMALL"));
  // Short keys keep their letters.
  CHECK_THAT(script_for(12, 6), Contains("maxcols 2 maxrows 3") && !Contains("font SMALL"));
  CHECK_THAT(script_for(30, 3), Contains("maxcols 1 maxrows 3") && !Contains("font SMALL"));
  // The panel begins below the key: 0.1 cm above it, rows of 0.3 cm times 0.88, 0.1 cm and 0.25 cm.
  CHECK_THAT(narrow, Contains("set tmargin at screen 1 - Y(1.67) "));
}
