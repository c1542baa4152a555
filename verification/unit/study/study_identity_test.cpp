// Keys of a study's runs: a change of spelling repeats no run, a change that affects a digit does,
// and a database with keys of another kind is neither used nor lost.
#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "io/files/output_file.hpp"
#include "io/files/run_json.hpp"
#include "mechanism/error.hpp"
#include "study/settings/study.hpp"
#include "study/sweep/sweep.hpp"
#include "verification/support/study_desk.hpp"
#include "verification/support/support.hpp"
#include "verification/support/texts.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using test::replaced;

namespace {

/// A study of two starts in both formulations with its own scene, in a folder.
struct Desk {
  test::TemporaryFolder folder;
  std::filesystem::path scene = folder.path() / "scene.toml", study = folder.path() / "study.toml";
  std::string scene_text = test::file_text(test::source_folder() / "cases/flores2011-experiment/guide.toml");
  std::string study_text = R"(scene = "scene.toml"
joint = "gudgeon"
accelerometer = "accelerometer"
position = "lvdt"
revolutions = 1
discard = 0.5
starts = 2
)";
  Desk() {
    write_file(scene, scene_text);
    write_file(study, study_text);
  }
  std::set<std::string> keys(const Conduct& conduct = {}) const {
    const auto read = read_study(study);
    std::set<std::string> list;
    for (const auto& one : cases(read)) list.insert(run_key(identity(read, one, conduct), one.start));
    return list;
  }
  std::string identity_of_study() const { return provenance(read_study(study))["identity"]["digest"]; }
};

}  // namespace

TEST_CASE("a sweep repeats a run if and only if a change affects a digit", "[study][repeat]") {
  Desk desk;
  const auto run = [&] {
    const auto study = read_study(desk.study);
    const FolderLock lock(desk.folder.path(), "test");
    Results results(desk.folder.path() / "sweep.db", study);
    return sweep(study, plan(study, {}), Conduct{}, results, lock, 0, {});
  };
  auto summary = run();
  REQUIRE(summary.ran == 4);
  REQUIRE(summary.failed == 0);
  const auto same = [&](const char* what) {
    INFO(what);
    summary = run();
    CHECK(summary.ran == 0);
    CHECK(summary.found == 4);
    CHECK(summary.kept == 0);
  };
  same("nothing");
  write_file(desk.scene, "# A remark.\n\n" + desk.scene_text + "\n# And one more.\n");
  same("a remark in the scene");
  write_file(desk.scene, replaced(desk.scene_text, "gravity", "gravity   "));
  same("blanks");
  write_file(desk.scene, "format = 1\n" + desk.scene_text);
  same("the format that it was read as");
  write_file(desk.scene, desk.scene_text);
  write_file(desk.study, "# Why.\n" + desk.study_text + "seed = 1\nturn = 1\nflight_angle = 2.0\n");
  same("a remark in the study, and its defaults");
  write_file(desk.study, desk.study_text + "[variants.given]\nset = [\"nonsmooth.lcp_tolerance=1e-10\"]\n");
  same("an option at its default");
  write_file(desk.study, desk.study_text + "[variants.given]\nset = [\"nonsmooth.step=2e-5\"]\n");
  summary = run();
  CHECK(summary.ran == 4);
  CHECK(summary.kept == 4);
  write_file(desk.study, desk.study_text + "[variants.given]\nset = [\"nonsmooth.step=2e-5\"]\nstarts = 1\n");
  summary = run();
  CHECK(summary.ran == 0);
  CHECK(summary.kept == 6);
  write_file(desk.study, desk.study_text);  // restored: its runs exist
  summary = run();
  CHECK(summary.found == 4);
  CHECK(summary.ran == 0);
  CHECK(summary.kept == 4);
}

