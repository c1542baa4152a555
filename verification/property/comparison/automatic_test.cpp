// The default scheme: event-driven integration with a hand-over to time stepping and back where
// impacts accumulate. It has no cost where no hand-over is needed, finishes runs that event-driven
// integration cannot finish, and returns where time stepping costs more.
#include "io/scene/write_scene.hpp"
#include "study/runs/case_run.hpp"
#include "values/warning.hpp"
#include "verification/property/comparison/snapshot_check.hpp"
#include "verification/support/handovers.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using snapshots::bits;
using verification::loop, verification::wedge;

namespace {

Scene with(Scene scene, std::optional<Scheme> scheme) {
  scene.nonsmooth.scheme = scheme;
  scene.nonsmooth.step.reset();
  scene.instruments.clear();
  return scene;
}

}  // namespace

TEST_CASE("automatic scheme: without a hand-over a run is bit-identical to event-driven integration",
          "[automatic]") {
  for (const auto* name : {"gudgeon", "big_end", "four_bar", "ring", "bouncing_ball", "block_on_slope"}) {
    CAPTURE(name);
    auto scene = read_scene(test::scene_file(name));
    scene.run.discard = 0;
    auto automatic = test::finished(with(scene, Scheme::automatic), Family::nonsmooth),
         events = test::simulate(with(scene, Scheme::event_driven), Family::nonsmooth);
    CHECK(automatic.work.handovers == 0);
    CHECK(automatic.work.stepped == 0);
    CHECK(automatic.work.rhs == events.work.rhs);
    CHECK((bits(automatic.events) == bits(events.events)));
    CHECK(automatic.notes == events.notes);
  }
}

TEST_CASE(
    "automatic scheme: a run that event-driven integration cannot finish reports the hand-over and its "
    "reason",
    "[automatic]") {
  // That hand-overs lose nothing is a claim of "setting-choice".
  const auto scene = parse_scene(loop, "loop");
  CHECK(test::simulate(with(scene, Scheme::event_driven), Family::nonsmooth).ending.status ==
        Ending::Status::failed);
  const auto run = test::finished(with(scene, Scheme::automatic), Family::nonsmooth);
  CAPTURE(run.notes);
  for (const auto& c : run.contacts) CHECK(c.penetration_ratio < 1e-6);
  const auto outcome =
      std::ranges::find_if(run.notes, [](const auto& n) { return n.starts_with("time stepping"); });
  REQUIRE(outcome != run.notes.end());
  CHECK_THAT(*outcome, Contains(fmt::format("took over {} times, for {:.3g} s in total", run.work.handovers,
                                            run.work.stepped)));
  CHECK(outcome->size() > outcome->find("at most): ") + 20);  // and why
}

TEST_CASE(
    "automatic scheme: returns where time stepping costs more, and continues from a snapshot bit for bit",
    "[automatic]") {
  // Impacts do not cease, so a return condition based on calm would never be met: time stepping
  // took 1.55e6 factorisations for 0.096 of 0.1 s.
  const auto scene = read_scene(test::scene_file("six_bar_tight"));
  Simulation whole(scene, "nonsmooth");
  std::optional<Snapshot> middle;
  test::Listener look;
  look.on_step = [&](const Step& step) {
    if (!middle && step.t1 >= 0.05) middle = whole.snapshot();
  };
  const auto run = test::finished(whole, {&look});
  CAPTURE(run.notes, run.work.handovers, run.work.stepped, run.work.factorisations);
  // Trials cost a tenth of the work; a gain of a fifth exceeds their scatter from scene to scene.
  CHECK(run.work.factorisations < 1'240'000);
  CHECK(run.work.stepped < 0.5 * scene.run.duration);
  CHECK(run.work.handovers > 0);
  for (const auto& c : run.contacts) CHECK(c.penetration_ratio < 1e-6);
  CHECK(std::abs(run.ledger.closure()) < 1e-6 * run.ledger.scale());
  CHECK_THAT(test::notes_of(run), Contains("became more expensive"));

  // The cost comparison continues from a snapshot.
  REQUIRE(middle);
  Simulation rest(scene, "nonsmooth");
  rest.restore(*middle);
  const auto again = test::finished(rest);
  CHECK(again.final_state.q == run.final_state.q);
  CHECK(again.final_state.v == run.final_state.v);
  CHECK(again.work.factorisations == run.work.factorisations);
  CHECK(again.work.handovers == run.work.handovers);
  CHECK(again.notes == run.notes);
}

