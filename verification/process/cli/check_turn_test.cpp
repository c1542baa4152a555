// What check and run report of a drive's turn: its range, a mechanism that it locks, and a
// controller whose measured joint turns backwards.
#include "verification/support/rig.hpp"

using namespace freeplay;
using namespace freeplay::test;
using Catch::Matchers::Contains;

namespace {

/// The output of `check` for a scene.
std::string said_of(const std::string& text) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "s.toml";
  write_file(file, text);
  return freeplay::test::freeplay("check " + file.string()).out;
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
  for (const auto& line : lines_of(said))
    CHECK(std::ranges::count_if(line, [](char c) { return (c & 0xC0) != 0x80; }) <= 80);
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
