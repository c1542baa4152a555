// Six common mistakes: each is reported with its line and its cause.
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

/// From line 1: a rod on a pin, with a link to the ground.
std::string scene() {
  return R"([bodies.rod]
mass = 1.0
inertia = 0.01
[bodies.link]
mass = 1.0
inertia = 0.01
[joints.left]
type = "revolute"
between = ["ground", "rod"]
at = [[0, 0], [-0.2, 0]]
clearance = "0.1 mm"
bearing_radius = "10 mm"
surface = "steel"
[joints.middle]
type = "revolute"
between = ["rod", "link"]
at = [[0.2, 0], [-0.1, 0]]
[joints.right]
type = "revolute"
between = ["ground", "link"]
at = [[0.5, 0], [0.1, 0]]
[surfaces.steel]
restitution = 0.5
[run]
duration = 0.1
)";
}

struct Told {
  int status;
  std::string words;
};

/// Output of `freeplay check` for the scene with `from` replaced by `to`, without the folder's
/// name.
Told told(const std::string& from, const std::string& to) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "s.toml";
  std::ofstream(file) << test::replaced(scene(), from, to);
  const auto outcome = test::freeplay("check " + file.string());
  auto words = outcome.err;
  for (auto p = words.find(folder.path().string()); p != words.npos; p = words.find(folder.path().string()))
    words.erase(p, folder.path().string().size() + 1);
  return {outcome.status, words};
}

void expect(const Told& said, const std::string& place, const std::vector<std::string>& pieces) {
  CAPTURE(said.words);
  CHECK(said.status == 2);
  CHECK_THAT(said.words, StartsWith(place));
  for (const auto& piece : pieces) CHECK_THAT(said.words, Contains(piece));
}

}  // namespace

TEST_CASE("six common mistakes are reported with their line and cause", "[mistakes][errors]") {
  CHECK(told("mass = 1.0", "mass = 1.0").status == 0);
  // 1. A misspelt key.
  expect(told("clearance =", "clearence ="),
         "s.toml:11:", {"joints.left.clearence: is not a key of a joint; did you mean clearance?"});
  // 2. A wrong unit.
  expect(told("\"0.1 mm\"", "\"0.1 kg\""),
         "s.toml:11:", {"joints.left.clearance: \"0.1 kg\" is a mass, must be a length"});
  // 3. A body that is not there.
  expect(told("between = [\"rod\", \"link\"]", "between = [\"rod\", \"lnk\"]"),
         "s.toml:16:", {"joints.middle.between: there is no body \"lnk\"", "ground, rod, link"});
  // 4. Lengths that cannot close: rod 0.4 m and link 0.2 m between pins 1 m apart; a distance of
  // 0.4 m minus the clearance remains.
  expect(told("at = [[0.5, 0], [0.1, 0]]", "at = [[1, 0], [0.1, 0]]"), "s.toml:",
         {"joints.", "cannot be closed: in the best pose found, it stays open by 0.", "check the lengths"});
  // 5. A wrong type.
  expect(told("type = \"revolute\"", "type = \"revolut\""),
         "s.toml:8:", {"joints.left.type: \"revolut\" is unknown", "\"revolute\""});
  expect(told("mass = 1.0", "mass = true"),
         "s.toml:2:", {"bodies.rod.mass: must be a number, is true or false"});
  // 6. A start that violates closure: all bodies at the origin, used as given.
  expect(told("duration = 0.1", "duration = 0.1\nstart = \"given\""), "s.toml:",
         {"run.start: \"given\": joints.", "stays open by 0.", "correct the positions or use \"assembled\""});
}

TEST_CASE("a scene in place of a study is reported, and a study in place of a scene", "[mistakes][errors]") {
  const test::TemporaryFolder folder;
  const auto scene_file = (folder.path() / "s.toml").string(),
             study = (folder.path() / "study.toml").string();
  std::ofstream(scene_file) << scene();
  std::ofstream(study) << "scene = \"s.toml\"\n";
  const auto said = [&](const std::string& line, const std::string& file, const char* what) {
    test::refused(line + " " + file, StartsWith(file + ": ") && Contains(what));
  };
  for (const char* verb : {"sweep", "bifurcation", "basin", "calibrate", "tradeoff"})
    said(verb, scene_file, "is a scene; a study refers to one by scene = \"s.toml\"");
  for (const char* verb : {"check", "run --formulation penalty", "compare", "poincare", "advise"})
    said(verb, study, "is a study, for freeplay sweep, bifurcation or basin");
}
