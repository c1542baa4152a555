// The report page: titles, units and commands of a study, the start transient, bodies through their
// named points.
#include "io/scene/pose_file.hpp"
#include "plots/report/report.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using nlohmann::json;

TEST_CASE("page of a sweep: title, units, verdict and commands with the study's file", "[report]") {
  const test::StudyDesk desk("bouncing-ball");
  const auto made = desk.sweep(
      "title = \"Rebound of a ball\"\nscene = \"scene.toml\"\nduration = 0.3\ndiscard_time = 0.33\n" +
      test::axis("radius", "contacts.table.radius", "0.050123456789012345, \"51 mm\"",
                 "unit = \"mm\"\nscale = 1e3\n") +
      "[variants.soft]\ntitle = \"A soft table\"\nset = [\"surfaces.hard.young=1e9\"]\n" +
      test::measure("highest", "ball.y", "max"));
  REQUIRE(made.status == 0);
  const auto page = report::document_of(desk.folder.path() / "out");
  CHECK(page["title"] == "Rebound of a ball");
  CHECK(page["scene_title"] == "Bouncing ball");
  const auto study = (desk.folder.path() / "study.toml").string(),
             scene = (desk.folder.path() / "scene.toml").string();
  CHECK(page["commands"] == json{"freeplay sweep " + study + " -o out"});
  CHECK(
      page["axis_facts"] ==
      json::array({{{"name", "radius"}, {"key", "contacts.table.radius"}, {"unit", "mm"}, {"scale", 1e3}}}));
  CHECK(page["variants"]["soft"] == json{{"scene", scene}, {"set", " --set surfaces.hard.young=1e9"}});
  CHECK(page["units"]["peak_max"] == "m/s²");
  CHECK(page["units"]["highest"] == "m");  // of the column ball.y
  CHECK(page["own"] == json{"highest"});
  CHECK(page["first"] == "highest");  // the study's own measure precedes the statistics of turns
  // The command of a cell repeats the run, so its key is the double of the study, not six digits of it.
  CHECK(page["runs"][0]["values"][0].get<double>() == 0.050123456789012345);
  // The page shows the words with which the command ends.
  const auto verdict = page["verdict"].get<std::string>();
  CHECK(verdict.starts_with("All 4 runs finished; highest ranges from"));
  CHECK(made.out.find(verdict.substr(0, 30)) != made.out.npos);
  // A folder of an older version has no sweep.json.
  std::filesystem::remove(desk.folder.path() / "out/sweep.json");
  CHECK(report::document_of(desk.folder.path() / "out")["commands"] == json{"freeplay sweep STUDY -o out"});
}

TEST_CASE("the start transient is the discarded time, else the beginning of the first turn", "[report]") {
  CHECK(report::start_transient(0.3, 0.1, 2) == 0.3);
  CHECK(report::start_transient(0, 0.2, 2) == Approx(0.05));    // a quarter of a turn
  CHECK(report::start_transient(0, 1.0, 0.5) == Approx(0.05));  // a tenth of a run of half a turn
  CHECK(report::start_transient(0, {}, 2) == 0);                // a fall, an oscillation: all of it counts
}

TEST_CASE("a body is drawn through all its named points", "[report][points]") {
  // The plate's points A (0, 0), B (3, 0), C (3, 2), D (0, 2) with its centre of mass at (1, 1);
  // only A carries a joint. The body stands at (5, 7), turned by a quarter: (x, y) → (5 − y, 7 + x).
  const auto scene = parse_scene(
      test::body("plate", 1, 1,
                 "points = { A = [0, 0], B = [3, 0], C = [3, 2], D = [0, 2], mass_centre = [1, 1] }\n") +
          "[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"plate\"]\nat = [[6, 6], \"A\"]\n" +
          test::run_for(1),
      "plate.toml");
  std::vector<std::pair<double, double>> corners;
  for (const auto& s : pose_shapes(scene, {5, 7, std::numbers::pi / 2}))
    if (s.kind == "link") corners.emplace_back(s.at.x(), s.at.y());
  REQUIRE(corners.size() == 5);  // closed
  CHECK(corners.front() == corners.back());
  for (const auto& [x, y] : {std::pair{6.0, 6.0}, {6.0, 9.0}, {4.0, 9.0}, {4.0, 6.0}})
    CHECK(std::ranges::any_of(
        corners, [&](const auto& c) { return std::abs(c.first - x) + std::abs(c.second - y) < 1e-12; }));
  // In their order along the outline: no two sides cross, so opposite corners are not neighbours.
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const double side =
        std::hypot(corners[i + 1].first - corners[i].first, corners[i + 1].second - corners[i].second);
    CHECK((std::abs(side - 2) < 1e-9 || std::abs(side - 3) < 1e-9));
  }
}
