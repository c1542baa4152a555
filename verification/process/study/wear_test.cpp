// freeplay wear: a bearing under a constant load against the closed form of its worn area, in both formulations;
// interrupted and continued; refused scenes; the files of the command, and scenes that begin with them.
#include <atomic>

#include "io/scene/read_scene.hpp"
#include "study/wear/wear_documents.hpp"
#include "study/wear/worn_profile.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

const std::string quick =
    "scene = \"scene.toml\"\nrevolutions = 1\ndiscard = 0.5\nstarts = 1\nturn = 0\nplay = 0\n";

WearStudy wear_of(const Study& study, const std::filesystem::path& folder, StopToken stop = {},
                  const std::function<void(const WearProgress&)>& on_progress = {}) {
  make_folder(folder);
  EnsembleStore store(folder / "wear.db", Database::Access::write, stop);
  return wear_study(study, {true, stop}, store, 2, on_progress);
}

}  // namespace

TEST_CASE("a bearing under a constant load wears to the circle of its pin in both formulations", "[wear]") {
  // 100 N at 2π 9.5 mm a turn with k = 1e-15 m²/N on 20 mm: A = k F s/L is the area of the lune of 10 um,
  // 2.576047807662549e-8 m² (two circles of 9.5 and 10 mm), after s = 5152.095615098325 m = 86313.9 turns. The
  // elastic deflection under 1.5 MPa is 1e-9 m, less than 2e-4 of the depth.
  constexpr double turns = 5152.095615098325 / (2 * 3.141592653589793 * 9.5e-3);
  const test::StudyDesk desk("wear-steady");
  const auto study =
      desk.read(quick + fmt::format("[wear]\nturns = {:.17g}\nlife_clearance = \"0.51 mm\"\n", turns));
  const auto all = wear_of(study, desk.at("out"));
  REQUIRE(all.histories.size() == 2);
  CHECK(all.failures.empty());
  CHECK(all.turn == Approx(1));
  for (const auto& h : all.histories) {
    CAPTURE(h.formulation);
    REQUIRE(h.cycles.size() > 1);
    const auto& last = h.cycles.back();
    const auto& pin = last.joints[0];
    CHECK(last.turns == Approx(turns));
    // The contact law may let the block oscillate; its mean force over a turn differs by less than 1e-3.
    CHECK(pin.bearing.bearing_area() ==
          Approx(2.576047807662549e-8).epsilon(h.formulation == "penalty" ? 2e-3 : 1e-6));
    CHECK(pin.in_bearing.depth == Approx(10e-6).epsilon(h.formulation == "penalty" ? 3e-3 : 1e-3));
    CHECK(pin.in_journal.depth == 0);
    // Where the block is pushed down, the shaft presses the upper side of its bearing.
    const auto depth = pin.bearing.bearing_depth();
    const auto deepest = std::ranges::max_element(depth) - depth.begin();
    CHECK(std::abs(deepest - 180) <= 1);  // 90°
    CHECK(h.rounding < 0.03 * 10e-6 + 3e-8);
  }
  // The centre is free between c on one side and c + depth on the other; 0.51 mm: a depth of 20 um.
  CHECK(life_of(all.histories[1], 0, 0.505e-3).turns == Approx(turns).epsilon(0.01));
  CHECK_THAT(conclusion(*study.wear, all), Contains("A clearance of 510 um is reached after"));
}

TEST_CASE("an interrupted wear study continues to the results of an undisturbed one", "[wear][resume]") {
  const test::StudyDesk desk("wear-steady");
  const auto study =
      desk.read("formulations = [\"nonsmooth\"]\n" +
                test::replaced(test::replaced(quick, "starts = 1", "starts = 3"), "turn = 0", "turn = 1") +
                "[wear]\nturns = 2e6\nshare = 0.02\n");
  const auto whole = wear_of(study, desk.at("whole"));
  REQUIRE(whole.histories.at(0).cycles.size() > 4);
  CHECK(whole.made >= 15);
  for (const int after : {1, 3}) {
    CAPTURE(after);
    std::atomic<bool> stop{false};
    const auto part = wear_of(study, desk.at("part"), StopToken(stop), [&](const WearProgress& p) {
      if (p.set > after) stop = true;
    });
    CHECK(part.interrupted);
  }
  const auto rest = wear_of(study, desk.at("part"));
  CHECK(rest.found >= 12);
  CHECK(rest.found + rest.made == whole.made);
  CHECK(wear_table(rest).csv() == wear_table(whole).csv());
  CHECK(profiles_table(rest).csv() == profiles_table(whole).csv());
  const auto again = wear_of(study, desk.at("part"));
  CHECK(again.made == 0);
  CHECK(wear_table(again).csv() == wear_table(whole).csv());
}

