// Figures, plots and report pages of periodic motions, branches and exponents, from known files and from the
// program.
#include "plots/drawing/column_plot.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/report/page.hpp"
#include "plots/report/report.hpp"
#include "verification/claims/orbit_scenes.hpp"
#include "verification/references/orbits.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

using Numbers = std::vector<std::vector<double>>;

json provenance() {
  return {{"version", "0"},
          {"commit", "none"},
          {"title", "two bodies"},
          {"scene_file", "scene.toml"},
          {"scene", "not read"},
          {"overrides", json::array({"a=1"})},
          {"options", {{"run", {{"duration", 1.01}, {"discard", 0.0}}}}}};
}

constexpr double period = 1.01, onset = 0.505;

/// Body a falls with the rate −t from 3 m, and its rate changes by the period at the impact at half
/// of it. Body b moves as 2 sin(2πt/T) without a jump. The rate of body c rises over two rows after
/// the impact, as by a soft contact. Rows at every hundredth of a second.
void write_orbit(const std::filesystem::path& folder, bool stable) {
  make_folder(folder / "motion");
  write_file(folder / "orbit.json",
             json{{"period_s", period},
                  {"periods", 1},
                  {"residual", 1e-11},
                  {"stable", stable},
                  {"iterations", 3},
                  {"state", {{"t", 0.0}}},
                  {"impacts", json::array({{{"time", onset}, {"joint", "floor"}, {"speed", onset}}})},
                  {"lasting", json::array()},
                  {"multipliers", json::array({{-2.0, 0.25}, {0.5, 0.0}, {1 - 1e-6, 0.0}})},
                  {"formulation", "nonsmooth"},
                  {"settle", 10.5},
                  {"provenance", provenance()}}
                 .dump());
  write_file(folder / "motion/run.json",
             json{{"formulation", "nonsmooth"}, {"provenance", provenance()}}.dump());
  std::string rows =
      "t,a.x,a.y,a.theta,a.vx,a.vy,a.omega,b.x,b.y,b.theta,b.vx,b.vy,b.omega,"
      "c.x,c.y,c.theta,c.vx,c.vy,c.omega\n";
  const double turn = 2 * std::acos(-1.0);
  for (int i = 0; i <= 101; ++i) {
    const double t = 0.01 * i, since = t < onset ? t : t - period;
    rows += fmt::format("{},0,{},0,0,{},0,{},0,0,{},0,0,{},0,0,{},0,0\n", t, 3 - since * since / 2, -since,
                        2 * std::sin(turn * t / period), 2 * turn / period * std::cos(turn * t / period), t,
                        std::clamp(i - 50, 0, 2));
  }
  write_file(folder / "motion/trajectory.csv", rows);
}

}  // namespace

TEST_CASE("the figure of a periodic motion shows its jumps, its section and its stability",
          "[figures][orbit]") {
  const bool stable = GENERATE(true, false);
  const test::TemporaryFolder folder;
  write_orbit(folder.path(), stable);
  const auto made = plots::all(folder.path());
  REQUIRE(made.size() == 2);
  CHECK(made[0] == folder.path() / "figures/orbit.pdf");
  CHECK(made[1] == folder.path() / "figures/multipliers.pdf");
  const auto blocks = test::data_blocks(folder.path() / "figures/orbit.dat");
  REQUIRE(blocks.size() == 7);  // of a: jump, curve, section; of b and c: curve, section
  REQUIRE(blocks[0].size() == 2);
  for (std::size_t end = 0; end < 2; ++end) {  // the rows about the onset, symmetric to it
    CHECK(blocks[0][end][0] == Approx(3 - 0.125).epsilon(1e-12));
    CHECK(blocks[0][end][1] == Approx(end == 0 ? -0.5 : 0.5).epsilon(1e-12));
  }
  CHECK(blocks[1].size() == 102);
  CHECK(blocks[2] == Numbers{{3, 0}});
  CHECK(blocks[3].size() == 102);
  REQUIRE(blocks[4].size() == 1);
  CHECK(blocks[4][0][0] == 0);
  // The curve is interrupted at the jump.
  const auto text = test::file_text(folder.path() / "figures/orbit.dat");
  CHECK_THAT(text, Contains("2.875 -0.5\n\n2.875 0.5"));
  const auto script = test::file_text(folder.path() / "figures/orbit.gp");
  CHECK((script.find("dt (6,4)") == script.npos) == stable);
  CHECK_THAT(script, Contains(stable ? "\"stable\"" : "\"not stable\""));

  const auto multipliers = test::data_blocks(folder.path() / "figures/multipliers.dat");
  REQUIRE(multipliers.size() == 3);
  for (const auto& corner : multipliers[0]) CHECK(std::hypot(corner[0], corner[1]) == Approx(1));
  CHECK(multipliers[1] == Numbers{{0.5, 0}});
  // A modulus next to 1 does not show a stable motion.
  CHECK(multipliers[2] == Numbers{{-2, 0.25}, {1 - 1e-6, 0}});

  // The motion is plotted as a run.
  plots::ColumnPlot plot{.folders = {folder.path()}, .x = "a.y", .panels = {{"a.vy"}}, .name = "own"};
  plots::draw_columns(plot);
  CHECK(test::data_blocks(folder.path() / "figures/own.dat").at(0).size() == 102);
}

