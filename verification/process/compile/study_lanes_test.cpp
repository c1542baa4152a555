// Studies in lanes (study/runs/executor.hpp) against the same studies without compilation. The
// expected bits are those of the general evaluation, which other tests compare with closed forms.
#include <fmt/format.h>
#include <sqlite3.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "io/files/folder_lock.hpp"
#include "study/attractors/attractor_runs.hpp"
#include "study/attractors/attractor_table.hpp"
#include "study/calibration/calibrate.hpp"
#include "study/sweep/sweep.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;

namespace {

/// A cache of compiled objects for one test, and a choice about compilation.
class LanesDesk {
 public:
  LanesDesk() { setenv("XDG_CACHE_HOME", (folder_.path() / "cache").c_str(), 1); }
  ~LanesDesk() {
    unsetenv("XDG_CACHE_HOME");
    unsetenv("FREEPLAY_COMPILE");
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_.path() / name) << text;
  }
  Study study(const std::string& text) const {
    write("study.toml", text);
    return read_study(folder_.path() / "study.toml");
  }
  /// A folder for results with a choice: "always" or "never".
  std::filesystem::path results(const char* choice, const char* name = nullptr) const {
    setenv("FREEPLAY_COMPILE", choice, 1);
    const auto place = folder_.path() / (name ? name : choice);
    std::filesystem::create_directories(place);
    return place;
  }

 private:
  test::TemporaryFolder folder_;
};

/// All rows of the tables and views of a database, sorted; without times of the computation, and
/// without numbers of rows, which state the order of ends.
std::vector<std::string> rows_of_file(const std::filesystem::path& file) {
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open_v2(file.c_str(), &db, SQLITE_OPEN_READONLY, nullptr) == SQLITE_OK);
  std::vector<std::string> rows, names;
  const auto each = [&](const std::string& sql, const auto& f) {
    sqlite3_stmt* s = nullptr;
    REQUIRE(sqlite3_prepare_v2(db, sql.c_str(), -1, &s, nullptr) == SQLITE_OK);
    while (sqlite3_step(s) == SQLITE_ROW) f(s);
    sqlite3_finalize(s);
  };
  const auto text = [](sqlite3_stmt* s, int column) {
    const auto* bytes = static_cast<const char*>(sqlite3_column_blob(s, column));
    return std::string(bytes, bytes + sqlite3_column_bytes(s, column));
  };
  each(
      "SELECT name FROM sqlite_schema WHERE type IN ('table', "
      "'view') AND name NOT LIKE '%\\_rows' ESCAPE '\\' "
      "AND name NOT LIKE '%\\_blobs' ESCAPE '\\'",
      [&](sqlite3_stmt* s) { names.push_back(text(s, 0)); });
  for (const auto& name : names)
    each("SELECT * FROM " + name, [&](sqlite3_stmt* s) {
      auto row = name;
      for (int c = 0; c < sqlite3_column_count(s); ++c) {
        const std::string column = sqlite3_column_name(s, c);
        if (column == "run id" || column == "id" || column.find("cpu") != column.npos) continue;
        if (sqlite3_column_type(s, c) == SQLITE_FLOAT)
          row += fmt::format(" {}", sqlite3_column_double(s, c));  // the shortest exact text
        else
          row += " " + text(s, c);
      }
      rows.push_back(row);
    });
  sqlite3_close(db);
  std::ranges::sort(rows);
  return rows;
}

void check_same_rows(const std::filesystem::path& a, const std::filesystem::path& b) {
  const auto x = rows_of_file(a), y = rows_of_file(b);
  REQUIRE(x.size() > 4);
  REQUIRE(x.size() == y.size());
  std::size_t differing = 0;
  for (std::size_t i = 0; i < x.size(); ++i) differing += x[i] != y[i];
  CHECK(differing == 0);
}

