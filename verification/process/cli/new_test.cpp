// Scenes that `freeplay new` writes, and the figure of a pose.
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

std::vector<std::string> kinds() {
  std::vector<std::string> names;
  for (const auto& file : std::filesystem::directory_iterator(test::source_folder() / "src/cli/templates"))
    if (file.path().extension() == ".toml") names.push_back(file.path().stem().string());
  std::ranges::sort(names);
  return names;
}

}  // namespace

TEST_CASE("every new scene is commented and runs in both formulations", "[new]") {
  const test::TemporaryFolder folder;
  REQUIRE(kinds().size() >= 10);
  for (const auto& kind : kinds()) {
    CAPTURE(kind);
    const auto file = folder.path() / (kind + ".toml");
    test::succeeded("new " + kind + " -o " + file.string());
    CHECK(test::file_text(file) ==
          test::file_text(test::source_folder() / "src/cli/templates" / (kind + ".toml")));
    CHECK_THAT(test::file_text(file), Contains("# "));
    auto scene = read_scene(file);
    scene.run.duration = 0.02;
    CHECK(scene.idle.empty());
    for (const auto family : {Family::penalty, Family::nonsmooth}) {
      const auto run = test::simulate(scene, family);
      CAPTURE(run.ending.reason);
      CHECK(run.t_end == Approx(0.02));
    }
  }
}

TEST_CASE("the list of new scenes has each kind with its title, within 80 columns", "[new]") {
  const auto lines = test::lines_of(test::succeeded("new --list").out);
  for (const auto& kind : kinds()) {
    CAPTURE(kind);
    const auto scene = read_scene(test::source_folder() / "src/cli/templates" / (kind + ".toml"));
    const auto line = std::ranges::find_if(lines, [&](const auto& l) { return l.starts_with(kind + " "); });
    REQUIRE(line != lines.end());
    CHECK(line->ends_with(" " + scene.mechanism.title));
    CHECK(test::width(*line) <= 80);
  }
  test::refused("new", Contains("kind is required") && Contains("--list"));
}

TEST_CASE("the initial values of a new scene fit its joints", "[new]") {
  for (const auto& kind : kinds()) {
    CAPTURE(kind);
    const auto said =
        test::succeeded("check " + (test::source_folder() / "src/cli/templates" / (kind + ".toml")).string());
    CHECK_THAT(said.out, !Contains("stated values changed"));
  }
  // With another crank the start corrects the angle of the rocker, and check prints by how much.
  CHECK_THAT(test::succeeded("check " + (test::source_folder() / "src/cli/templates/four-bar.toml").string() +
                             " --set bodies.crank.points.pin[0]=\"101 mm\"")
                 .out,
             Contains("stated values changed") && Contains("bodies.rocker.angle by"));
}

TEST_CASE("check prints the play of each joint with clearance", "[new]") {
  const auto said = [](const std::string& kind) {
    return test::succeeded("check " +
                           (test::source_folder() / "src/cli/templates" / (kind + ".toml")).string())
        .out;
  };
  CHECK_THAT(said("press"), Contains("play of small_end") && Contains("radial clearance 0.1 mm: 0.2 mm in"));
  CHECK_THAT(said("yoke"), Contains("play of slot") && Contains("either side 0.05 mm: 0.1 mm across"));
}

TEST_CASE("a new scene never overwrites a file", "[new][errors]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "mine.toml";
  std::ofstream(file) << "mine";
  test::refused("new pendulum -o " + file.string(),
                Contains("mine.toml: already exists and is not overwritten"));
  CHECK(test::file_text(file) == "mine");
  std::filesystem::create_symlink(folder.path() / "nowhere.toml", folder.path() / "link.toml");
  CHECK(test::freeplay("new pendulum -o " + (folder.path() / "link.toml").string()).status == 2);
  CHECK(!std::filesystem::exists(folder.path() / "nowhere.toml"));
  test::refused("new pendulum -o " + (folder.path() / "no/where.toml").string(),
                Contains("no: there is no such folder; create it first"));
  test::refused("new pendulum -o " + (file / "where.toml").string(), Contains("is not a folder"));
  test::refused("new perpetuum-mobile", Contains("four-bar"));
}

TEST_CASE("check draws the assembled pose, whatever names and titles a scene has", "[pose][figures]") {
  const test::TemporaryFolder folder;
  const auto out = folder.path() / "out";
  const auto check = [&](const std::string& arguments) {
    const auto outcome = test::succeeded("check " + arguments + " -o " + out.string());
    for (const auto* suffix : {"pdf", "png", "gp", "dat"})
      CHECK(std::filesystem::file_size(out / (std::string("figures/pose.") + suffix)) > 200);
    return outcome.out;
  };
  const auto four_bar = check((test::source_folder() / "cases/four-bar/scene.toml").string());
  CHECK_THAT(four_bar,
             Contains("crank-rocker") && Contains("branch") && Contains("open") && Contains("mobility"));
  CHECK_THAT(four_bar, Contains("s + l = 0.5 m < p + q = 0.65 m"));
  check(test::flores().string());
  check(test::scene_file("seven_body").string() +
        " --set 'title=\"\"\"`touch x`; $(y) %s\n\"quoted\" '\"'\"'z'\"'\"'\"\"\"'");
  check(test::scene_file("bouncing_ball").string());
  check(test::scene_file("hanging_mass").string());
  check(test::scene_file("cradle").string());
  CHECK_THAT(test::file_text(out / "figures/pose.gp"), !Contains("system"));
}
