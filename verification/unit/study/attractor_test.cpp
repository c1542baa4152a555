// Attractors of motions: identified by their section points, over a parameter and over starts, and
// after an interruption.
#include <fmt/ranges.h>
#include <atomic>

#include "study/attractors/attractor_table.hpp"
#include "verification/references/orbits.hpp"
#include "verification/support/ball_study.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;

namespace {

constexpr double pi = std::numbers::pi;

/// x' = r x (1 − x), after the transient.
std::vector<double> logistic(double r, int count) {
  double x = 0.3;
  for (int i = 0; i < 20000; ++i) x = r * x * (1 - x);
  std::vector<double> rows;
  for (int i = 0; i < count; ++i) rows.push_back(x = r * x * (1 - x));
  return rows;
}

/// The orbit of one impact in a period at the strength Γ = A ω²/g, which is A in mm.
reference::ShakenBall orbit_at(double strength, double restitution = 0.8) {
  return {strength * 1e-3L, std::sqrt(9810.0L), 9.81L, restitution};
}
const double birth = 1e3 * static_cast<double>(orbit_at(1).fold());  // Γ above which the orbit exists
const auto ball_scene = test::source_folder() / "cases/ball-on-table/scene.toml";

/// That orbit half a period before an impact: the ball at its top.
std::string at_top(double strength, double restitution = 0.8) {
  const auto orbit = orbit_at(strength, restitution);
  const auto phase = static_cast<double>(orbit.phase()), period = static_cast<double>(orbit.period());
  return fmt::format(
      "\"curves.shake.phase={}\", \"bodies.ball.position=[0, {}]\", \"surfaces.hard.restitution={}\", "
      "\"nonsmooth.scheme='event-driven'\"",
      phase + pi, 0.01 + strength * 1e-3 * std::sin(phase) + 9.81 * period * period / 8, restitution);
}

std::string ball_study(const std::string& set, const std::vector<double>& strengths,
                       const std::string& more) {
  std::vector<double> amplitudes;
  for (const double s : strengths) amplitudes.push_back(s * 1e-3);
  return fmt::format(
      "scene = \"{}\"\n[axes.strength]\nkey = \"curves.shake.amplitude\"\nvalues = [{}]\nscale = 1000\n"
      "[bifurcation]\nsection = \"each touch\"\ncolumns = [\"phase\", \"approach\"]\nset = [{}]\n{}",
      ball_scene.string(), fmt::join(amplitudes, ", "), set, more);
}

SettledRuns run_bifurcation(const Study& study, const std::filesystem::path& file) {
  AttractorStore store(file, {});
  return settle(study, *study.bifurcation, "bifurcation", bifurcation_chains(study), store, 2, {}, {});
}

/// All rows of a file, in sorted order.
std::vector<std::string> contents(const std::filesystem::path& file) {
  const Database database(file, Database::Access::read);
  std::vector<std::string> rows;
  for (const char* query : {"SELECT run, branch, x, y, failure, doubt, t_end FROM runs ORDER BY run",
                            "SELECT run, point, t, name, value FROM points ORDER BY run, point, name",
                            "SELECT run, part, place, value FROM ends ORDER BY run, part, place"}) {
    Database::Statement s(database, query);
    while (s.step())
      rows.push_back(fmt::format("{} {} {} {} {}", s.text(0), s.text(1), s.text(2), s.text(3), s.text(4)));
  }
  return rows;
}

}  // namespace

TEST_CASE("periods of the logistic map are identified", "[attractors]") {
  const Likeness likeness{.circles = {0}, .tolerance = 1e-4, .most = 16};
  // Known (May, Nature 261 (1976) 459): 1 below 3, 2 up to 1 + √6, 4 at 3.5, 3 from 1 + √8 on,
  // chaos at 3.9.
  const std::map<double, int> known = {{2.9, 1},  {3.2, 2},  {3.5, 4},
                                       {3.55, 8}, {3.83, 3}, {3.9, Attractor::aperiodic}};
  for (const auto& [r, period] : known) {
    CAPTURE(r);
    CHECK(attractor_of(logistic(r, 60), likeness).period == period);
  }
  // The two points of period 2, in closed form, in either order.
  const double r = 3.2, root = std::sqrt((r - 3) * (r + 1));
  const Attractor two{2, {(r + 1 + root) / (2 * r), (r + 1 - root) / (2 * r)}, {1}};
  for (const int count : {60, 61}) CHECK(same(attractor_of(logistic(r, count), likeness), two, likeness));
  CHECK_FALSE(same(attractor_of(logistic(3.21, 60), likeness), two, likeness));
  CHECK(attractor_of({}, likeness).period == Attractor::none);
  // Fewer than three cycles are no proof of a period.
  CHECK(attractor_of(logistic(3.2, 5), likeness).period == Attractor::aperiodic);
  CHECK(attractor_of(logistic(3.2, 6), likeness).period == 2);
}

