// `freeplay plot`: expressions of columns, folded over the crank angle, in the requested units and style.
#include <complex>

#include "plots/drawing/style.hpp"
#include "plots/tables/columns.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// run.json of a penalty run of a scene.
void write_run(const std::filesystem::path& folder, const std::string& scene) {
  write_file(folder / "run.json", nlohmann::json{{"formulation", "penalty"},
                                                 {"provenance",
                                                  {{"version", "0"},
                                                   {"commit", "none"},
                                                   {"scene_file", (folder / "scene.toml").string()},
                                                   {"scene", scene},
                                                   {"overrides", nlohmann::json::array()}}}}
                                      .dump());
}

/// Two turns of a crank at one revolution a second. Body b moves by x = 0.003 sin φ m; the force on
/// p is (3, 4) cos φ N.
void write_turns(const std::filesystem::path& folder) {
  make_folder(folder);
  const auto scene = test::body("b", 1, 1) + test::pin("p", "ground", "b") +
                     test::drive("d", "p", "speed_rpm = 60\n") + test::run_for(2);
  write_run(folder, scene);
  std::string trajectory = "t,b.x,b.y,b.theta,b.vx,b.vy,b.omega\n", forces = "t,p.fx,p.fy,p.m\n";
  for (int i = 0; i <= 80; ++i) {
    const double t = 0.025 * i, angle = 2 * std::numbers::pi * t;
    trajectory += fmt::format("{},{},0,{},0,0,{}\n", t, 0.003 * std::sin(angle), angle, 2 * std::numbers::pi);
    forces += fmt::format("{},{},{},0\n", t, 3 * std::cos(angle), 4 * std::cos(angle));
  }
  write_file(folder / "trajectory.csv", trajectory);
  write_file(folder / "forces.csv", forces);
}

/// A guide along the axis a = 0.6 + 0.8 i of a turning body b, as complex numbers: the angle of b is
/// θ = 0.5 + 0.3 t, the position of c on the guide s = 0.2 + 0.1 t². With the points s_b and s_c of the joint,
/// c is at e^{iθ} (s_b + a s − s_c). Controllers hold θ at 0.4 sin 2πt and s at 0.3 m.
void write_guide(const std::filesystem::path& folder) {
  using Complex = std::complex<double>;
  make_folder(folder);
  const auto scene =
      test::body("b", 1, 1) + test::body("c", 1, 1) + test::pin("p", "ground", "b") +
      test::guide("g", "b", "c", {0.6, 0.8}, {0.1, 0.2}, {0.05, -0.02}) + test::harmonic("wave", 0.4, 1.0) +
      test::drive("hold", "p", "target_angle = \"wave\"\nproportional = 1.0\n") +
      test::drive("feed", "g", "target_position = 0.3\nproportional = 1.0\n") + test::run_for(1);
  write_run(folder, scene);
  std::string trajectory = "t,b.x,b.y,b.theta,b.vx,b.vy,b.omega,c.x,c.y,c.theta,c.vx,c.vy,c.omega\n";
  const Complex a{0.6, 0.8}, i{0, 1}, arms = Complex{0.1, 0.2} - Complex{0.05, -0.02};
  for (int k = 0; k <= 8; ++k) {
    const double t = 0.125 * k, angle = 0.5 + 0.3 * t;
    const auto turn = std::polar(1.0, angle), c = turn * (arms + a * (0.2 + 0.1 * t * t)),
               rate = i * 0.3 * c + turn * a * (0.2 * t);
    trajectory += fmt::format("{},0,0,{},0,0,0.3,{},{},{},{},{},0.3\n", t, angle, c.real(), c.imag(), angle,
                              rate.real(), rate.imag());
  }
  write_file(folder / "trajectory.csv", trajectory);
}

/// The first two numbers of the rows of a figure's data.
std::vector<std::pair<double, double>> rows_of(const std::filesystem::path& file) {
  std::vector<std::pair<double, double>> rows;
  for (const auto& block : test::data_blocks(file))
    for (const auto& row : block) rows.emplace_back(row.at(0), row.at(1));
  return rows;
}

}  // namespace

