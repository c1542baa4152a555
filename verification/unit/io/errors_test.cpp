// Error messages: in the program's own words, with their place, in few lines.
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/closure.hpp"
#include "dynamics/system.hpp"
#include "io/scene/section.hpp"
#include "io/scene/toml_text.hpp"
#include "study/runs/case_run.hpp"
#include "study/settings/study.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using test::refusal, test::replaced;

namespace {

std::string flores() { return test::file_text(test::flores()); }

/// U+`code` in UTF-8.
std::string utf8(unsigned code) {
  const auto byte = [](unsigned x) { return static_cast<char>(x); };
  if (code < 0x80) return {byte(code)};
  if (code < 0x800) return {byte(0xC0 | code >> 6), byte(0x80 | (code & 0x3F))};
  if (code < 0x10000)
    return {byte(0xE0 | code >> 12), byte(0x80 | (code >> 6 & 0x3F)), byte(0x80 | (code & 0x3F))};
  return {byte(0xF0 | code >> 18), byte(0x80 | (code >> 12 & 0x3F)), byte(0x80 | (code >> 6 & 0x3F)),
          byte(0x80 | (code & 0x3F))};
}

/// A rod between two pins of the ground at a distance of `apart`.
std::string rod(double length, double apart) {
  return test::body("rod", 1, 0.01, "position = [0.1, 0.02]\n") +
         test::pin("left", "ground", "rod", {}, {-length / 2, 0}) +
         test::pin("right", "ground", "rod", {apart, 0}, {length / 2, 0}) + test::run_for(1);
}

std::string not_assembled(const std::string& text) {
  const auto scene = parse_scene(text, "s.toml");
  return test::refusal_of([&] { assemble(scene.mechanism, RunOptions::Start::assembled); });
}

}  // namespace

TEST_CASE("text that is not TOML in UTF-8 is refused at its place; a byte order mark is accepted",
          "[scene][errors]") {
  CHECK_THAT(refusal("mass = 1.0\"é\"\n"), StartsWith("s.toml:1:11: not TOML: "));
  CHECK(refusal("\xEF\xBB\xBF" + flores()) == "accepted");
  CHECK_THAT(refusal("\xEF\xBB\xBFmass = = 1\n"), StartsWith("s.toml:1:8: not TOML: "));
  CHECK_THAT(refusal(std::string("\xFF\xFE[\0b\0", 6)),
             StartsWith("s.toml:1:1: not TOML: byte 0xFF is not UTF-8"));
  CHECK_THAT(refusal(std::string("title = \"ä\"\nx = \"a\0b\"\n", 23)),
             StartsWith("s.toml:2:7: not TOML: contains a NUL character"));
  // Columns count characters.
  CHECK_THAT(refusal("title = \"äöü\" x\n"), StartsWith("s.toml:1:15: "));
  // Truncated, overlong, a surrogate, beyond the last code point.
  for (const char* bytes : {"\xC3", "\x80", "\xC0\xAF", "\xE0\x80\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80",
                            "\xF5", "\xE2\x82", "\xF0\x9F\x92"}) {
    const auto message = refusal("# ok\ntitle = \"a" + std::string(bytes) + "\"\n");
    CAPTURE(message);
    CHECK_THAT(message, StartsWith("s.toml:2:11: not TOML: byte 0x") && Contains("is not UTF-8"));
  }
  // Text that violates the parser's own assumptions is reported with its place too.
  CHECK_THAT(refusal("a = 1\n[b]\nc = [1,,\n"), StartsWith("s.toml:3:"));
  for (const char* text : {"mass = = 1\n",
                           "mass = 1.0\"é\"\n",
                           "[bodies\n",
                           "[#a]\n",
                           "title = \"x\n",
                           "a = [1, 2\n",
                           "a = {x = 1\n",
                           "title = \"\\q\"\n",
                           "a = 1\na = 2\n",
                           "[a]\n[a]\n",
                           "a.b = 1\na = 2\n",
                           "x = 0x\n",
                           "x = 1__0\n",
                           "x = 99999999999999999999\n",
                           "x = 2026-13-01\n",
                           "é = 1\n",
                           "title = \"\xFF\"\n",
                           "title = '''a\n",
                           "= 1\n",
                           "a = [1,,2]\n",
                           "[[a]]\n[a]\n",
                           "\"a\\nb\" = 1\n",
                           "a = [}\n",
                           "[a]]\n",
                           "key\n"}) {
    CAPTURE(text);
    CHECK_THAT(refusal(text), StartsWith("s.toml:"));
    CHECK(test::fault_of(refusal(text) + "\n").empty());
  }
}