std::string laned_bar(const char* name, double length, double mass) {
  return fmt::format(
      "[bodies.{}]\nmass = {}\ninertia = {}\npoints = {{ a = [0, 0], b = [{}, 0], mass_centre = [{}, 0] }}\n",
      name, mass, mass * length * length / 12, length, 0.5 * length);
}
std::string loose_pin(const char* name, const char* ends, double clearance) {
  return fmt::format(
      "[joints.{}]\ntype = \"revolute\"\n{}\nclearance = {}\nbearing_radius = 0.01\nsurface = \"steel\"\n",
      name, ends, clearance);
}
constexpr const char* laned_rest =
    "[surfaces.steel]\nyoung = 2e11\npoisson = 0.3\nrestitution = 0.5\nfriction = 0.1\n"
    "[drives.motor]\njoint = \"A\"\nspeed_rpm = 300\n"
    "[run]\nrevolutions = 1\nstart = \"ideal\"\n"
    "[nonsmooth]\nscheme = \"moreau-jean\"\nstep = 5e-5\n";

/// A four-bar with two loose pins under gravity.
std::string loose_four_bar() {
  return "format = 2\ngravity = [0, -9.81]\n" + laned_bar("crank", 0.1, 1) + laned_bar("coupler", 0.35, 0.5) +
         laned_bar("rocker", 0.3, 0.7) +
         "[joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"crank\"]\nat = [[0, 0], \"a\"]\n" +
         loose_pin("B", "between = [\"crank\", \"coupler\"]\nat = [\"b\", \"a\"]", 3e-4) +
         loose_pin("C", "between = [\"coupler\", \"rocker\"]\nat = [\"b\", \"b\"]", 2e-4) +
         "[joints.D]\ntype = \"revolute\"\nbetween = [\"ground\", \"rocker\"]\nat = [[0.4, 0], \"a\"]\n"
         "[assembly]\nbranch = \"open\"\n" +
         laned_rest +
         "[instruments.position]\ntype = \"lvdt\"\nbody = \"rocker\"\naxis = [1, 0]\nsampling = 3e3\n";
}

/// A slider-crank with one loose pin, an accelerometer with a filter, and a displacement sensor.
std::string loose_slider_crank() {
  return "format = 2\ngravity = [0, 0]\n" + laned_bar("crank", 0.05, 1) + laned_bar("rod", 0.3, 0.4) +
         "[bodies.slider]\nmass = 1\ninertia = 0.001\n"
         "[joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"crank\"]\nat = [[0, 0], \"a\"]\n"
         "[joints.B]\ntype = \"revolute\"\nbetween = [\"crank\", \"rod\"]\nat = [\"b\", \"a\"]\n" +
         loose_pin("C", "between = [\"rod\", \"slider\"]\nat = [\"b\", [0, 0]]", 4e-4) +
         "[joints.guide]\ntype = \"translational\"\nbetween = [\"ground\", \"slider\"]\n"
         "at = [[0, 0], [0, 0]]\n"
         "axis = [1, 0]\n" +
         laned_rest +
         "[instruments.acceleration]\nbody = \"slider\"\naxis = [1, 0]\nbandwidth = 1000\norder = 2\n"
         "sampling = 10000\n"
         "[instruments.position]\ntype = \"lvdt\"\nbody = \"slider\"\naxis = [1, 0]\nsampling = 10000\n";
}

SweepSummary swept_in(const Study& study, const std::filesystem::path& place, int threads,
                      StopToken stop = {}) {
  const Conduct conduct{.matched = true, .stop = stop};
  Results results(place / "sweep.db", study, stop);
  const FolderLock lock(place, "test");
  return sweep(study, plan(study, conduct), conduct, results, lock, threads, {});
}

