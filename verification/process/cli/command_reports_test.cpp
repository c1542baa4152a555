// Reports of commands on accuracy: settings of --accuracy and advise, the error estimate of first
// contacts, eliminated coordinates, propagated deviations, a continuation that cannot start, and two
// hundred random scenes.
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

const std::string brief = " --set run.revolutions=0.05 --set run.discard=0 ";

}  // namespace

TEST_CASE("--accuracy chooses settings, --set overrides them, advise prints the keys to set", "[advice]") {
  const test::TemporaryFolder folder;
  const auto words = "run " + test::flores().string() + brief + "-o " + folder.path().string();
  const auto steps_of = [](const test::Outcome& o) {  // "penalty: 0.015 s in 1234 steps, …"
    return std::stol(o.out.substr(o.out.find(" in ") + 4));
  };
  long coarser = 0;
  for (const char* accuracy : {"fast", "balanced", "reference"}) {
    const long steps = steps_of(test::succeeded(words + " --formulation penalty --accuracy " + accuracy));
    CHECK(coarser < steps);
    coarser = steps;
  }
  // `fast` selects the automatic scheme. Here 0.05 turns at 200 rpm are 15 ms, in steps of 1 ms.
  CHECK(steps_of(test::succeeded(words + " --formulation nonsmooth --accuracy fast --set "
                                         "nonsmooth.scheme=moreau-jean --set nonsmooth.step=1e-3")) == 15);
  CHECK(test::freeplay(words + " --formulation penalty --accuracy quick").status == 2);
  const auto advice =
      test::succeeded("advise " + test::flores().string() + brief + "--set penalty.contact=exact --error 1%");
  CHECK_THAT(advice.out, Contains("--set penalty.integrator=") && Contains("--set nonsmooth."));
}

TEST_CASE("a step too long for the first contacts is reported as doubtful", "[companion]") {
  const test::TemporaryFolder folder;
  const auto run = [&](const std::string& step) {
    return test::freeplay("run " + test::scene_file("gudgeon_1mm_250rpm").string() +
                          " --formulation nonsmooth --set run.duration=0.05 --set run.discard=0 -o " +
                          folder.path().string() + " --set nonsmooth.step=" + step);
  };
  CHECK_THAT(run("1e-6").out, Contains("estimated error of the first") && !Contains("warning: "));
  CHECK_THAT(run("1e-3").out,
             Contains("changes the first") || Contains("warning: estimated error of the first"));
}

TEST_CASE("check reports the eliminated coordinates and omitted elements, with reasons", "[elimination]") {
  const auto check = "check " + test::flores().string();
  const auto o = test::succeeded(check + " --why");
  CHECK_THAT(o.out, Contains("crank.x, crank.y") && Contains("slider.theta"));
  CHECK_THAT(o.out, Contains("each is fixed by a single constraint row") &&
                        Contains("film of gudgeon: no lubricant is given"));
  CHECK_THAT(test::freeplay(check + " --why --set run.eliminate=false").out, Contains("keeps the full DAE"));
  CHECK(test::freeplay(check + " --set run.eliminate=3").status == 2);
}

TEST_CASE("sensitivity propagates deviations in first order", "[sensitivity]") {
  // A drop by h = 0.5 m: t = √(2h/g), σ_t = σ_h/(g t).
  const test::TemporaryFolder folder;
  const auto scene = (folder.path() / "ball.toml").string();
  write_file(scene, "gravity = [0, -9.81]\n" + test::body("ball", 0.3, 3e-4, "position = [0, 0.55]\n") +
                        test::plane("table", "ground", "ball", 0.05) + test::surface("s", 0.5) +
                        test::run_for(0.4, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n"));
  const auto run = [&](const std::string& words) {
    return test::freeplay(
        fmt::format("sensitivity {} --of event.1.t -o {}/out {}", scene, folder.path().string(), words));
  };
  const auto propagated = run("--spread initial.ball.y=1e-3");
  CHECK(propagated.status == 0);
  CHECK_THAT(propagated.out, Contains(fmt::format("standard deviation {:.4g} (first order)",
                                                  1e-3 / (9.81 * std::sqrt(2 * 0.5 / 9.81)))));
  CHECK_THAT(run("--spread initial.ball.y").err, Contains("must be KEY=DEVIATION"));
  CHECK_THAT(run("--spread initial.ball.y=-1").err, Contains("must be KEY=DEVIATION"));
  CHECK_THAT(run("").err, Contains("must name at least one key"));
}

TEST_CASE("a continuation that cannot start leaves no files", "[orbit]") {
  // The ball's speed contradicts its guide, which lies along x.
  const test::TemporaryFolder folder;
  const auto place = folder.path().string();
  write_file(folder.path() / "scene.toml",
             test::body("ball", 1, 0.01, "velocity = [0, 1]\n") + test::guide("rail", "ground", "ball") +
                 test::harmonic("push", 1, 0.1) +
                 test::drive("shaker", "rail", "force = \"push\"\nagainst = \"time\"\n") +
                 test::run_for(1, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n"));
  write_file(folder.path() / "study.toml",
             "scene = \"scene.toml\"\n[continue]\nkey = \"curves.push.amplitude\"\nfrom = 1\nto = 2\n");
  test::refused("continue " + place + "/study.toml -o " + place + "/out", Contains("bodies.ball.velocity"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "out"));
}

TEST_CASE("two hundred random scenes are correct, doubtful or refused in every method",
          "[random-scenes][long]") {
  const test::TemporaryFolder folder;
  const auto place = folder.path().string();
  const auto o = test::freeplay("extremes --random-scenes 200 --seed 17 -o " + place + "/out --document " +
                                place + "/doc");
  CAPTURE(o.out, o.err);
  const auto table = test::file_text(folder.path() / "out/strangers.csv");
  const auto rows = test::lines_of(table).size() - 1;
  for (const char* defect : {",SILENT,", ",HUNG,", ",CRASHED,"}) CHECK(test::count(table, defect) == 0);
  CHECK(rows > 450);
  CHECK(static_cast<double>(test::count(table, ",refused,")) <= 0.03 * static_cast<double>(rows));
  CHECK(std::filesystem::exists(folder.path() / "doc/random-scenes.md"));
}
