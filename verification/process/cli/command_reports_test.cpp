// Reports of commands: settings of --accuracy and advise, the error estimate of first contacts,
// eliminated coordinates, a continuation that cannot start, two hundred random scenes, sensitivities,
// and a drive's turn.
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using namespace freeplay::test;

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

namespace {

/// A ball that is dropped from (0.1, 0.55) with a horizontal speed of −0.25 m/s: x = 0 at the end,
/// after 0.4 s.
const std::string ball = "gravity = [0, -9.81]\n" +
                         test::body("ball", 0.3, 3e-4, "position = [0.1, 0.55]\nvelocity = [-0.25, 0]\n") +
                         test::plane("table", "ground", "ball", 0.05, "hard") + test::surface("hard", 0.5) +
                         test::run_for(0.4, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n");

struct Command {
  test::TemporaryFolder folder;
  test::Outcome run(const std::string& words) const {
    const auto place = folder.path().string();
    write_file(folder.path() / "ball.toml", ball);
    return test::freeplay("sensitivity " + place + "/ball.toml -o " + place + "/out " + words);
  }
  nlohmann::json document() const { return test::read_json(folder.path() / "out/sensitivity.json"); }
};

}  // namespace

TEST_CASE("sensitivity propagates deviations in first order", "[sensitivity]") {
  // A drop by h = 0.5 m: t = √(2h/g), σ_t = σ_h/(g t).
  const auto run = Command().run("--of event.1.t --spread initial.ball.y=1e-3");
  CHECK(run.status == 0);
  CHECK_THAT(run.out, Contains(fmt::format("standard deviation {:.4g} (first order)",
                                           1e-3 / (9.81 * std::sqrt(2 * 0.5 / 9.81)))));
}

TEST_CASE("a value of zero and a missing derivative have no relative influence", "[sensitivity]") {
  const Command c;
  const auto run =
      c.run("--of end.ball.x --of event.1.t --of event.9.t --to bodies.ball.position[0] --to gravity[1]");
  CAPTURE(run.out, run.err);
  REQUIRE(run.status == 0);
  const auto q = c.document()["quantities"];
  CHECK(std::abs(q[0]["value"].get<double>()) < 1e-14);
  CHECK(q[0]["derivatives"]["bodies.ball.position[0]"].get<double>() == Approx(1));
  CHECK(q[0]["relative_influence"]["bodies.ball.position[0]"].is_null());
  CHECK(q[0]["condition"].is_null());
  // t = √(2H/g)
  CHECK(q[1]["relative_influence"]["gravity[1]"].get<double>() == Approx(-0.5));
  CHECK(q[1]["condition"].get<double>() == Approx(0.5));
  CHECK(q[1]["error"]["gravity[1]"].get<double>() <
        1e-6 * std::abs(q[1]["derivatives"]["gravity[1]"].get<double>()));
  CHECK(q[1]["inexact"].empty());
  CHECK_THAT(run.out, Contains(" ± "));
  CHECK(q[2]["error"]["gravity[1]"].is_null());
  CHECK(q[2]["condition"].is_null());
}

TEST_CASE("the figure of influences names all its quantities", "[sensitivity]") {
  const Command c;
  const auto run = c.run(
      "--of event.1.t --of event.1.v_n_minus --of event.1.impulse_n --of end.ball.y --of end.ball.vy "
      "--of energy.kinetic --of energy.dissipated_in_contacts --to gravity[1]");
  CAPTURE(run.out, run.err);
  REQUIRE(run.status == 0);
  // two columns of four
  CHECK_THAT(test::file_text(c.folder.path() / "out/figures/sensitivity.gp"), Contains("vertical maxrows 4"));
}

TEST_CASE("the command sensitivity refuses wrong quantities and deviations", "[sensitivity]") {
  const Command c;
  const auto refused = [&](const std::string& words, const std::string& text) {
    const auto run = c.run(words);
    CAPTURE(words, run.out);
    CHECK(run.status != 0);
    CHECK_THAT(run.err, Contains(text));
  };
  refused("--of event.9.t --to gravity[1]", "reaches none of the quantities");
  refused("--of event.1.t --spread gravity[1]=0.1 --spread gravity[1]=0.2", "has a deviation already");
  refused("--of event.1.t --spread initial.ball.y", "must be KEY=DEVIATION");
  refused("--of event.1.t --spread initial.ball.y=-1", "must be KEY=DEVIATION");
  refused("--of event.1.t", "must name at least one key");
  refused("--of end.bal.y --to gravity[1]", "did you mean ball.y?");
  refused("--of end.t --to gravity[1]", "has no derivative");
}

namespace {

/// The output of `check` for a scene.
std::string said_of(const std::string& text) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "s.toml";
  write_file(file, text);
  return freeplay::test::freeplay("check " + file.string()).out;
}

/// The words of a text, with single spaces.
std::string unwrapped(const std::string& text) {
  std::istringstream words(text);
  std::string line;
  for (std::string word; words >> word;) line += word + " ";
  return line;
}

}  // namespace