TEST_CASE("every setting of a study that affects a run is in its key", "[study][repeat]") {
  Desk desk;
  const auto own = desk.keys();
  REQUIRE(own.size() == 4);
  const auto other = [&](const std::string& text) {
    write_file(desk.study, text);
    auto keys = desk.keys();
    write_file(desk.study, desk.study_text);
    std::set<std::string> shared;
    std::ranges::set_intersection(own, keys, std::inserter(shared, shared.end()));
    return shared.empty();
  };
  for (const char* line : {"restitution = \"as-given\"", "seed = 2", "turn = 0.5", "play = 0.5",
                           "flight_angle = 3", "impact_speed = 0.02", "line_share = 0.1", "[variants.other]",
                           "[axes.a]\nkey = \"joints.gudgeon.clearance\"\nvalues = [1e-3]"}) {
    CAPTURE(line);
    CHECK(other(desk.study_text + line + "\n"));
  }
  CHECK(other(replaced(desk.study_text, "revolutions = 1", "revolutions = 2")));
  CHECK(other(replaced(desk.study_text, "discard = 0.5", "discard = 0.25")));
  CHECK(other(replaced(desk.study_text, "position = \"lvdt\"\n", "")));
  // Settings of the amount of work or of display have no effect on keys.
  for (const char* line :
       {"title = \"Another\"", "claims = \"flores2011\"", "formulations = [\"penalty\", \"nonsmooth\"]",
        "[variants.given]\ntitle = \"The same\""}) {
    CAPTURE(line);
    CHECK_FALSE(other(desk.study_text + line + "\n"));
  }
  // Matching affects the impact law's runs alone.
  const auto unmatched = desk.keys({.matched = false, .stop = {}});
  CHECK(std::ranges::count_if(unmatched, [&](const auto& key) { return own.contains(key); }) == 2);
  write_file(desk.scene, replaced(desk.scene_text, "restitution", "poisson = 0.31 # restitution"));
  CHECK_THROWS_AS(desk.keys(),
                  SceneError);  // the same key twice: an invalid scene is reported before any run
}

TEST_CASE("results of a study record their sources, with every file that it refers to", "[study][repeat]") {
  Desk desk;
  const auto data = desk.folder.path() / "measured.csv", fit = desk.folder.path() / "fit.toml";
  write_file(data, "t,acceleration\n0,1\n");
  write_file(fit, desk.study_text);
  desk.study_text += R"(fit = "fit.toml"
[calibrate.unknowns.clearance]
key = "joints.gudgeon.clearance"
low = 1e-4
high = 1e-3
[calibrate.targets.peak]
statistic = "peak_max"
data = "measured.csv"
)";
  write_file(desk.study, desk.study_text);
  const auto own = desk.identity_of_study();
  const auto moved = [&](const std::filesystem::path& file, const std::string& text) {
    const auto before = test::file_text(file);
    write_file(file, text);
    const auto now = desk.identity_of_study();
    write_file(file, before);
    return now != own;
  };
  CHECK_FALSE(moved(desk.study, "# Why.\n\n" + desk.study_text));
  CHECK_FALSE(moved(desk.scene, "# Why.\n\n" + desk.scene_text));
  CHECK_FALSE(moved(fit, "# Why.\n\n" + test::file_text(fit)));
  CHECK(moved(desk.study, replaced(desk.study_text, "low = 1e-4", "low = 2e-4")));
  CHECK(moved(desk.scene,
              replaced(desk.scene_text, "[surfaces.", "[lubricants.oil]\nviscosity = 0.04\n[surfaces.")));
  CHECK(moved(data, "t,acceleration\n0,2\n"));
  CHECK(moved(fit, test::file_text(fit) + "seed = 3\n"));
  CHECK(desk.identity_of_study() == own);
  // In another folder keys are the same.
  Desk other;
  write_file(other.folder.path() / "measured.csv", test::file_text(data));
  write_file(other.folder.path() / "fit.toml", test::file_text(fit));
  write_file(other.study, desk.study_text);
  CHECK(other.identity_of_study() == own);
  std::filesystem::remove(data);
  CHECK_THROWS_AS(desk.identity_of_study(), SceneError);
}

TEST_CASE("a database with keys of another kind is neither used nor lost", "[study][repeat][program]") {
  Desk desk;
  const auto command = fmt::format("sweep {} -o {}", desk.study.string(), desk.folder.path().string());
  REQUIRE(test::freeplay(command).status == 0);
  const auto db = desk.folder.path() / "sweep.db";
  const auto run_sql = [&](const std::string& sql) {
    const auto rows = test::query(db, sql);
    return rows.empty() ? -1 : std::stol(rows[0][0]);
  };
  CHECK(run_sql("PRAGMA user_version") == 3);
  for (const auto& [version, who] : {std::pair(0, "an earlier version"), std::pair(1, "an earlier version"),
                                     std::pair(4, "a later version")}) {
    run_sql(fmt::format("PRAGMA user_version = {}", version));
    const auto o = test::freeplay(command);
    CAPTURE(o.out, o.err);
    CHECK(o.status == 1);
    CHECK_THAT(o.err, Contains(db.string()) && Contains(who) && Contains("cannot be used") &&
                          Contains("give another folder with -o"));
    CHECK(std::ranges::count(o.err, '\n') == 1);
    CHECK(o.out.empty());
    CHECK(run_sql("SELECT count(*) FROM runs") == 4);
  }
  run_sql("PRAGMA user_version = 3");
  CHECK_THAT(test::freeplay(command).out, Contains("4 from the store, 0 new"));
}