TEST_CASE("any character is accepted inside a string, and none outside causes harm", "[scene][errors]") {
  // Every range that the parser's own test for spaces distinguishes, at its ends and within.
  int refused = 0;
  for (unsigned code = 0x80; code < 0x110000; code += code < 0x4000 ? 1 : 97) {
    if (code >= 0xD800 && code <= 0xDFFF) continue;
    const auto c = utf8(code);
    const auto inside = parse_toml("t = \"\"\"a\\\n  " + c + "b\"\"\"\nu = '" + c + "' # " + c + "\n", "t");
    REQUIRE(inside["u"].value<std::string>() == c);
    for (const auto* value : {"1.0", "1", "true", "\"x\"", "[1]", "2026-01-01", "0x1", "inf"}) {
      try {
        parse_toml(fmt::format("m = {}\"{}\"\n", value, c), "t");
      } catch (const SceneError&) {
        ++refused;
      }
    }
  }
  CHECK(refused > 8 * 16000);
}

TEST_CASE("a misspelt key is reported before its consequences", "[scene][errors]") {
  // Without its clearance the gudgeon's bearing_radius would not apply.
  CHECK_THAT(refusal(replaced(flores(), "clearance =", "clearence =")),
             Contains("joints.gudgeon.clearence: is not a key of a joint; did you mean clearance?"));
  CHECK_THAT(refusal(replaced(flores(), "speed_rpm", "sped_rpm")), Contains("did you mean speed_rpm?"));
  CHECK_THAT(refusal(replaced(flores(), "[joints.main]", "[joint.main]")),
             Contains("joint: is not a key of a scene; did you mean joints?"));
  // The first key in the file, and one that is a key elsewhere.
  const auto two = replaced(replaced(flores(), "mass =", "mas ="), "poisson =", "poison =");
  CHECK_THAT(refusal(two), Contains(".mas: is not a key of a body; did you mean mass?"));
  CHECK_THAT(refusal(replaced(flores(), "surface =", "friction = 0.1\nsurface =")),
             Contains("joints.gudgeon.friction: is not a key of a joint; it belongs to surfaces.*"));
  CHECK_THAT(refusal(replaced(flores(), "[run]", "[run]\nqqqqqqqqq = 1")),
             Contains("is not a key of [run]\n  there are duration,") ||
                 Contains("is not a key of [run]; there are"));
}

TEST_CASE("an option is quoted as it was typed", "[scene][errors]") {
  const auto scene = flores();
  CHECK_THAT(refusal(scene, {"joints.gudgen.clearance=1e-3"}),
             StartsWith("--set joints.gudgen.clearance=1e-3: joints.gudgen: there is no such joint; "
                        "did you mean gudgeon?"));
  CHECK_THAT(refusal(scene, {"drives.q.crank=true"}),
             StartsWith("--set drives.q.crank=true: drives.q: there is no such drive; there is "));
  CHECK_THAT(refusal(scene, {"bodies.crnk.mass=2"}), Contains("there is no such body; did you mean crank?"));
  CHECK_THAT(refusal(scene, {"joints.gudgeon.clearance=abc"}), Contains("must be a number, is a text"));
  // A surface has no required keys: one that no element names would be without effect.
  CHECK_THAT(refusal(scene, {"surfaces.stel.friction=0.1"}),
             Contains("there is no such surface; did you mean steel?"));
  CHECK(refusal(scene, {"surfaces.brass.friction=0.1", "joints.gudgeon.surface=brass"}) == "accepted");
  CHECK(refusal(scene, {"loads.push.type=force", "loads.push.body=slider", "loads.push.force=[1, 0]"}) ==
        "accepted");
  CHECK_THAT(
      refusal(scene, {"joints.gudgeon.clearence=1"}),
      StartsWith(
          "--set joints.gudgeon.clearence=1: joints.gudgeon.clearence: is not a key of a joint; did you"));
  // The message names the key of the file and the option that made it invalid.
  CHECK_THAT(refusal(scene, {"joints.gudgeon.clearance=1"}),
             StartsWith("s.toml:") && Contains("bearing_radius: must be greater than the clearance") &&
                 Contains("(with --set joints.gudgeon.clearance=1)"));
  for (const auto* broken : {"=1", "a", "a=", "bodies..mass=1", "bodies.crank.=1", "title.x=1", ".a=1"})
    CHECK_THAT(refusal(scene, {broken}), StartsWith(fmt::format("--set {}: ", broken)));
  CHECK_THAT(refusal(scene, {"title=1\nmass = 2"}), StartsWith("--set title=1\\nmass = 2: "));
}