TEST_CASE("check reports the drive's turn within 80 columns", "[whole-turn]") {
  const double r = 0.05, l = 0.12, e = 0.02;
  const auto said = said_of(
      "format = 2\nassembly.approximate = true\n" + body("crank", 1, 0.01, "angle = 0.1\n") +
      body("rod", 1, 0.01, "angle = 0.0\n") + body("slider", 1, 0.01) +
      pin("A", "ground", "crank", {}, {-r / 2, 0}) + pin("B", "crank", "rod", {r / 2, 0}, {-l / 2, 0}) +
      pin("C", "rod", "slider", {l / 2, 0}) + guide("G", "ground", "slider", {1, 0}, {0.0, e}) +
      drive("motor", "A", "speed_rpm = 60.0\n") + run_for(1));
  CHECK_THAT(said, Contains("turn of the drive           A closes over a full turn"));
  CHECK_THAT(said, Contains("transmission angle"));
  CHECK_THAT(said, Contains("least 54.31 deg at 270 deg"));  // acos(0.07/0.12)
  for (const auto& line : lines_of(said)) CHECK(width(line) <= 80);
}

TEST_CASE("check lists all corrected values where the note names three", "[check]") {
  // A row of five bodies, each on a pin of its own whose place its stated position misses by 1 mm to 5 mm.
  std::string text = "assembly.approximate = true\n";
  for (int i = 1; i <= 5; ++i)
    text +=
        body(fmt::format("b{}", i), 1, 0.01, fmt::format("position = [{}, 0]\nangle = 0\n", i + 1e-3 * i)) +
        pin(fmt::format("p{}", i), "ground", fmt::format("b{}", i), {1.0 * i, 0});
  const auto said = unwrapped(said_of(text + run_for(1)));
  CHECK_THAT(said, Contains("and 2 more"));
  for (int i = 1; i <= 5; ++i)
    CHECK_THAT(said, Contains(fmt::format("bodies.b{}.position by 0.00{} m", i, i)));
}

TEST_CASE("check reports losses of teeth, controllers and freewheels", "[check]") {
  const auto said = [](const std::string& name, const std::string& more = "") {
    return unwrapped(
        test::succeeded("check " + (test::source_folder() / "cases" / name / "scene.toml").string() + more)
            .out);
  };
  // tan γ/tan(γ + ρ) and tan(γ − ρ)/tan γ with γ = 5°, ρ = atan 0.12
  CHECK_THAT(
      said("worm-hoist"),
      Contains("efficiency of mesh 0.4172 where worm drives; -0.3677 where wheel drives: self-locking, "
               "wheel cannot drive worm"));
  CHECK_THAT(said("worm-hoist", " --set joints.mesh.mesh_friction=0.05"),
             Contains("0.4266 where wheel drives") && !Contains("cannot drive"));
  CHECK_THAT(
      said("sampled-servo"),
      Contains("controller servo sampled every 5 ms, dead time 0 ms, exact measurement, measures rail"));
  CHECK_THAT(said("sampled-servo",
                  " --set drives.servo.dead_time=2e-3 --set drives.servo.resolution=1e-5 --set "
                  "drives.servo.force_limit=3"),
             Contains("dead time 2 ms, resolution 1e-05 m, at most 3 N, measures rail"));
  CHECK_THAT(
      said("freewheel-feed"),
      Contains("freewheel clutch wheel turns freely against lever counter-clockwise; clockwise it is held up "
               "to 2 N m"));
}

TEST_CASE("a mechanism that its drive locks stops with the reason", "[whole-turn]") {
  // Grashof: the longest link 240 mm and the shortest 160 mm exceed the sum of the others: no full turn.
  const std::string text =
      "gravity = [0, -9.81]\n" + body("crank", 0.3, 2e-4) + body("coupler", 0.5, 3e-3) +
      body("rocker", 0.4, 1.2e-3, "angle = \"80 deg\"\n") + pin("A", "ground", "crank") +
      pin("B", "crank", "coupler", {0.16, 0}, {-0.11, -0.02}, loose(1.5e-4, 0.008, "steel")) +
      pin("C", "coupler", "rocker", {0.11, -0.02}, {0.075, 0}, loose(3e-4, 0.008, "steel")) +
      pin("D", "ground", "rocker", {0.24, 0.02}, {-0.075, 0}) + surface("steel", 0.6, 0.08) +
      drive("motor", "A", "speed_rpm = 180\n") + "[assembly]\napproximate = true\n" +
      run_for(0.2, "start = \"ideal\"\n") + "[nonsmooth]\nscheme = \"automatic\"\n";
  const TemporaryFolder folder;
  const auto scene = folder.path() / "locked.toml";
  write_file(scene, text);
  const auto ran = freeplay::test::freeplay(
      fmt::format("run {} --formulation nonsmooth -o {}/out", scene.string(), folder.path().string()));
  CHECK(ran.status == 1);
  CHECK_THAT(ran.err,
             Contains("cannot make a full turn") && Contains("a drive moves it beyond the configuration"));
}

TEST_CASE("check names a controller whose measured joint turns against the driven one", "[whole-turn]") {
  const auto said = [](const std::string& bearing) {
    return said_of(
        body("motor", 0.4, 1e-4) + body("load", 3.0, 0.01, "position = [0.04, 0]\n") +
        pin("shaft", "ground", "motor") + bearing +
        joint("mesh", "gear", "motor", "load", {}, {}, "teeth = [20, 60]\nmodule = 1e-3\n") +
        drive("servo", "shaft", "measured = \"bearing\"\ntarget_angle = 1.0\nproportional = 2.0\n") +
        run_for(1, "start = \"given\"\n"));
  };
  CHECK_THAT(said(pin("bearing", "ground", "load", {0.04, 0})),
             Contains("-0.333333 turns") && Contains("positive feedback") && Contains("drives.servo"));
  CHECK_THAT(said(pin("bearing", "load", "ground", {}, {0.04, 0})),
             Contains("0.333333 turns") && !Contains("positive feedback"));
}