TEST_CASE("automatic scheme: impact laws without time stepping stay with event-driven integration",
          "[automatic]") {
  auto scene = test::read_short(test::scene_file("gudgeon"), 0.05);
  for (const auto law : {ImpactLaw::energetic, ImpactLaw::poisson}) {
    scene.nonsmooth.impact_law = law;
    auto automatic = test::simulate(with(scene, std::nullopt), Family::nonsmooth),
         events = test::simulate(with(scene, Scheme::event_driven), Family::nonsmooth);
    CHECK(automatic.events.size() > 5);
    CHECK((bits(automatic.events) == bits(events.events)));
  }
  // If it stops for another reason, there is no hand-over.
  auto stuck = with(parse_scene(wedge, "wedge"), Scheme::automatic);
  stuck.nonsmooth.impact_law = ImpactLaw::energetic;
  const auto run = test::simulate(stuck, Family::nonsmooth);
  CHECK(run.work.handovers == 0);
}

TEST_CASE("automatic scheme: the scheme that each combination of keys selects", "[automatic][scene]") {
  const auto options = [](const std::string& more) {
    return parse_scene(wedge + "[nonsmooth]\n" + more, "keys").nonsmooth;
  };
  const std::string stepping = "scheme = \"moreau-jean\"\n", events = "scheme = \"event-driven\"\n";
  struct Keys {
    std::string text;
    Scheme scheme;
    std::optional<double> step = {};
  };
  const std::vector<Keys> all{{"", Scheme::automatic},
                              {"step = \"automatic\"\n", Scheme::automatic},
                              {"scheme = \"automatic\"\n", Scheme::automatic},
                              {"impact_law = \"poisson\"\n", Scheme::automatic},
                              {"step_tolerance = 1e-5\n", Scheme::automatic},
                              {"step = 1e-4\n", Scheme::moreau_jean, 1e-4},
                              {events, Scheme::event_driven},
                              {stepping, Scheme::moreau_jean},
                              {stepping + "step = \"automatic\"\n", Scheme::moreau_jean},
                              {stepping + "step = 1e-4\n", Scheme::moreau_jean, 1e-4}};
  for (const auto& keys : all) {
    CAPTURE(keys.text);
    const auto found = options(keys.text);
    CHECK(found.scheme_in_force() == keys.scheme);
    if (keys.scheme == Scheme::moreau_jean) CHECK(found.step == keys.step);
    // Canonical texts are read back with the same identity.
    const auto one = parse_scene(wedge + "[nonsmooth]\n" + keys.text, "one"),
               again = parse_scene(to_toml(one), "again");
    CHECK(to_toml(again) == to_toml(one));
    CHECK(again.nonsmooth.scheme_in_force() == keys.scheme);
    CHECK(again.nonsmooth.step == one.nonsmooth.step);
    CHECK(Simulation(again, "nonsmooth").identity().digest() ==
          Simulation(one, "nonsmooth").identity().digest());
  }
  CHECK(options(stepping + "step_tolerance = 1e-5").step_tolerance == 1e-5);
  CHECK_THROWS_WITH(options("step = \"chosen\""), Contains("step") && Contains("automatic"));
  CHECK_THROWS_WITH(options("scheme = \"best\""), Contains("automatic") && Contains("moreau-jean"));
  for (const auto& wrong :
       {std::string("step = \"chosen\""), std::string("step = 0.0"), std::string("step_tolerance = 0.0"),
        std::string("step = 1e-4\nimpact_law = \"poisson\""), stepping + "impact_law = \"poisson\""})
    CHECK_THROWS_AS(options(wrong), SceneError);

  // A step without a scheme means fixed steps, digit for digit.
  auto fixed = test::simulate(parse_scene(wedge + "[nonsmooth]\nstep = 1e-3", "a"), Family::nonsmooth),
       named = test::simulate(parse_scene(wedge + "[nonsmooth]\n" + stepping + "step = 1e-3", "b"),
                              Family::nonsmooth);
  CHECK(fixed.work.steps == 1500);
  CHECK((bits(fixed.events) == bits(named.events)));
  CHECK(fixed.final_state.q == named.final_state.q);

  // The identity of a run differs where the schemes do, not where the same one is stated.
  const auto digest = [](const std::string& more) {
    return Simulation(parse_scene(wedge + "[nonsmooth]\n" + more, "one"), "nonsmooth").identity().digest();
  };
  CHECK(digest("") == digest("step = \"automatic\""));
  std::set<std::string> digests;
  for (const auto& more :
       {std::string(), std::string("step = 1e-4"), stepping, events, std::string("step_tolerance = 1e-5")})
    digests.insert(digest(more));
  CHECK(digests.size() == 5);
}

