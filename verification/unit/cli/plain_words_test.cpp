// Scenes that cannot run correctly: dead points, and runs that stop with their reason.
#include "dynamics/assembly/mobility.hpp"
#include "facade/assess.hpp"
#include "mechanism/plausibility.hpp"
#include "simulation/march.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// The text of the paper's scene with a rod of another length (m), and with an ideal joint at its end.
std::string flores(double rod, bool clearance_joint) {
  auto text = test::file_text(test::flores());
  for (const auto& [from, to] : {std::pair{"[-0.15, 0.0]]", fmt::format("[{}, 0.0]]", -rod / 2)},
                                 {"at = [[0.15, 0.0]", fmt::format("at = [[{}, 0.0]", rod / 2)}})
    text = test::replaced(text, from, to);
  if (clearance_joint) return text;
  const auto from = text.find("clearance = 0.25e-3");
  return text.erase(from, text.find("[joints.guide]") - from);
}

std::optional<DeadPoint> dead(const std::string& text) {
  const auto scene = parse_scene(text, "s.toml");
  return dead_point(scene.mechanism, scene.run.duration);
}

}  // namespace

TEST_CASE("a rotation that the ideal mechanism cannot complete ends at its dead point", "[whole-turn]") {
  // A position is located to 1e-3 of 5 degrees; gaps below 1e-6 of the longest lever arm count as
  // closed: together 1e-4 rad.
  const double accuracy = 1e-4;
  // A slider-crank in line with the crank: r sin θ = l at the last position. With clearance c: r
  // sin θ = l + c.
  const double r = 0.05, l = 0.04, play = 0.25e-3;
  const auto ideal = dead(flores(l, false)), clearance_joint = dead(flores(l, true));
  REQUIRE(ideal);
  REQUIRE(clearance_joint);
  CHECK(ideal->angle == Approx(std::asin(l / r)).margin(accuracy));
  CHECK(clearance_joint->angle == Approx(std::asin((l + play) / r)).margin(accuracy));
  CHECK_FALSE(dead(flores(0.3, true)));
  CHECK_FALSE(dead(flores(0.051, false)));  // just long enough
  // A run that ends before the dead point reports nothing.
  auto early = parse_scene(flores(l, false), "s.toml");
  CHECK_FALSE(dead_point(early.mechanism, 0.9 * std::asin(l / r) / (200 * 2 * std::numbers::pi / 60)));
}

TEST_CASE("all cases close over a revolution, and every sliding body is guided", "[whole-turn]") {
  int cases = 0;
  for (const auto& entry : std::filesystem::directory_iterator(test::source_folder() / "cases")) {
    const auto file = entry.path() / "scene.toml";
    if (!std::filesystem::exists(file)) continue;
    const auto scene = read_scene(file);
    CAPTURE(file.string());
    CHECK_FALSE(dead_point(scene.mechanism, scene.run.duration));
    for (const auto& q : plausibility_checks(scene.mechanism)) CHECK_THAT(q, !Contains("has no guide"));
    ++cases;
  }
  CHECK(cases > 15);
}

TEST_CASE("a run with an impact law fails if penetration exceeds the clearance", "[assess]") {
  const auto run = [](double ratio, Family family) {
    Result r;
    r.contacts.resize(1);
    r.contacts[0].name = "gudgeon";
    r.contacts[0].penetration_ratio = ratio;
    refuse_too_deep(r, family, "nonsmooth.step");
    return r.ending;
  };
  CHECK(run(0.99, Family::nonsmooth).status == Ending::Status::finished);
  CHECK(run(1.01, Family::penalty).status == Ending::Status::finished);  // it penetrates, and is reported as
                                                                         // doubtful
  const auto failed = run(385, Family::nonsmooth);
  CHECK(failed.status == Ending::Status::failed);
  CHECK_THAT(failed.reason, Contains("penetration at gudgeon reached 385 times the clearance") &&
                                Contains("use a smaller nonsmooth.step"));
}

TEST_CASE("a run without progress stops; bursts and long runs of ordinary steps do not", "[progress]") {
  const auto steps_to_stop = [](double h, double duration, long most) {
    Progress progress(0, duration);
    for (long i = 1; i <= most; ++i)
      if (progress.crawls(static_cast<double>(i) * h)) return i;
    return 0L;
  };
  constexpr long N = Progress::window;
  // A step of 1e-10 of the run is the limit; the run at a clearance of 1e-12 m takes steps of 2e-11
  // s in 0.3 s.
  CHECK(steps_to_stop(2e-11, 0.3, 4 * N) == 3 * N);
  CHECK(steps_to_stop(0.9e-10, 1, 4 * N) == 3 * N);
  CHECK(steps_to_stop(1.1e-10, 1, 4 * N) == 0);
  CHECK(steps_to_stop(1e-5, 3e8, 4 * N) == 0);  // 1e9 revolutions at 200 rpm
  CHECK(steps_to_stop(0.9e-8, 3e8, 4 * N) == 3 * N);
  // Two windows of tiny steps between others.
  Progress burst(0, 1);
  double t = 0;
  bool stopped = false;
  for (int window = 0; window < 8; ++window)
    for (long i = 0; i < N; ++i) stopped |= burst.crawls(t += window % 4 < 2 ? 1e-12 : 1e-7);
  CHECK_FALSE(stopped);
  // The stepping loop applies the check, and reports the place: a ball in flight above a floor,
  // with steps of 1e-12 of the run.
  const auto scene = parse_scene(test::body("ball", 1, 1, "position = [0, 1]\n") +
                                     test::plane("floor", "ground", "ball", 0.1) +
                                     test::surface("s", 0.5, "young = 2e11\npoisson = 0.3\n") +
                                     test::run_for(1) + "[penalty]\nintegrator = \"rk4\"\nstep = 1e-12\n",
                                 "s.toml");
  const auto run = test::simulate(scene, Family::penalty);
  CHECK(run.work.steps == 3 * N);
  CHECK(run.ending.status == Ending::Status::failed);
  CHECK_THAT(
      run.ending.reason,
      Contains(
          "the steps have shrunk to 1e-12 s, and the run needs 1e+12 more of them, at floor; increase this "
          "clearance, omit this contact, or use a coarser step or tolerance, or a shorter run"));
}