const char* const laned_sweep =
    "scene = \"four-bar.toml\"\nformulations = [\"nonsmooth\"]\nrevolutions = 1\ndiscard = 1\nstarts = 2\n"
    "[axes.restitution]\nkey = \"surfaces.steel.restitution\"\nvalues = [0.2, 0.7]\n"
    "[axes.speed]\nkey = \"drives.motor.speed_rpm\"\nvalues = [200, 400]\n"
    "[variants.loose]\ntitle = \"four-bar\"\n"
    "[variants.frictionless]\nset = [\"surfaces.steel.friction=0\"]\ntitle = \"another structure\"\n"
    "[variants.events]\nset = [\"nonsmooth.scheme='event-driven'\"]\ntitle = \"another scheme\"\n"
    "[measure.highest]\ncolumn = \"C.gap\"\nreduce = \"max\"\n"
    "[measure.mean]\ncolumn = \"rocker.x\"\nreduce = \"mean\"\n"
    "[measure.signal]\ncolumn = \"position\"\nreduce = \"rms\"\n"
    "[measure.touches]\ncolumn = \"coupler.x\"\nat = \"each touch\"\nreduce = \"mean\"\n"
    "[measure.crossing]\ncolumn = \"t\"\nat = \"D.angle crosses 1.9 rad upwards\"\nreduce = \"mean\"\n"
    "[measure.energy]\ncolumn = \"C.impacts\"\nreduce = \"last\"\n";

SettledRuns settled_in(const Study& study, const AttractorPlan& plan, const char* table,
                       const std::vector<Chain>& chains, const std::filesystem::path& place) {
  AttractorStore store(place / "runs.db", {});
  return settle(study, plan, table, chains, store, 1, {}, {});
}

const char* const laned_axes =
    "scene = \"slider.toml\"\n[axes.clearance]\nkey = \"joints.C.clearance\"\nvalues = [3e-4, 4e-4, 6e-4]\n"
    "[axes.restitution]\nkey = \"surfaces.steel.restitution\"\nvalues = [0.1, 0.5]\n";

}  // namespace

TEST_CASE("a sweep has the same database with and without lanes", "[lanes][sweep][compiled]") {
  const LanesDesk desk;
  desk.write("four-bar.toml", loose_four_bar());
  const auto study = desk.study(laned_sweep);
  const auto lanes = desk.results("always");
  const auto a = swept_in(study, lanes, 2);
  const auto alone = desk.results("never");
  const auto b = swept_in(study, alone, 2);
  CHECK(a.ran == 24);
  CHECK(a.failed == 0);
  CHECK(b.in_lanes == 0);
  CHECK(a.in_lanes > 5000);  // threads decide which runs meet
  check_same_rows(lanes / "sweep.db", alone / "sweep.db");
}

TEST_CASE("a sweep of accelerations has the same database with and without lanes",
          "[lanes][sweep][compiled]") {
  const LanesDesk desk;
  desk.write("slider.toml", loose_slider_crank());
  const auto study = desk.study(
      "scene = \"slider.toml\"\nformulations = [\"nonsmooth\"]\njoint = \"C\"\n"
      "accelerometer = \"acceleration\"\n"
      "position = \"position\"\nrevolutions = 1\ndiscard = 1\nstarts = 5\n"
      "[axes.clearance]\nkey = \"joints.C.clearance\"\nvalues = [3e-4]\n");
  const auto lanes = desk.results("always");
  const auto a = swept_in(study, lanes, 1);
  const auto alone = desk.results("never");
  swept_in(study, alone, 1);
  CHECK(a.in_lanes > 30000);
  check_same_rows(lanes / "sweep.db", alone / "sweep.db");
}