TEST_CASE("slow convergence to an attractor is distinguished from its attainment", "[attractors]") {
  const Likeness likeness{.circles = {0, 1}, .tolerance = 1e-3, .most = 16};
  const auto towards = [](double about, double begin, double factor, double split) {
    std::vector<double> rows;
    for (int i = 0; i < 60; ++i) {
      const double x = about + begin * std::pow(factor, i) + (i % 2 == 1 ? split : -split);
      rows.insert(rows.end(), {x, 0.5 * x});
    }
    return rows;
  };
  const auto reached = attractor_of(towards(1, 0, 0, 0), likeness);
  REQUIRE(reached.period == 1);
  // An orbit of one period with an eigenvalue of −0.97: two alternating points, 4e-3 apart at the
  // end, are recognised as one.
  for (const double begin : {0.012, -0.012, 0.004}) {
    const auto nearing = attractor_of(towards(1, begin, -0.97, 0), likeness);
    CHECK(nearing.period == 1);
    CHECK(same(nearing, reached, likeness));
  }
  // From one side, 6e-3 away at the end.
  CHECK(same(attractor_of(towards(1, 0.02, 0.98, 0), likeness), reached, likeness));
  // Two points that remain that close to each other are two, approached or reached.
  for (const double begin : {0.0, 0.004}) {
    const auto two = attractor_of(towards(1, begin, 0.97, 0.002), likeness);
    CHECK(two.period == 2);
    CHECK_FALSE(same(two, reached, likeness));
  }
}

TEST_CASE("angles and phases are compared on their circle", "[attractors]") {
  const Likeness likeness{.circles = {1}, .tolerance = 1e-3, .most = 4};
  const std::vector<double> around{0.0001, 0.9999, 0.0001, 0.9999, 0.0001, 0.9999};
  CHECK(attractor_of(around, likeness).period == 1);
  const Likeness line{.circles = {0}, .tolerance = 1e-3, .most = 4};
  CHECK(attractor_of(around, line).period == 2);
}

TEST_CASE("the period of a bouncing ball doubles at the strength of its closed form", "[attractors]") {
  // Bracketed to half a hundredth on either side: there the eigenvalue differs from −1 by some
  // 0.05, which leaves 1e-7 after 300 periods.
  for (const double e : {0.7, 0.8, 0.9}) {
    CAPTURE(e);
    const double doubling = 1e3 * static_cast<double>(orbit_at(1, e).flip()),
                 approach = static_cast<double>(orbit_at(1, e).approach());
    const test::StudyDesk desk;
    const auto study = desk.read(
        ball_study(at_top(0.98 * doubling, e),
                   {0.98 * doubling, 0.99 * doubling, 0.995 * doubling, 1.005 * doubling, 1.01 * doubling},
                   "direction = \"up\"\ndiscard = 400\nkeep = 40\n"));
    const auto runs = run_bifurcation(study, desk.at("a.db"));
    const int expected[] = {1, 1, 1, 2, 2};
    for (std::size_t i = 0; i < 5; ++i) {
      CAPTURE(i);
      const auto& run = runs.chains[0][i];
      REQUIRE(run.finished());
      CHECK(run.attractor.period == expected[i]);
      if (expected[i] == 1) CHECK(run.attractor.points[1] == Approx(approach).epsilon(1e-5));
    }
  }
}

TEST_CASE("coexisting attractors, a resting and a bouncing ball, are both found", "[attractors]") {
  // The ball rests while Γ < 1; the orbit of one impact in a period exists from π (1 − e)/(1 + e)
  // on. With increasing Γ the ball rests; with decreasing Γ from 0.96 it bounces until the orbit
  // ceases to exist.
  REQUIRE(birth == Approx(0.349).margin(1e-3));
  std::vector<double> strengths = {0.33, 0.34};
  for (int i = 0; i <= 12; ++i) strengths.push_back(0.36 + 0.05 * i);
  const test::StudyDesk desk;
  const auto study =
      desk.read(ball_study(at_top(0.96), strengths, "direction = \"both\"\ndiscard = 200\nkeep = 20\n"));
  const auto runs = run_bifurcation(study, desk.at("a.db"));
  const auto outcome = attractors_at_each_value(runs);
  const auto n = strengths.size();
  for (std::size_t i = 0; i < n; ++i) {
    CAPTURE(strengths[i]);
    const auto &up = runs.chains[0][i], &down = runs.chains[1][n - 1 - i];
    REQUIRE(up.values[0] == down.values[0]);
    CHECK(up.attractor.period == Attractor::none);
    CHECK(down.attractor.period == (strengths[i] > birth ? 1 : Attractor::none));
    CHECK(outcome.of[1][n - 1 - i] == (strengths[i] > birth ? 1 : 0));
  }
  const auto text = bifurcation_text(study, runs, outcome);
  CHECK_THAT(text, Catch::Contains("several attractors at one value: 0.36 to 0.96"));
}

