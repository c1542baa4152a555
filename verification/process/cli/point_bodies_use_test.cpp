// Point bodies in every use of a run: snapshots and restarts, ensembles, constraint drift,
// animations, report pages and figures.
#include <regex>

#include "plots/film/film_drawing.hpp"
#include "plots/report/page.hpp"
#include "plots/tables/run_facts.hpp"
#include "plots/tables/table.hpp"
#include "study/comparison/drift.hpp"
#include "study/ensemble/ensemble.hpp"
#include "verification/property/comparison/snapshot_check.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

constexpr double length = 0.3, clearance = 0.5e-3;  // m, of the scene

/// A crank at 120 rpm, a point mass in a bearing with clearance at its end, and another on a rod
/// below that.
std::string loose_pin() { return snapshots::text("point_on_loose_pin"); }

/// Two point masses on rods side by side, which touch at their radii twice in 1.5 s.
const std::string cradle = "gravity = [0, -9.81]\n" + test::point("left", -0.3, -0.7416198487095663) +
                           test::point("right", 0.02, -0.8, 0.4) + test::rod("one", "ground", "left", 0.8) +
                           test::rod("two", "ground", "right", 0.8) + "at = [[0.02, 0], [0, 0]]\n" +
                           test::discs("balls", "left", "right", 0.01, 0.01) +
                           test::surface("s", 0.8, "young = 2e9\npoisson = 0.3\n") + test::run_for(1.5);

/// A chain of this number of point masses, its links of 0.1 m at 30° up and down. 40 rows of rods:
/// the sparse solve.
std::string chain(int points) {
  std::string text = "gravity = [0, -9.81]\n", before = "ground";
  double y = 0;
  for (int i = 0; i < points; ++i) {
    y += i % 2 == 0 ? -0.05 : 0.05;
    const auto name = fmt::format("p{}", i);
    text += test::point(name, 0.1 * std::sqrt(0.75) * (i + 1), y, 0.1) +
            test::rod(fmt::format("r{}", i), before, name, 0.1);
    before = name;
  }
  return text + test::run_for(0.2);
}

/// A comparison of the pin with clearance over its 0.5 revolutions with forces, by the command.
const std::filesystem::path& comparison() {
  static const test::TemporaryFolder folder;
  static const auto outcome =
      test::freeplay(fmt::format("compare {} --forces -o {}", test::scene_file("point_on_loose_pin").string(),
                                 (folder.path() / "two").string()));
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  static const auto place = folder.path() / "two";
  return place;
}

}  // namespace