TEST_CASE("the page of a periodic motion has its results, figures and command", "[report][orbit]") {
  const test::TemporaryFolder folder;
  write_orbit(folder.path(), true);
  CHECK_FALSE(report::document_of(folder.path()).contains("pictures"));  // not drawn yet
  plots::all(folder.path());
  write_file(folder.path() / "figures/multipliers.png", "no picture");
  const auto page = report::document_of(folder.path());
  CHECK(page["kind"] == "orbit");
  CHECK(page["title"] == "two bodies");
  CHECK(page["commands"] ==
        json{"freeplay orbit scene.toml --formulation nonsmooth --set a=1 --periods 1 --settle 10.5"});
  REQUIRE(page["runs"].size() == 1);
  CHECK(page["runs"][0]["motion"]["t"].size() == 102);
  REQUIRE(page["pictures"].size() == 1);
  CHECK(page["pictures"][0]["title"] == "Phase portraits");
  CHECK(page["pictures"][0]["png"].get<std::string>().starts_with("iVBORw0KGgo"));
  const auto& tables = page["tables"];
  CHECK(tables[0]["rows"][0] == json{"stable", "yes"});
  CHECK(tables[0]["rows"][1] == json{"period, s", "1.01"});
  CHECK(tables[1]["rows"][0] == json{"-2", "0.25", "2.01556444"});  // the root of 4.0625
  CHECK(tables[2]["rows"] == json::array({{"0.505", "floor", "0.505"}}));
}

TEST_CASE("the pages of branches and exponents have their tables in the units of the study",
          "[report][orbit]") {
  const test::TemporaryFolder folder;
  auto origin = provenance();
  origin["study_file"] = "my study.toml";
  origin["study_title"] = "a study";
  origin["study"] = "key";
  write_file(folder.path() / "continue.json",
             json{{"provenance", origin},
                  {"continue",
                   {{"key", "joints.j.clearance"},
                    {"unit", "mm"},
                    {"scale", 1e3},
                    {"branches", {{{"branch", 1}, {"points", 7}, {"begins", "start"}, {"ends", "range"}}}},
                    {"bifurcations",
                     {{{"kind", "flip"},
                       {"parameter", 0.00025},
                       {"period_s", 0.5},
                       {"branch", 1},
                       {"joint", ""},
                       {"follows", "<b>"},
                       {"new_branch", 2},
                       {"residual", nullptr}}}}}}}
                 .dump());
  write_file(folder.path() / "lyapunov.json",
             json{{"provenance", provenance()},
                  {"formulation", "penalty"},
                  {"exponents",
                   {{{"per_s", 0.5}, {"standard_error_per_s", 0.25}, {"per_period", nullptr}, {"reason", ""}},
                    {{"per_s", nullptr}, {"reason", "a lasting contact"}}}},
                  {"sum_per_s", -1.5},
                  {"sum_predicted_per_s", -1.25},
                  {"impacts", 12}}
                 .dump());
  const auto page = report::document_of(folder.path());
  const auto table = [&](const std::string& title) {
    for (const auto& one : page["tables"])
      if (one["title"] == title) return one;
    return json();
  };
  CHECK(table("Bifurcations")["head"][1] == "joints.j.clearance, mm");
  CHECK(table("Bifurcations")["rows"] == json::array({{"flip", "0.25", "0.5", "1", "", "<b>", "2", "–"}}));
  CHECK(table("Branches of periodic motions")["rows"] == json::array({{"1", "7", "start", "range"}}));
  CHECK(table("Lyapunov exponents")["rows"] ==
        json::array({{"0.5", "0.25", "–", ""}, {"−∞", "–", "–", "a lasting contact"}}));
  CHECK(table("Sum of the exponents")["rows"].back() == json{"sum minus prediction, 1/s", "-0.25"});
  CHECK(page["commands"] == json{"freeplay continue 'my study.toml'",
                                 "freeplay lyapunov scene.toml --formulation penalty --set a=1"});
  CHECK_FALSE(page.contains("runs"));
}

TEST_CASE("base 64 is that of RFC 4648", "[report]") {
  for (const auto& [bytes, text] : {std::pair{"", ""},
                                    {"f", "Zg=="},
                                    {"fo", "Zm8="},
                                    {"foo", "Zm9v"},
                                    {"foob", "Zm9vYg=="},
                                    {"fooba", "Zm9vYmE="},
                                    {"foobar", "Zm9vYmFy"}})
    CHECK(report::base64(bytes) == text);
  CHECK(report::base64("\xff\xfe\x80") == "//6A");
}

TEST_CASE("the run of a periodic motion returns to its section and can be repeated", "[orbit]") {
  const reference::ShakenBall ball{0.0032L, 20 * reference::ShakenBall::pi(), 9.81L, 0.5L};
  const test::TemporaryFolder folder;
  const auto place = folder.path().string();
  write_file(folder.path() / "scene.toml", verification::scenes::shaken_ball(ball, 1e-3L));
  test::succeeded("orbit " + place + "/scene.toml --settle 7 -o " + place + "/out");
  const test::Columns motion(folder.path() / "out/motion/trajectory.csv");
  const auto &begin = motion.row(0), &end = motion.row(motion.rows() - 1);
  // The drive's period is a tenth of a second; the section is after seven of them.
  CHECK(begin[0] == Approx(0.7).epsilon(1e-14));
  CHECK(end[0] == Approx(0.8).epsilon(1e-14));
  // The residual is at most 1e-9 of error scales below 1 m and 1 m/s.
  for (std::size_t i = 1; i < begin.size(); ++i) CHECK(std::abs(end[i] - begin[i]) < 1e-9);
  const test::Columns events(folder.path() / "out/motion/events.csv");
  REQUIRE(events.rows() == 1);
  CHECK(std::abs(events.at(0, "t") - 0.7 - static_cast<double>(ball.impact_time())) < 1e-9);
  test::succeeded("run --from " + place + "/out/motion/run.json --no-figures -o " + place + "/again");
  CHECK(test::file_text(folder.path() / "again/trajectory.csv") ==
        test::file_text(folder.path() / "out/motion/trajectory.csv"));
  test::succeeded("report " + place + "/out");
}