TEST_CASE("bifurcations and basins have the same points with and without lanes",
          "[lanes][attractors][compiled]") {
  const LanesDesk desk;
  desk.write("slider.toml", loose_slider_crank());
  for (const char* section : {"every period", "each touch", "A.angle crosses 40 deg upwards"}) {
    CAPTURE(section);
    const auto bifurcation =
        desk.study(fmt::format("{}[bifurcation]\nsection = \"{}\"\ndiscard = 1\nkeep = 2\nstarts = 1\n"
                               "axis = \"clearance\"\n",
                               laned_axes, section));
    const auto chains = bifurcation_chains(bifurcation);
    const auto lanes = desk.results("always");
    const auto a = settled_in(bifurcation, *bifurcation.bifurcation, "bifurcation", chains, lanes);
    const auto alone = desk.results("never");
    settled_in(bifurcation, *bifurcation.bifurcation, "bifurcation", chains, alone);
    CHECK(a.made == 9);
    CHECK(a.in_lanes > 30000);
    check_same_rows(lanes / "runs.db", alone / "runs.db");
    std::filesystem::remove(lanes / "runs.db");
    std::filesystem::remove(alone / "runs.db");
  }
  const auto basin =
      desk.study(std::string(laned_axes) + "[basin]\nsection = \"every period\"\ndiscard = 1\nkeep = 2\n");
  const auto chains = basin_chains(basin);
  const auto lanes = desk.results("always");
  const auto a = settled_in(basin, *basin.basin, "basin", chains, lanes);
  const auto alone = desk.results("never");
  settled_in(basin, *basin.basin, "basin", chains, alone);
  CHECK(a.made == 6);
  CHECK(a.in_lanes > 15000);
  check_same_rows(lanes / "runs.db", alone / "runs.db");
}

TEST_CASE("a calibration has the same runs and fit with and without lanes",
          "[lanes][calibrate][compiled]") {
  const LanesDesk desk;
  desk.write("slider.toml", loose_slider_crank());
  const auto study = desk.study(
      "scene = \"slider.toml\"\njoint = \"C\"\naccelerometer = \"acceleration\"\nrevolutions = 1\n"
      "discard = 1\n"
      "starts = 1\n[calibrate]\nformulation = \"nonsmooth\"\npoints = 5\nstarts = 1\nrevolutions = 1\n"
      "refinements = 0\n[calibrate.unknowns.clearance]\nkey = \"joints.C.clearance\"\nlow = 2e-4\n"
      "high = 6e-4\n"
      "[calibrate.targets.level]\nstatistic = \"rms\"\nvalue = 12\n");
  const auto fitted = [&](const std::filesystem::path& place) {
    return calibrate(plan_calibration(study, {}), Conduct{}, FolderLock(place, "test"), 1, {});
  };
  const auto lanes = desk.results("always");
  const auto a = fitted(lanes);
  const auto alone = desk.results("never");
  const auto b = fitted(alone);
  CHECK(a.sweep.in_lanes > 50000);
  CHECK(a.all.xi == b.all.xi);
  check_same_rows(lanes / "calibrate.db", alone / "calibrate.db");
}

TEST_CASE("a sweep in lanes that is stopped keeps what was finished", "[lanes][sweep][compiled]") {
  const LanesDesk desk;
  desk.write("four-bar.toml", loose_four_bar());
  const auto study = desk.study(laned_sweep);
  const auto lanes = desk.results("always");
  const Conduct whole{.matched = true, .stop = {}};
  std::size_t made = 0;
  int tries = 0;
  for (; tries < 20 && made < 24; ++tries) {
    std::atomic<bool> stop{false};
    const Conduct conduct{.matched = true, .stop = StopToken(stop)};
    Results results(lanes / "sweep.db", study);
    const FolderLock lock(lanes, "test");
    const auto runs = plan(study, whole);
    const auto part = sweep(study, runs, conduct, results, lock, 1,
                            [&](const SweepProgress& p) { stop = p.done >= made + 5; });
    CHECK(part.found == made);
    made = results.keys().size();
  }
  CHECK(made == 24);
  CHECK(tries > 2);
  const auto alone = desk.results("never");
  swept_in(study, alone, 1);
  check_same_rows(lanes / "sweep.db", alone / "sweep.db");
}
