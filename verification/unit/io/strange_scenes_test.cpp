// Unusual scenes: an error states the place and a remedy, a figure shows the actual pose, and a
// smooth force is not reported as doubtful.
#include "dynamics/assembly/assembly.hpp"
#include "io/scene/pose_file.hpp"
#include "io/scene/read_scene.hpp"
#include "study/runs/case_run.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

const std::string block = "[bodies.b]\nmass = 1\ninertia = 0.01\nposition = [0.1, 0]\n";
const std::string guide = "[joints.g]\ntype = \"translational\"\nbetween = [\"ground\", \"b\"]\n";
const std::string steel = "surface = \"s\"\n[surfaces.s]\nyoung = 2e11\npoisson = 0.3\nrestitution = 0.5\n";
const std::string run = "[run]\nduration = 0.5\n";

/// The message with which a run by the penalty formulation is refused.
std::string refused(const std::string& text) {
  const auto scene = parse_scene(text, "s.toml");
  return test::refusal_of<SceneError>(
      [&] { located_in(scene, [&] { return Simulation(scene, "penalty").state(); }); });
}

/// Rows of a pose figure's table with this beginning.
long rows(const std::string& text, const std::string& begin) {
  const auto scene = parse_scene(text + run, "s.toml");
  const auto table = "\n" + pose_table(scene, assemble(scene.mechanism, RunOptions::Start::assembled));
  long n = 0;
  for (auto at = table.find("\n" + begin); at != table.npos; at = table.find("\n" + begin, at + 1)) ++n;
  return n;
}

}  // namespace

TEST_CASE("a penalty contact without stiffness names the key that provides it", "[errors][strange]") {
  CHECK_THAT(
      refused(block + guide + "clearance = 1e-3\nslider_length = 0.1\nslider_height = 0.05\n" + steel + run),
      Contains("s.toml:5:1: joints.g.corner_radius: is missing"));
  CHECK_THAT(refused(block + guide + "[contacts.t]\ntype = \"travel-stop\"\njoint = \"g\"\nupper = 0.2\n" +
                     steel + run),
             Contains("s.toml:8:1: contacts.t.stiffness: is missing"));
  CHECK_THAT(
      refused(block + "[contacts.p]\ntype = \"plane\"\nbetween = [\"ground\", \"b\"]\n" + steel + run),
      Contains(
          "s.toml:5:1: contacts.p.stiffness: is missing: a penalty contact of a sharp corner needs it as "
          "stiffness"));
}

TEST_CASE("a force over position is averaged correctly over a step that hardly moves", "[driving][strange]") {
  // From rest the block moves by 2.5e-8 m in a step of 1e-4 s: the mean over that is exact, and the
  // result is not doubtful.
  const auto text =
      block + guide +
      "[curves.c]\nshape = \"table\"\npoints = [[-1, 50], [1, -50]]\n[drives.d]\njoint = \"g\"\n"
      "force = \"c\"\nagainst = \"position\"\n[nonsmooth]\nscheme = \"moreau-jean\"\nstep = 1e-4\n" +
      run;
  for (const auto* way : {"[\"ground\", \"b\"]", "[\"b\", \"ground\"]"}) {
    auto turned = text;
    const std::string given = "[\"ground\", \"b\"]";
    turned.replace(turned.find(given), given.size(), way);
    const auto result = test::simulate(parse_scene(turned, "s.toml"), Family::nonsmooth);
    CHECK(result.notes.empty());
    // The phase error of the midpoint rule is (ωh)²/24 a step: 1e-7 over ωT = 3.5.
    CHECK(result.final_state.q[0] == Approx(0.1 * std::cos(std::sqrt(50.0) * 0.5)).margin(1e-7));
  }
}

TEST_CASE("the figure of a pose shows the end of a bushing and one box for each guide",
          "[figures][strange]") {
  const std::string bushing =
      "[loads.u]\ntype = \"bushing\"\nbetween = [\"ground\", \"b\"]\nat = [[0, 0], [-0.1, 0]]\n"
      "stiffness = [1, 1]\n";
  CHECK(rows(block + bushing, "link,b,") == 2);  // from the bushing to the centre of mass
  const std::string yoke =
      "[bodies.c]\nmass = 1\ninertia = 0.01\n[joints.m]\ntype = \"revolute\"\nbetween = "
      "[\"ground\", \"c\"]\n[joints.s]\ntype = \"slot\"\nbetween = [\"b\", \"c\"]\n"
      "at = [[0, 0], [0.1, 0]]\naxis = [0, 1]\n";
  CHECK(rows(block + guide + yoke, "slider,") == 1);
  CHECK(rows(block + guide + yoke, "line,s,") == 1);
  CHECK(rows(block + guide + yoke, "pin,s,") == 1);
}

TEST_CASE("permission of a study to read files anywhere extends to its scenes", "[study][strange]") {
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "inner");
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(folder.path() / name) << text;
  };
  write("m.csv", "t,torque\n0,1\n1,2\n");
  write("inner/s.toml",
        block +
            "[joints.j]\ntype = \"revolute\"\nbetween = [\"ground\", \"b\"]\nat = [[0, 0], [-0.1, 0]]\n"
            "[curves.c]\nshape = \"table\"\nfile = \"../m.csv\"\n[drives.d]\njoint = \"j\"\nspeed = 10\n"
            "[drives.e]\njoint = \"j\"\ntorque_curve = \"c\"\n" +
            run);
  write("inner/study.toml",
        "title = \"t\"\nscene = \"s.toml\"\nrevolutions = 1\nstarts = 1\nturn = 0\n"
        "restitution = \"as-given\"\n");
  for (const auto reach : {Reach::beside, Reach::anywhere}) {
    const auto study = read_study(folder.path() / "inner" / "study.toml", reach);
    const auto one = cases(study).at(0);
    if (reach == Reach::anywhere)
      CHECK(scene_of(study, one, {}).mechanism.curves.size() == 1);
    else
      CHECK_THROWS_WITH(scene_of(study, one, {}), Contains("--allow-outside"));
  }
}