TEST_CASE("an invalid setting in a study is reported at its place in the study", "[study][errors]") {
  test::TemporaryFolder folder;
  const auto refused = [&](const std::string& rest) {
    write_file(
        folder.path() / "study.toml",
        fmt::format("scene = \"{}\"\njoint = \"gudgeon\"\naccelerometer = \"accelerometer\"\n{}",
                    (test::source_folder() / "cases/flores2011-experiment/guide.toml").string(), rest));
    const auto said = test::refusal_of([&] {
      const auto study = read_study(folder.path() / "study.toml");
      for (const auto& one : cases(study)) identity(study, one, {});
    });
    return said.substr(said.find("study.toml"));
  };
  CHECK_THAT(
      refused("[axes.c]\nkey = \"joints.gudgen.clearance\"\nvalues = [1e-3]\n"),
      StartsWith("study.toml:4:1: axes.c: joints.gudgen: there is no such joint; did you mean gudgeon?"));
  CHECK_THAT(refused("[axes.c]\nkey = \"joints.gudgeon.clearance\"\nvalues = [1e-3, -1.0]\n"),
             StartsWith("study.toml:4:1: axes.c: joints.gudgeon.clearance: must be greater than 0, is -1"));
  CHECK_THAT(
      refused("[variants.v]\nset = [\"joints.gudgeon.clearence=1\"]\n"),
      StartsWith("study.toml:4:1: variants.v: joints.gudgeon.clearence: is not a key of a joint; did you"));
  CHECK_THAT(refused("[axis.c]\nkey = \"x\"\n"),
             StartsWith("study.toml:4:1: axis: is not a key of a study; did you mean axes?"));
  // A hundred million runs are a mistake, not a study.
  std::string many, values = "1";
  for (int i = 2; i <= 100; ++i) values += fmt::format(", {}", i);
  for (const char* name : {"a", "b", "c", "d"})
    many += fmt::format("[axes.{0}]\nkey = \"bodies.{0}.mass\"\nvalues = [{1}]\n", name, values);
  CHECK_THAT(refused(many), Contains("has 1.6e+09 runs"));
}

TEST_CASE("a loop that cannot be closed is reported by the joint and the distance in the best pose",
          "[assembly][errors]") {
  // A rod of 0.3 m between pins 1 m apart: least squares share the missing 0.7 m.
  CHECK_THAT(not_assembled(rod(0.3, 1)),
             Contains("check the lengths") &&
                 (Contains("joints.left: cannot be closed: in the best pose found, it stays open by 0.35 m, "
                           "\"right\" by 0.35 m") ||
                  Contains("joints.right: cannot be closed: in the best pose found, it stays open by 0.35 m, "
                           "\"left\" by 0.35 m")));
  // A crank held by its drive where the rod cannot reach: the message names the joints and the
  // required change of the drive.
  const auto driven = [](double angle) {
    return test::body("crank", 1, 0.01) + test::body("rod", 1, 0.01, "position = [0.5, 0.1]\n") +
           test::pin("axle", "ground", "crank", {}, {-0.5, 0}) +
           test::pin("pin", "crank", "rod", {0.5, 0}, {-0.5, 0}) +
           test::pin("anchor", "ground", "rod", {1.5, 0}, {0.5, 0}) +
           fmt::format("[drives.motor]\njoint = \"axle\"\nspeed = 0\ninitial_angle = {}\n", angle) +
           "[assembly]\napproximate = true\n" + test::run_for(1);
  };
  // The pin is 1 m from the anchor where (1.5 − cos θ)² + sin² θ = 1, at cos θ = 3/4.
  CHECK(not_assembled(driven(std::acos(0.75))) == "accepted");
  // At a right angle it is √(1.5² + 1) = 1.8028 m away: 0.8028 m too far, in three joints.
  const auto message = not_assembled(driven(std::acos(0.0)));
  CAPTURE(message);
  CHECK_THAT(message,
             StartsWith("joints.") && Contains("it stays open by 0.2676 m, ") && !Contains("\"motor\""));
  for (const char* name : {"axle", "pin", "anchor"}) CHECK_THAT(message, Contains(name));
  CHECK_THAT(message, Contains("it closes with drives.motor.initial_angle = 0.7227"));
  // A loop that can be closed is closed from any start nearby.
  const auto scene = parse_scene(rod(0.3, 0.3), "s.toml");
  const System system(scene.mechanism);
  std::vector<double> q{0.3, -0.2, 1};
  best_pose(system, 0.15, true, q);
  CHECK(worst_open_joint(system, q).amount < 1e-12);
  CHECK(open_joints(system, {0.15, 0.1, 0}, 0.15).size() == 2);
}

TEST_CASE(
    "a snapshot with any changed byte is accepted or refused; a refusal leaves the simulation unchanged",
    "[snapshot][errors]") {
  const auto scene = parse_scene(replaced(flores(), "revolutions = 12", "revolutions = 0.01"), "s.toml",
                                 {"run.discard=0", "nonsmooth.scheme=event-driven"});
  for (const auto* formulation : {"penalty", "nonsmooth"}) {
    Simulation simulation(scene, formulation);
    simulation.run({.until = 1e-4});
    const auto before = simulation.snapshot();
    int refused = 0;
    for (std::size_t i = 0; i < before.memory.size(); ++i) {
      auto changed = before;
      changed.memory[i] ^= std::byte{0x41};
      try {
        simulation.restore(changed);
        simulation.restore(before);
      } catch (const SnapshotError& e) {
        ++refused;
        REQUIRE_THAT(e.what(), StartsWith("the snapshot"));
      }
      REQUIRE(simulation.snapshot().memory == before.memory);
    }
    CHECK(refused > 100);  // of the lengths and the names of parts
  }
}
