// Studies in lanes (study/runs/executor.hpp) against the same studies without compilation. The
// expected bits are those of the general evaluation, which other tests compare with closed forms.
#include <sqlite3.h>

#include <atomic>

#include "io/files/folder_lock.hpp"
#include "study/attractors/attractor_runs.hpp"
#include "study/attractors/attractor_table.hpp"
#include "study/calibration/calibrate.hpp"
#include "study/sweep/sweep.hpp"
#include "verification/support/compiled_runs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
namespace fs = std::filesystem;

namespace {

/// All rows of the tables and views of a database, sorted; without times of the computation, and
/// without numbers of rows, which state the order of ends.
std::vector<std::string> rows_of_file(const fs::path& file) {
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

void check_same_rows(const fs::path& a, const fs::path& b) {
  const auto x = rows_of_file(a), y = rows_of_file(b);
  REQUIRE(x.size() > 4);
  REQUIRE(x.size() == y.size());
  std::size_t differing = 0;
  for (std::size_t i = 0; i < x.size(); ++i) differing += x[i] != y[i];
  CHECK(differing == 0);
}

/// A study of a scene of verification/scenes.
Study study_of(const std::string& scene, const std::string& text) {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "study.toml",
             fmt::format("scene = \"{}\"\n{}", test::scene_file(scene).string(), text));
  return read_study(folder.path() / "study.toml");
}

/// Does the work in two folders, with lanes and without compilation. Both leave the same rows in their
/// database `file`; returns what the work returns, with lanes first.
auto with_and_without_lanes(const char* file, const auto& work) {
  const test::TemporaryFolder lanes, alone;
  const auto in = [&](const char* choice, const test::TemporaryFolder& folder) {
    const test::Environment compile("FREEPLAY_COMPILE", choice);
    return work(folder.path());
  };
  auto a = in("always", lanes);
  auto b = in("never", alone);
  check_same_rows(lanes.path() / file, alone.path() / file);
  return std::pair(std::move(a), std::move(b));
}

SweepSummary swept_in(const Study& study, const fs::path& place, int threads) {
  const Conduct conduct{.matched = true, .stop = {}};
  Results results(place / "sweep.db", study, {});
  const FolderLock lock(place, "test");
  return sweep(study, plan(study, conduct), conduct, results, lock, threads, {});
}

const char* const laned_sweep =
    "formulations = [\"nonsmooth\"]\nrevolutions = 1\ndiscard = 1\nstarts = 2\n"
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

const char* const laned_axes =
    "[axes.clearance]\nkey = \"joints.C.clearance\"\nvalues = [3e-4, 4e-4, 6e-4]\n"
    "[axes.restitution]\nkey = \"surfaces.steel.restitution\"\nvalues = [0.1, 0.5]\n";

}  // namespace

TEST_CASE("a sweep has the same database with and without lanes", "[lanes][sweep][compiled]") {
  const test::CompilerCache cache;
  const auto study = study_of("tests/loose_four_bar", laned_sweep);
  const auto [a, b] =
      with_and_without_lanes("sweep.db", [&](const fs::path& place) { return swept_in(study, place, 2); });
  CHECK(a.ran == 24);
  CHECK(a.failed == 0);
  CHECK(b.in_lanes == 0);
  CHECK(a.in_lanes > 5000);  // threads decide which runs meet
}

TEST_CASE("a sweep of accelerations has the same database with and without lanes",
          "[lanes][sweep][compiled]") {
  const test::CompilerCache cache;
  const auto study = study_of("tests/loose_slider_crank",
                              "formulations = [\"nonsmooth\"]\njoint = \"C\"\n"
                              "accelerometer = \"acceleration\"\n"
                              "position = \"position\"\nrevolutions = 1\ndiscard = 1\nstarts = 5\n"
                              "[axes.clearance]\nkey = \"joints.C.clearance\"\nvalues = [3e-4]\n");
  const auto found =
      with_and_without_lanes("sweep.db", [&](const fs::path& place) { return swept_in(study, place, 1); });
  CHECK(found.first.in_lanes > 30000);
}

TEST_CASE("bifurcations and basins have the same points with and without lanes",
          "[lanes][attractors][compiled]") {
  const test::CompilerCache cache;
  const auto check = [](const Study& study, const AttractorPlan& plan, const char* table,
                        const std::vector<Chain>& chains, long made, long in_lanes) {
    const auto found = with_and_without_lanes("runs.db", [&](const fs::path& place) {
      AttractorStore store(place / "runs.db", {});
      return settle(study, plan, table, chains, store, 1, {}, {});
    });
    CHECK(static_cast<long>(found.first.made) == made);
    CHECK(found.first.in_lanes > in_lanes);
  };
  for (const char* section : {"each touch", "A.angle crosses 40 deg upwards"}) {
    CAPTURE(section);
    const auto study =
        study_of("tests/loose_slider_crank", fmt::format("{}[bifurcation]\nsection = \"{}\"\ndiscard = 1\n"
                                                         "keep = 2\nstarts = 1\naxis = \"clearance\"\n",
                                                         laned_axes, section));
    check(study, *study.bifurcation, "bifurcation", bifurcation_chains(study), 9, 30000);
  }
  const auto study = study_of("tests/loose_slider_crank", std::string(laned_axes) +
                                                              "[basin]\nsection = \"every period\"\n"
                                                              "discard = 1\nkeep = 2\n");
  check(study, *study.basin, "basin", basin_chains(study), 6, 15000);
}

TEST_CASE("a calibration has the same runs and fit with and without lanes", "[lanes][calibrate][compiled]") {
  const test::CompilerCache cache;
  const auto study = study_of(
      "tests/loose_slider_crank",
      "joint = \"C\"\naccelerometer = \"acceleration\"\nrevolutions = 1\ndiscard = 1\n"
      "starts = 1\n[calibrate]\nformulation = \"nonsmooth\"\npoints = 5\nstarts = 1\nrevolutions = 1\n"
      "refinements = 0\n[calibrate.unknowns.clearance]\nkey = \"joints.C.clearance\"\nlow = 2e-4\n"
      "high = 6e-4\n"
      "[calibrate.targets.level]\nstatistic = \"rms\"\nvalue = 12\n");
  const auto [a, b] = with_and_without_lanes("calibrate.db", [&](const fs::path& place) {
    return calibrate(plan_calibration(study, {}), Conduct{}, FolderLock(place, "test"), 1, {});
  });
  CHECK(a.sweep.in_lanes > 50000);
  CHECK(a.all.xi == b.all.xi);
}

TEST_CASE("a sweep in lanes that is stopped keeps what was finished", "[lanes][sweep][compiled]") {
  const test::CompilerCache cache;
  const auto study = study_of("tests/loose_four_bar", laned_sweep);
  const auto tries = with_and_without_lanes("sweep.db", [&](const fs::path& place) {
    std::size_t made = 0;
    int tries = 0;
    if (std::getenv("FREEPLAY_COMPILE") == std::string("never")) swept_in(study, place, 1), made = 24;
    for (; tries < 20 && made < 24; ++tries) {
      std::atomic<bool> stop{false};
      const Conduct conduct{.matched = true, .stop = StopToken(stop)};
      Results results(place / "sweep.db", study);
      const FolderLock lock(place, "test");
      const auto runs = plan(study, Conduct{.matched = true, .stop = {}});
      const auto part = sweep(study, runs, conduct, results, lock, 1,
                              [&](const SweepProgress& p) { stop = p.done >= made + 5; });
      CHECK(part.found == made);
      made = results.keys().size();
    }
    CHECK(made == 24);
    return tries;
  });
  CHECK(tries.first > 2);
}
