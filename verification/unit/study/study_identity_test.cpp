// Keys of a study's runs: a change of spelling repeats no run, a change that affects a digit does,
// and a database with keys of another kind is neither used nor lost.
#include "io/files/run_json.hpp"
#include "study/sweep/sweep.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using test::replaced;

namespace {

struct Desk : test::RigDesk {
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
  const auto finds = [&](const char* what, std::size_t found, std::size_t made, std::size_t kept) {
    INFO(what);
    summary = run();
    CHECK(summary.found == found);
    CHECK(summary.ran == made);
    CHECK(summary.kept == kept);
  };
  for (const auto& [what, scene] :
       {std::pair("a remark in the scene", "# A remark.\n\n" + desk.scene_text + "\n# And one more.\n"),
        {"blanks", replaced(desk.scene_text, "gravity", "gravity   ")},
        {"the format that it was read as", "format = 1\n" + desk.scene_text},
        {"nothing", desk.scene_text}}) {
    write_file(desk.scene, scene);
    finds(what, 4, 0, 0);
  }
  const std::string step = "[variants.given]\nset = [\"nonsmooth.step=2e-5\"]\n";
  const auto study = [&](const char* what, const std::string& text, std::size_t found, std::size_t made,
                         std::size_t kept) {
    write_file(desk.study, text);
    finds(what, found, made, kept);
  };
  study("a remark in the study, and its defaults",
        "# Why.\n" + desk.study_text + "seed = 1\nturn = 1\nflight_angle = 2.0\n", 4, 0, 0);
  study("an option at its default",
        desk.study_text + "[variants.given]\nset = [\"nonsmooth.lcp_tolerance=1e-10\"]\n", 4, 0, 0);
  study("another step", desk.study_text + step, 0, 4, 4);
  study("fewer starts", desk.study_text + step + "starts = 1\n", 2, 0, 6);
  study("restored: its runs exist", desk.study_text, 4, 0, 4);
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
  desk.study_text += "fit = \"fit.toml\"\n" +
                     test::unknown("clearance", "joints.gudgeon.clearance", 1e-4, 1e-3) +
                     test::target("peak", "peak_max", "data = \"measured.csv\"\n");
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
  CHECK(moved(desk.study, replaced(desk.study_text, "low = 0.0001", "low = 0.0002")));
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