TEST_CASE("a bifurcation study that is stopped and resumed gives the same points", "[attractors]") {
  const test::StudyDesk desk;
  const auto study =
      desk.read(ball_study(at_top(0.9), {0.5, 0.6, 0.7, 0.8, 0.9}, "discard = 20\nkeep = 10\nstarts = 1\n"));
  const auto whole = run_bifurcation(study, desk.at("whole.db"));
  CHECK(whole.made == 15);
  std::size_t found = 0;
  for (int tries = 0; tries < 20 && found < 15; ++tries) {
    std::atomic<bool> stop{false};
    AttractorStore store(desk.at("parts.db"), StopToken(stop));
    const auto runs =
        settle(study, *study.bifurcation, "bifurcation", bifurcation_chains(study), store, 2, StopToken(stop),
               [&](std::size_t done, std::size_t) { stop = done >= found + 3; });
    found = runs.found + runs.made;
  }
  const auto again = run_bifurcation(study, desk.at("parts.db"));
  CHECK(again.made == 0);
  CHECK(again.found == 15);
  CHECK(contents(desk.at("parts.db")) == contents(desk.at("whole.db")));
  CHECK(bifurcation_csv(study, again, attractors_at_each_value(again)) ==
        bifurcation_csv(study, whole, attractors_at_each_value(whole)));
}

TEST_CASE("a received database whose runs are not whole or have impossible values is refused",
          "[attractors][security]") {
  const test::StudyDesk desk;
  const auto study = desk.read(ball_study(at_top(0.9), {0.8, 0.9}, "discard = 20\nkeep = 10\n"));
  const auto good = desk.at("good.db"), bad = desk.at("bad.db");
  CHECK(run_bifurcation(study, good).made == 4);
  const std::string first = " WHERE rowid = (SELECT min(rowid) FROM ";
  std::vector<std::string> attacks{
      "UPDATE points SET name = 'other'",
      "UPDATE points SET point = 5",
      "UPDATE points SET t = -1",
      "UPDATE points SET t = 1e12",
      "UPDATE ends SET part = 'z'",
      "UPDATE ends SET value = 1e12",
      "UPDATE ends SET value = NULL",
      "UPDATE ends SET value = 9e999",
      "UPDATE runs SET t_end = 1e12",
      "UPDATE runs SET t_end = NULL",
      "UPDATE runs SET t_end = 0.01",
      "UPDATE runs SET failure = zeroblob(100000)",
      "DELETE FROM ends",
  };
  for (const std::string table : {"points", "ends"}) {
    attacks.push_back("DELETE FROM " + table + first + table + ")");
    attacks.push_back("DELETE FROM " + table + " WHERE rowid = (SELECT max(rowid) FROM " + table + ")");
    attacks.push_back("INSERT INTO " + table + " SELECT * FROM " + table);
    for (const char* value : {"'text'", "zeroblob(8)", "zeroblob(100000)", "1e300"})
      attacks.push_back("UPDATE " + table + " SET value = " + value);
  }
  for (const auto& sql : attacks) {
    CAPTURE(sql);
    std::filesystem::copy_file(good, bad, std::filesystem::copy_options::overwrite_existing);
    test::execute(bad, sql);
    try {
      run_bifurcation(study, bad);
      FAIL_CHECK("is used");
    } catch (const OutputError& e) {
      CHECK_THAT(e.what(), Catch::Contains("bad.db") && Catch::Contains("it is damaged"));
    }
  }
  CHECK(run_bifurcation(study, good).made == 0);
}