TEST_CASE("a run with point bodies continues from any step bit for bit", "[points][snapshot]") {
  using namespace snapshots;
  check({loose_pin(), "penalty", {}, {flight, contact}});
  for (const auto* scheme : {"automatic", "event-driven"})
    check({loose_pin(), "nonsmooth", {fmt::format("nonsmooth.scheme={}", scheme)}, {flight, contact}});
  check({loose_pin(),
         "nonsmooth",
         {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-4", "run.revolutions=0.2"},
         {flight, contact}});
  check({cradle, "penalty", {}, {flight, contact}});
  check({cradle, "nonsmooth", {}, {flight}});
  check({chain(40), "penalty"});
  check({chain(40), "nonsmooth"});
}

// A start varies the position of the bob in its bearing: the rod keeps its length, and the points
// have no angle. Each start, run by itself, equals that of the ensemble to the bit.
TEST_CASE("an ensemble places a point body in its bearing and turns none", "[points][ensemble]") {
  const auto scene = parse_scene(loose_pin(), "loose.toml", {"run.revolutions=0.1"});
  const EnsemblePlan plan{
      .starts = 4,
      .rows = 5,
      .columns = {"bob.theta", "bob.omega", "tail.theta", "bob.x", "bob.y", "tail.x", "tail.y"}};
  const auto all = run_ensemble(scene, plan, {});
  REQUIRE(all.finished() == 4);
  for (std::size_t row = 0; row < all.t.size(); ++row)
    for (const std::size_t angle : {0u, 1u, 2u}) {
      CHECK(all.band(row, angle).of.least == 0);
      CHECK(all.band(row, angle).of.greatest == 0);
    }
  CHECK(all.band(0, 3).of.greatest > all.band(0, 3).of.least);
  std::vector<double> last;
  for (int k = 0; k < 4; ++k) {
    const auto moved = perturbed(scene, {}, plan.seed, k, plan.how);
    Simulation simulation(moved, plan.formulation, {.matched = true});
    const auto q = simulation.state().q;
    CHECK(std::hypot(q[3] - q[6], q[4] - q[7]) == Approx(length).epsilon(1e-14));
    CHECK(std::hypot(q[3] - 0.2, q[4]) <= plan.how.play * clearance * (1 + 1e-12));
    simulation.run();
    last.push_back(simulation.state().q[6]);
  }
  CHECK(*std::ranges::min_element(last) == all.band(4, 5).of.least);
  CHECK(*std::ranges::max_element(last) == all.band(4, 5).of.greatest);
}

// A pendulum of 1 s in all three stabilisations at a tolerance of 1e-7 of 0.8 m and some dozens of
// steps: the rod's length is accurate to 1e-5 m without stabilisation, to rounding (some hundreds
// of it) with projection. A point's angle is exactly zero.
TEST_CASE("the constraint drift of a point body is that of its rod alone", "[points][drift]") {
  const test::TemporaryFolder folder;
  const auto scene = parse_scene("gravity = [0, -9.81]\n" + test::point("bob", 0.8, 0) +
                                     test::rod("string", "ground", "bob", 0.8) + test::run_for(1),
                                 "bob.toml", {"penalty.tolerance=1e-7"});
  const auto runs = measure_drift(scene, {}, folder.path(), {});
  REQUIRE(runs.size() == 3);
  for (const auto& run : runs) {
    CAPTURE(run.stabilisation);
    CHECK(run.ending.status == Ending::Status::finished);
    CHECK(run.greatest_angle == 0);
    CHECK(run.greatest_length <= (run.stabilisation == "projection" ? 1e-13 : 1e-5));
    CHECK(std::abs(run.closure) <= 1e-4 * 0.7 * 9.81 * 0.8);
  }
  CHECK(runs.front().greatest_length > 0);
}

// The check uses the geometry of the scene: in every frame the tail is drawn at the end of a line
// of the rod's length from the bob, and both are at their positions in trajectory.csv.
TEST_CASE("an animation draws point bodies at their positions and rods between them", "[points][animate]") {
  for (const auto* formulation : {"penalty", "nonsmooth"}) {
    CAPTURE(formulation);
    const auto folder = comparison() / formulation;
    std::vector<report::FilmRun> runs{report::film_run(plots::runs_in(folder).front(), 100'000)};
    REQUIRE(runs[0].bodies == std::vector<std::string>{"crank", "bob", "tail"});
    const report::FilmDrawing drawing(runs, {.title = "t"});
    const double scale = drawing.place(0, {1, 0}).x() - drawing.place(0, {0, 0}).x();  // px/m
    plots::Rows rows(folder / "trajectory.csv");
    const auto value = [&](const char* column) { return rows.number(rows.place(column)); };
    int seen = 0;
    for (int i = 0; rows.next(); ++i) {
      CHECK(value("bob.theta") == 0);
      CHECK(value("tail.omega") == 0);
      if (i % 2000 != 0) continue;
      ++seen;
      const auto svg = drawing.frame(value("t"), 0);
      CHECK_THAT(svg, !Contains("nan") && !Contains("inf\""));
      // The panel's corner is (0, 34). The tail has the third colour, the rod its first body's, the
      // second.
      const std::regex dot("<circle cx=\"([-0-9.]+)\" cy=\"([-0-9.]+)\" r=\"2.50\" fill=\"#008a68\""),
          line(
              "<polyline points=\"([-0-9.]+),([-0-9.]+) ([-0-9.]+),([-0-9.]+)\" fill=\"none\" "
              "stroke=\"#c8770a\"");
      std::smatch found;
      REQUIRE(std::regex_search(svg, found, dot));
      const auto tail = drawing.place(0, {value("tail.x"), value("tail.y")}),
                 bob = drawing.place(0, {value("bob.x"), value("bob.y")});
      CHECK(std::stod(found[1]) == Approx(tail.x()).margin(0.02));
      CHECK(std::stod(found[2]) == Approx(tail.y() - 34).margin(0.02));
      REQUIRE(std::regex_search(svg, found, line));
      const double x0 = std::stod(found[1]), y0 = std::stod(found[2]), x1 = std::stod(found[3]),
                   y1 = std::stod(found[4]);
      CHECK(x0 == Approx(bob.x()).margin(0.02));
      CHECK(y0 == Approx(bob.y() - 34).margin(0.02));
      CHECK(std::hypot(x1 - x0, y1 - y0) == Approx(length * scale).margin(0.03));
    }
    CHECK(seen >= 5);
  }
}

TEST_CASE("report page and figures of a run with point bodies show their motion and the force of their rod",
          "[points][report][figures]") {
  const auto& folder = comparison();
  test::succeeded("report " + folder.string());
  const auto page = test::file_text(folder / "report.html");
  const std::string mark = "id=\"data\">";
  const auto from = page.find(mark) + mark.size();
  const auto data = json::parse(page.substr(from, page.find("</script>", from) - from));
  for (const auto& run : data["runs"]) {
    const auto& motion = run["motion"];
    CHECK(motion["bodies"] == json({"crank", "bob", "tail"}));
    REQUIRE(motion["poses"].size() == 9);
    const auto& x = motion["poses"];
    for (std::size_t i = 0; i < motion["t"].size(); ++i) {
      CHECK(x[5][i] == 0);  // θ of bob and tail
      CHECK(x[8][i] == 0);
      // The page has single precision, some 1e-7 of half a metre.
      CHECK(std::hypot(x[3][i].get<double>() - x[6][i].get<double>(),
                       x[4][i].get<double>() - x[7][i].get<double>()) == Approx(length).margin(1e-6));
    }
  }
  for (const char* figure : {"acceleration.pdf", "journal_orbit.pdf", "reaction_string.pdf"})
    CHECK(std::filesystem::exists(folder / "figures" / figure));
  // A rod transmits force along itself only: its force on the tail and the direction to the bob are
  // parallel, and its couple is zero.
  for (const auto* formulation : {"penalty", "nonsmooth"}) {
    CAPTURE(formulation);
    plots::Rows forces(folder / formulation / "forces.csv"), path(folder / formulation / "trajectory.csv");
    const auto force = [&](const char* column) { return forces.number(forces.place(column)); };
    const auto value = [&](const char* column) { return path.number(path.place(column)); };
    bool more = path.next();
    int compared = 0;
    while (forces.next()) {
      CHECK(force("string.m") == 0);
      CHECK(force("bob.alpha") == 0);
      while (more && value("t") < force("t")) more = path.next();
      if (!more || value("t") != force("t")) continue;
      ++compared;
      const double dx = value("bob.x") - value("tail.x"), dy = value("bob.y") - value("tail.y");
      const double size = std::hypot(force("string.fx"), force("string.fy"));
      // Rounding of coordinates of half a metre against the rod: 1e-15; the bound leaves three
      // digits.
      CHECK(std::abs(force("string.fx") * dy - force("string.fy") * dx) <= 1e-12 * std::max(size, 1.0));
      // Newton's law of the tail: m a = f + m g.
      CHECK(std::abs(0.2 * force("tail.ax") - force("string.fx")) <= 1e-9 * std::max(size, 1.0));
      CHECK(std::abs(0.2 * (force("tail.ay") + 9.81) - force("string.fy")) <= 1e-9 * std::max(size, 1.0));
    }
    CHECK(compared > 100);
  }
}
