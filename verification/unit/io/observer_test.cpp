// Observers: the data that they receive. That observation changes no digit of a run is a claim of "forces".
#include "facade/run_folder.hpp"
#include "simulation/trajectory.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

TEST_CASE("a truncated list of events is marked as such", "[observers]") {
  auto scene = test::read_short(test::flores(), 0.1);
  const auto whole = Simulation(scene, "nonsmooth").run();
  REQUIRE(whole.events.size() > 6);
  CHECK_FALSE(whole.events_cut());
  const auto cut = Simulation(scene, "nonsmooth").run({.most_events = 5});
  CHECK(cut.events.size() == 5);
  CHECK(cut.events_seen == whole.events_seen);
  CHECK(cut.events_cut());
  CHECK(cut.events.back().t == whole.events[4].t);
  CHECK(cut.events.back().joint == "gudgeon");
  CHECK(Simulation(scene, "nonsmooth").run({.keep_events = false}).events.empty());
}

TEST_CASE("observers see a run in parts as one run", "[observers]") {
  // Two successive runs differ from one: the step is cut between them. Rows and events continue
  // nevertheless.
  auto scene = test::read_short(test::flores(), 0.04);
  scene.run.output_step = 2e-5;
  Simulation simulation(scene, "nonsmooth");
  Trajectory path;
  Energies energies;
  simulation.run({.until = 0.02, .observers = {&path}});
  const auto half = path.size();
  const auto rest = simulation.run({.observers = {&path, &energies}});
  CHECK(energies.rows.back().ledger.kinetic == rest.ledger.kinetic);
  CHECK(half == 1001);
  CHECK(path.size() == 2001);
  for (std::size_t i = 1; i < path.size(); ++i) REQUIRE(path.t(i) > path.t(i - 1));
  CHECK(simulation.t() == 0.04);
}

TEST_CASE("a run obeys a request to stop", "[observers]") {
  const auto scene = read_scene(test::flores());
  std::atomic<bool> stop{false};
  test::Listener listener;
  listener.on_step = [&](const Step& step) { stop = step.t1 > 0.01; };
  Simulation simulation(scene, "nonsmooth");
  const auto run = simulation.run({.observers = {&listener}, .stop = StopToken(stop)});
  CHECK(run.ending.status == Ending::Status::interrupted);
  CHECK(run.t_end == Approx(0.01).margin(2e-5));
  // Another run, without a token, is not affected.
  auto other = scene;
  other.run.duration = 0.02;
  other.run.discard = 0;
  CHECK(Simulation(other, "nonsmooth").run().ending.status == Ending::Status::finished);
}

TEST_CASE("invalid arguments of a run are refused", "[observers]") {
  auto scene = test::read_short(test::flores(), 0.01);
  Simulation simulation(scene, "nonsmooth");
  CHECK_THROWS_AS(simulation.run({.until = std::nan("")}), ModelError);
  CHECK_THROWS_AS(simulation.run({.until = -1.0}), ModelError);
  const auto snapshot = simulation.snapshot();
  test::Listener listener;
  listener.on_step = [&](const Step&) { simulation.restore(snapshot); };
  CHECK_THROWS_AS(simulation.run({.observers = {&listener}}), std::logic_error);
  listener.on_step = [&](const Step&) { simulation.run(); };
  CHECK_THROWS_AS(simulation.run({.observers = {&listener}}), std::logic_error);
}

TEST_CASE("a load and a drive of one name are refused if forces.csv is requested", "[observers]") {
  test::TemporaryFolder folder;
  auto scene = parse_scene(test::body("wheel", 1, 1) + test::pin("axle", "ground", "wheel") +
                               test::drive("spin", "axle", "torque = 1\n") +
                               "[loads.spin]\ntype = \"torque\"\nbody = \"wheel\"\ntorque = 2\n" +
                               test::run_for(0.01, "forces = true\n"),
                           "wheel");
  CHECK_THROWS_WITH(run_scene(scene, {.formulation = "penalty", .folder = folder.path() / "a"}),
                    Catch::Matchers::Contains("loads.spin") && Catch::Matchers::Contains("rename"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "a"));
  // Without forces.csv the equal names are harmless.
  scene.set("run.forces", "false");
  CHECK(run_scene(scene, {.formulation = "penalty", .folder = folder.path() / "a"}).ending.status ==
        Ending::Status::finished);
}

TEST_CASE("only one process writes into a folder", "[observers]") {
  test::TemporaryFolder folder;
  auto scene = test::read_short(test::flores(), 0.01);
  // During the first run's progress a second one requests the same folder.
  int tries = 0;
  const RunPlan second{.formulation = "nonsmooth", .folder = folder.path()};
  run_scene(scene, {.formulation = "nonsmooth", .folder = folder.path(), .on_progress = [&](double) {
                      if (tries++ == 0)
                        CHECK_THROWS_WITH(run_scene(scene, second),
                                          Catch::Matchers::Contains("another freeplay"));
                    }});
  CHECK(tries > 0);
  CHECK(run_scene(scene, second).ending.status == Ending::Status::finished);
}

TEST_CASE("access to forces that were not requested is an error", "[observers]") {
  Simulation simulation(read_scene(test::flores()), "penalty");
  test::Listener listener;
  Forces f;
  listener.on_step = [&](const Step& step) {
    CHECK_THROWS_AS(step.forces(step.t1, f), std::logic_error);
    CHECK_THROWS_AS(step.add_impulse(step.t0, step.t1, f), std::logic_error);
    CHECK_THROWS_AS(step.before(), std::logic_error);
    CHECK_THROWS_AS(step.within(), std::logic_error);
  };
  simulation.run({.until = 1e-3, .observers = {&listener}});
  listener.want = {.forces = true};
  listener.on_step = [&](const Step& step) {
    Forces unshaped, sum;
    step.forces(step.t1, unshaped);
    CHECK(unshaped.elements.size() == simulation.layout().forces.size());
    sum.add(1, step.before());
    CHECK(sum.acceleration.size() == unshaped.acceleration.size());
  };
  simulation.run({.until = 2e-3, .observers = {&listener}});
}