TEST_CASE("basins of a rotor between two stops are bounded by the separatrix of its energy", "[attractors]") {
  // A start with ½ J ω² = m g l (1 − cos θ) leads to the top and stays there; with less energy the
  // rotor falls back to its side, with more it passes the top. The energy after a stop is too small
  // to return: e² (E − m g l cos 1) < m g l (1 − cos 1) for all starts here.
  const double mgl = 1, j = 0.01;
  for (const char* formulation : {"nonsmooth", "penalty"}) {
    CAPTURE(formulation);
    const test::StudyDesk desk;
    const auto study = desk.read(
        fmt::format("scene = \"{}\"\n[axes.angle]\nkey = \"bodies.rotor.angle\"\n"
                    "values = [-0.9, -0.5, -0.2, 0.1, 0.4, 0.8]\n"
                    "[axes.speed]\nkey = \"bodies.rotor.angular_velocity\"\n"
                    "values = [-6, -4, -2.1, -0.9, 0.5, 1.8, 3.9, 5.9]\n"
                    "[basin]\nsection = \"every 0.5 s\"\nperiod = 0.5\ndiscard = 8\nkeep = 4\n"
                    "columns = [\"axle.angle\"]\n"
                    "formulation = \"{}\"\n",
                    (test::source_folder() / "cases/bistable-rotor/scene.toml").string(), formulation));
    AttractorStore store(desk.at("a.db"), {});
    const auto runs = settle(study, *study.basin, "basin", basin_chains(study), store, 2, {}, {});
    const auto outcome = attractors_of_all(runs);
    REQUIRE(outcome.list.size() == 2);
    for (const auto& chain : runs.chains) {
      const auto& run = chain[0];
      const double angle = run.values[0], speed = run.values[1];
      CAPTURE(angle, speed);
      const double above = 0.5 * j * speed * speed - mgl * (1 - std::cos(angle));
      REQUIRE(std::abs(above) > 1e-4);  // none on the separatrix
      const double side = above > 0 ? std::copysign(1.0, speed) : std::copysign(1.0, angle);
      REQUIRE(run.attractor.period == 1);
      // At the stop; with penalty its deflection under 8.4 N is far below a thousandth.
      CHECK(run.attractor.points[0] == Approx(side).epsilon(1e-3));
    }
  }
}

TEST_CASE("an invalid request for attractors in a study is refused at its place", "[attractors]") {
  const test::StudyDesk desk;
  const auto head =
      fmt::format("scene = \"{}\"\n[axes.a]\nkey = \"curves.shake.amplitude\"\nvalues = [1e-4, 2e-4]\n",
                  ball_scene.string());
  struct Case {
    const char *rest, *place, *message;
  };
  for (const auto& [rest, place, message] :
       {Case{"[bifurcation]\naxis = \"b\"\n", "study.toml:6", "not an axis of the study"},
        {"[bifurcation]\ndirection = \"sideways\"\n", "study.toml:6", ""},
        {"[bifurcation]\ndirection = \"none\"\n", "", "at least one start"},
        {"[bifurcation]\nstarts = 2\n", "study.toml:6", "all starts are identical"},
        {"[bifurcation]\nkeep = 2.5\n", "", "a whole number"},
        {"[bifurcation]\nstep = 2\n", "study.toml:6", ""},
        {"[bifurcation]\nset = [\"surfaces.hard.restitutio=0.5\"]\n", "study.toml:5", "did you mean"},
        {"[bifurcation]\nsection = \"each touch of nothing\"\n", "study.toml:6", "bifurcation.section: "},
        {"[bifurcation]\ncolumns = [\"ball.z\"]\n", "study.toml:6:", "columns: "},
        {"[basin]\n", "study.toml:5", "y"}}) {
    const auto said = test::refusal_of([&, rest = rest] {
      const auto study = desk.read(head + rest);
      if (study.bifurcation) run_bifurcation(study, desk.at("a.db"));
    });
    CHECK_THAT(said, Catch::Contains(place) && Catch::Contains(message));
  }
}

TEST_CASE("a diagram's axis key cannot be set as well, and an invalid value is reported at its place",
          "[attractors][errors]") {
  const test::StudyDesk desk;
  desk.put("b.toml", test::file_text(ball_scene));
  const std::string head =
      "scene = \"b.toml\"\n[axes.g]\nkey = \"curves.shake.amplitude\"\nvalues = [9e-4, 1e-3]\n[axes.e]\n"
      "key = \"surfaces.hard.restitution\"\nvalues = [0.7, 0.8]\n";
  CHECK_THROWS_WITH(desk.read(head + "[bifurcation]\nset = [\"curves.shake.amplitude=1\"]\n"),
                    Catch::Contains("bifurcation.set: curves.shake.amplitude is varied by axis g"));
  CHECK_THROWS_WITH(desk.read(head + "[basin]\nset = [\"surfaces.hard.restitution = 1\"]\n"),
                    Catch::Contains("basin.set: surfaces.hard.restitution is varied by axis e"));
  // Of an axis that the diagram does not name the key may be set.
  const auto study =
      desk.read(head + "[bifurcation]\nsection = \"each touch\"\nset = [\"surfaces.hard.restitution=2\"]\n");
  CHECK_THROWS_WITH(run_bifurcation(study, desk.at("a.db")),
                    Catch::Contains("study.toml:8:1: bifurcation: ") && Catch::Contains("bifurcation") &&
                        Catch::Contains("must be between 0 and 1"));
}