TEST_CASE("a run has the coordinates of its joints, named as in sections", "[figures][plot]") {
  // The pin's bodies are the ground and b: its angle is 2π t, its rate 2π.
  test::TemporaryFolder folder;
  write_turns(folder.path() / "run");
  const plots::RunColumns run(folder.path() / "run");
  const auto read = [&](const char* y) {
    const auto& all = run.all();
    return run.read(plots::formula_of("t", all), plots::formula_of(y, all), -INFINITY, INFINITY, {});
  };
  REQUIRE(run.find("p.angle"));
  CHECK(run.find("p.angle")->unit == "rad");
  CHECK(run.find("p.rate")->unit == "rad/s");
  const auto angle = read("p.angle"), twice = read("p.angle + b.theta"), rate = read("p.rate");
  REQUIRE(angle.x.size() == 81);
  REQUIRE(twice.x.size() == 81);
  for (std::size_t i = 0; i < angle.x.size(); ++i) {
    CHECK(angle.y[i] == Approx(2 * std::numbers::pi * angle.x[i]));
    CHECK(twice.y[i] == Approx(4 * std::numbers::pi * angle.x[i]));
    CHECK(rate.y[i] == Approx(2 * std::numbers::pi));
  }
}

TEST_CASE("a run has the positions of its guides and the errors of its controllers", "[figures][plot]") {
  test::TemporaryFolder folder;
  write_guide(folder.path() / "run");
  const plots::RunColumns run(folder.path() / "run");
  const auto& all = run.all();
  for (const auto& [name, unit] : {std::pair{"g.position", "m"},
                                   {"g.rate", "m/s"},
                                   {"p.angle", "rad"},
                                   {"hold.error", "rad"},
                                   {"feed.error", "m"}}) {
    CAPTURE(name);
    REQUIRE(run.find(name));
    CHECK(run.find(name)->unit == unit);
  }
  CHECK_FALSE(run.find("g.angle"));
  CHECK_FALSE(run.find("p.position"));
  CHECK(*run.find("g.rate")->quantity.name.text() == 'v');
  const auto read = [&](const char* y) {
    return run.read(plots::formula_of("t", all), plots::formula_of(y, all), -INFINITY, INFINITY, {});
  };
  const auto place = read("g.position"), rate = read("g.rate"), feed = read("feed.error"),
             hold = read("hold.error"), sum = read("feed.error + g.position");
  REQUIRE(place.x.size() == 9);
  for (std::size_t k = 0; k < place.x.size(); ++k) {
    const double t = place.x[k], s = 0.2 + 0.1 * t * t;
    CHECK(place.y[k] == Approx(s).margin(1e-14));
    CHECK(rate.y[k] == Approx(0.2 * t).margin(1e-14));
    CHECK(feed.y[k] == Approx(0.3 - s).margin(1e-14));
    CHECK(hold.y[k] == Approx(0.4 * std::sin(2 * std::numbers::pi * t) - (0.5 + 0.3 * t)).margin(1e-14));
    CHECK(sum.y[k] == Approx(0.3).margin(1e-14));
  }
}

TEST_CASE("freeplay plot draws expressions, folded, in the requested units", "[figures][plot]") {
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

  for (const auto& [words, message] :
       {std::pair{"--y b.x --unit kg", "no such axis of a mass; the axes are x (s), y1 (m)"},
        {"--y b.x --unit y=kg", "no such axis of a mass"},
        {"--y b.x --unit y1=kg", "is a mass (kg), but axis y1 is a length (m)"},
        {"--y b.x --unit furlong", "is not a known unit"},
        {"--y 'b.x + b.vx'", "+ needs equal dimensions, is of a length (m) and a speed (m/s)"},
        {"--y 'b.x - 1e-3'", "of a length (m) and a pure number; numbers have no unit"},
        {"--y 'b.x < 1e-3'", "is true or false"},
        {"--y 'hypot(b.z, b.x)'", "did you mean b.x?"},
        {"--y b.x --fold", "--fold: t is not an angle"}})
    test::refused(fmt::format("plot {} -o mine {}", place.string(), words), Contains(message));
  // Without forces.csv the message says how to have a force.
  const std::vector<plots::Column> bare{{"t", "", "s", ""}, {"b.x", "trajectory.csv", "m", ""}};
  for (const char* text : {"d.torque", "2*d.torque", "d.torque_mean"})
    CHECK_THROWS_WITH(plots::formula_of(text, bare), Contains("need a run with --forces"));
}

TEST_CASE("a style is a preset, a file, or beside the scene", "[figures][style]") {
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