// Both centres of the second pair of gears move, so a trial step may bring them within the base
// circles, where the gap of the flanks has no bound. Such a step is repeated with a shorter length.
TEST_CASE("flanks of gears with backlash on a moving arm do not penetrate each other",
          "[gears][event-driven][automatic]") {
  auto scene = read_scene(test::scene_file("backlash_arm"));
  scene.run.duration = 1.0;
  for (const auto scheme : {std::optional<Scheme>{}, std::optional(Scheme::event_driven)}) {
    scene.nonsmooth.scheme = scheme;
    const auto run = test::simulate(scene, Family::nonsmooth);
    CAPTURE(scheme.has_value(), run.ending.reason);
    CHECK(run.ending.status == Ending::Status::finished);
    CHECK(run.contacts.size() == 4);
    // Events are located to the rounding of the gap, about 1e-16 m of 5e-5 m, over some hundred
    // events.
    for (const auto& c : run.contacts) CHECK(c.penetration_ratio < 1e-6);
    // A step that leaves open whether flanks met is made again: no doubt is left of a run that is
    // right.
    for (const auto& note : run.notes) CHECK_FALSE(is_warning(note));
    CHECK(run.work.events > 20);
  }
}

// The test rig with clearance in all joints, two of a few micrometres, where a bounce lasts a
// hundredth of a step.
TEST_CASE("three joints with clearance, two of a few micrometres, finish without a doubtful result",
          "[automatic]") {
  Study study;
  study.scene = test::source_folder() / "cases/flores2011-experiment/scene.toml";
  study.joints = {"gudgeon"};
  study.accelerometer = "accelerometer";
  study.starts.seed = 2011;
  study.length.discard = 0;
  for (int start = 0; start < 3; ++start) {
    const Case one{
        "",
        "nonsmooth",
        {},
        start,
        2,
        study.scene,
        {"nonsmooth.scheme=automatic", "joints.gudgeon.clearance=1e-3", "drives.motor.speed_rpm=250",
         "joints.main.clearance=9e-6", "joints.main.bearing_radius=8.5e-3", "joints.main.surface=steel",
         "joints.big_end.clearance=5e-6", "joints.big_end.bearing_radius=5e-3",
         "joints.big_end.surface=steel"}};
    const auto r = run_case(study, one, Conduct{});
    CAPTURE(start, r.ending.reason);
    CHECK(r.ending.status == Ending::Status::finished);
    for (const auto& note : r.notes) {
      CAPTURE(note);
      CHECK_FALSE(is_warning(note));  // a bounce that is missed ends deep in the wall
    }
  }
}
