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

/// Two turns of a crank at one revolution a second. Body b moves by x = 0.003 sin φ m; the force on
/// p is (3, 4) cos φ N.
void write_turns(const std::filesystem::path& folder) {
  make_folder(folder);
  const std::string scene =
      "[bodies.b]\nmass = 1.0\ninertia = 1.0\n[joints.p]\ntype = \"revolute\"\n"
      "between = [\"ground\", \"b\"]\n"
      "[drives.d]\njoint = \"p\"\nspeed_rpm = 60.0\n[run]\nduration = 2.0\n";
  write_file(folder / "run.json", nlohmann::json{{"formulation", "penalty"},
                                                 {"provenance",
                                                  {{"version", "0"},
                                                   {"commit", "none"},
                                                   {"scene_file", (folder / "scene.toml").string()},
                                                   {"scene", scene},
                                                   {"overrides", nlohmann::json::array()}}}}
                                      .dump());
  std::string trajectory = "t,b.x,b.y,b.theta,b.vx,b.vy,b.omega\n", forces = "t,p.fx,p.fy,p.m\n";
  for (int i = 0; i <= 80; ++i) {
    const double t = 0.025 * i, angle = 2 * std::numbers::pi * t;
    trajectory += fmt::format("{},{},0,{},0,0,{}\n", t, 0.003 * std::sin(angle), angle, 2 * std::numbers::pi);
    forces += fmt::format("{},{},{},0\n", t, 3 * std::cos(angle), 4 * std::cos(angle));
  }
  write_file(folder / "trajectory.csv", trajectory);
  write_file(folder / "forces.csv", forces);
}

/// Rows of a figure's data that are numbers.
std::vector<std::pair<double, double>> rows_of(const std::filesystem::path& file) {
  std::vector<std::pair<double, double>> rows;
  std::istringstream in(test::file_text(file));
  for (std::string line; std::getline(in, line);) {
    std::istringstream numbers(line);
    if (double x, y; numbers >> x >> y) rows.emplace_back(x, y);
  }
  return rows;
}

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

TEST_CASE("freeplay plot draws expressions, folded, in the requested units", "[figures][plot][program]") {
  test::TemporaryFolder folder;
  const auto place = folder.path() / "run";
  write_turns(place);
  const auto run = [&](const std::string& words) {
    return test::freeplay(fmt::format("plot {} -o mine {}", place.string(), words));
  };
  const auto drawn = run("--y 'hypot(p.fx, p.fy)' --over crank_angle --fold");
  INFO(drawn.err);
  REQUIRE(drawn.status == 0);
  auto rows = rows_of(place / "figures/mine.dat");
  REQUIRE(rows.size() == 81);
  for (const auto& [x, y] : rows) {
    CHECK(x >= 0);
    CHECK(x < 360 + 1e-9);
    CHECK(y == Approx(5 * std::abs(std::cos(x * std::numbers::pi / 180))).margin(1e-9));
  }
  auto script = test::file_text(place / "figures/mine.gp");
  CHECK_THAT(script, Contains("set xrange [0:360]") && Contains("'crank angle'") &&
                         Contains("\"(\\302\\260)\"") && Contains("force |F|") && Contains("\"(N)\""));
  // x is at most 3 mm: in mm by itself, in µm on request.
  REQUIRE(run("--y b.x").status == 0);
  CHECK(rows_of(place / "figures/mine.dat")[10].second == Approx(3));
  REQUIRE(run("--y b.x --y b.omega --unit um --unit rpm").status == 0);
  rows = rows_of(place / "figures/mine.dat");
  CHECK(rows[10].second == Approx(3000));
  CHECK(rows[91].second == Approx(60));
  REQUIRE(run("--y b.x --x b.theta --unit x=deg --unit y1=m").status == 0);
  rows = rows_of(place / "figures/mine.dat");
  CHECK(rows[10].first == Approx(90));
  CHECK(rows[10].second == Approx(0.003));

  const auto refused = [&](const std::string& words, const char* what) {
    const auto end = run(words);
    CAPTURE(words, end.err);
    CHECK(end.status == 2);
    CHECK_THAT(end.err, Contains(what));
  };
  refused("--y b.x --unit kg", "no such axis of a mass; the axes are x (s), y1 (m)");
  refused("--y b.x --unit y=kg", "no such axis of a mass");
  refused("--y b.x --unit y1=kg", "is a mass (kg), but axis y1 is a length (m)");
  refused("--y b.x --unit furlong", "is not a known unit");
  refused("--y 'b.x + b.vx'", "+ needs equal dimensions, is of a length (m) and a speed (m/s)");
  refused("--y 'b.x - 1e-3'", "of a length (m) and a pure number; numbers have no unit");
  refused("--y 'b.x < 1e-3'", "is true or false");
  refused("--y 'hypot(b.z, b.x)'", "did you mean b.x?");
  // Without forces.csv the message says how to have a force.
  const std::vector<plots::Column> bare{{"t", "", "s", ""}, {"b.x", "trajectory.csv", "m", ""}};
  for (const char* text : {"d.torque", "2*d.torque", "d.torque_mean"})
    CHECK_THROWS_WITH(plots::formula_of(text, bare), Contains("need a run with --forces"));
  refused("--y b.x --fold", "--fold: t is not an angle");
}

TEST_CASE("a style is a preset, a file, or beside the scene", "[figures][style][program]") {
  test::TemporaryFolder folder;
  const auto place = folder.path() / "run";
  write_turns(place);
  CHECK_FALSE(plots::style_of(place).width);
  write_file(place / "style.toml", "width = 100\n");  // the scene is place/scene.toml
  CHECK(*plots::style_of(place).width == 100);
  make_folder(place / "figures");
  write_file(place / "figures/style.toml", "width = 60\n");
  CHECK(*plots::style_of(place).width == 60);
  write_file(place / "wide.toml", "width = 120\n");
  const auto width = [&](const std::string& style) {
    test::succeeded(fmt::format("plot {} --y b.x -o mine --style {}", place.string(), style));
    const auto script = test::file_text(place / "figures/mine.gp");
    return std::stod(script.substr(script.find("WIDTH = ") + 8));
  };
  CHECK(width((place / "wide.toml").string()) == 12);
  CHECK(width("journal-single") == 8.4);
  CHECK(width("journal-double") == 17.4);
  CHECK(width("slides") == 25.4);
  test::refused(fmt::format("plot {} --y b.x --style journal-singel", place.string()),
                Contains("is neither a file nor a preset; did you mean journal-single?"));
}