TEST_CASE("freeplay wear writes its files, and refuses scenes without wear", "[wear]") {
  const test::StudyDesk desk("wear-steady");
  desk.put("study.toml", "formulations = [\"nonsmooth\"]\n" + quick + "[wear]\nturns = 1e5\npoints = 360\n");
  const auto o = desk.run("wear");
  CAPTURE(o.out, o.err);
  REQUIRE(o.status == 0);
  CHECK_THAT(o.out, Contains("the bearing of pin is worn by"));
  const auto document = test::read_json(desk.at("out/wear.json"));
  const auto& result = document["wear"]["results"][0];
  CHECK(result["turns"] == 1e5);
  CHECK(result["ended_by"] == "turns");
  CHECK(document.contains("provenance"));
  const auto rows = test::read_csv(desk.at("out/wear.csv"));
  REQUIRE(rows.size() > 2);
  CHECK(rows[0][5] == "bearing_depth");
  CHECK(std::stod(rows.back()[5]) == result["bearing"]["depth_m"]);
  CHECK(test::read_csv(desk.at("out/profiles.csv")).size() == 1 + 360 * (rows.size() - 1));
  CHECK_THAT(test::file_text(desk.at("out/wear.md")), Contains("worn by"));
  CHECK(std::filesystem::exists(desk.at("out/figures/wear_depth_pin.pdf")));
  CHECK(std::filesystem::exists(desk.at("out/figures/wear_profile_bearing_pin.pdf")));

  // The film of the worn surfaces: 8 s with 2 frames a second and the end.
  const auto film = test::succeeded(
      fmt::format("animate {} --svg --fps 2 -o {}", desk.at("out").string(), desk.at("film").string()));
  CHECK_THAT(film.out, Contains("17 frames") && Contains("100000 turns"));
  CHECK_THAT(test::file_text(desk.at("film/frame_000017.svg")),
             Contains("1e+05 turns") && Contains("pin: nonsmooth"));
  test::refused(fmt::format("animate {} --speed 2", desk.at("out").string()), Contains("a film of wear"));

  std::filesystem::remove_all(desk.at("out"));
  const auto refuses = [&](const std::string& message) {
    const auto refused = desk.run("wear");
    CHECK(refused.status == 2);
    CHECK_THAT(refused.err, Contains(message));
    CHECK_FALSE(std::filesystem::exists(desk.at("out")));
  };
  desk.put("study.toml", quick);
  refuses("has no table [wear]");
  desk.put("study.toml", quick + "[wear]\nclearance = \"0.4 mm\"\n");
  refuses("wear.clearance: must be greater than the clearance");
  // Without the motor, nothing has a period.
  const auto scene = test::file_text(desk.at("scene.toml"));
  desk.put("study.toml", quick + "[wear]\nturns = 10\n");
  desk.change("[drives.motor]\njoint = \"axle\"\nspeed_rpm = 60\n", "");
  desk.change("revolutions = 1\n", "duration = 1\n");
  refuses("revolutions: counts periods");
  desk.put("scene.toml", scene);
  desk.put("study.toml", quick + "[wear]\nturns = 10\n");
  desk.change("bearing_wear = 1e-15                        # m²/N\n", "");
  refuses("no joint wears: give a revolute joint with clearance bearing_wear or journal_wear");
}

TEST_CASE("a scene with the profile of a worn bearing has its motion and clearance", "[wear][profiles]") {
  const test::StudyDesk desk("wear-steady");
  const auto study =
      desk.read("formulations = [\"nonsmooth\"]\n" + quick + "[wear]\nturns = 1e5\npoints = 360\n");
  const auto out = desk.run("wear");
  CAPTURE(out.out, out.err);
  REQUIRE(out.status == 0);
  CHECK_FALSE(std::filesystem::exists(desk.at("out/profile_journal_pin_nonsmooth.csv")));  // it does not wear
  const auto worn =
      desk.put("worn.toml", test::replaced(test::file_text(desk.at("scene.toml")), "surface = \"steel\"\n",
                                           "surface = \"steel\"\nbearing_profile = \"bore\"\n") +
                                "[profiles.bore]\npoints = \"out/profile_bearing_pin_nonsmooth.csv\"\n");

  // The run that the study would make next.
  const auto all = wear_of(study, desk.at("again"));
  auto next = read_scene(desk.at("scene.toml"));
  CHECK(set_worn(next.mechanism, all.histories.at(0).cycles.back().joints.at(0).bearing) > 0);
  const auto expected = test::simulate(next, Family::nonsmooth);
  const auto run = test::simulate(read_scene(worn), Family::nonsmooth);
  CHECK(run.final_state.q == expected.final_state.q);
  CHECK(run.final_state.v == expected.final_state.v);
  // The block rests in the worn place, 11 um deep; time stepping keeps a gap of the step in which it came to rest.
  CHECK(run.final_state.q[4] < -0.5e-3 - 0.75 * 11e-6);
  test::succeeded(
      fmt::format("run {} --formulation nonsmooth -o {}", worn.string(), desk.at("run").string()));

  // Wear goes on from it. The clearance is half of a width, whose ends differ by at most the rounding; a turn
  // wears 6e-10 m.
  desk.put("on.toml", "formulations = [\"nonsmooth\"]\n" + test::replaced(quick, "scene.toml", "worn.toml") +
                          "[wear]\nturns = 1\npoints = 360\n");
  test::succeeded(fmt::format("wear {} -o {}", desk.at("on.toml").string(), desk.at("on").string()));
  const auto result = [&](const char* folder) {
    return test::read_json(desk.at(folder) / "wear.json")["wear"]["results"][0];
  };
  const double clearance = result("out")["clearance_m"], rounding = result("out")["rounding_m"];
  CHECK(clearance > 0.505e-3);
  CHECK(rounding < 0.3e-6);
  CHECK(result("on")["clearance_m"].get<double>() == Approx(clearance).epsilon(0).margin(rounding));
}
