// Runs in a lane of their own (formulations/time_stepping/lanes.hpp): the digits of the general path, for
// observers that need all steps, some of them, or none.
#include "simulation/observer.hpp"
#include "simulation/statistics.hpp"
#include "verification/support/compiled_runs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

struct SingleLaneCache : test::CompilerCache {
  test::Environment as_usual{"FREEPLAY_COMPILE", nullptr};
};

/// Rows at multiples of a time; each step is shown.
struct AllSteps : Observer {
  explicit AllSteps(double apart) : apart(apart), due(apart) {}
  void step(const Step& step) override {
    ++seen;
    for (; due <= step.t1; due += apart) {
      std::vector<double> q(step.v1.size()), v(q);
      step.state(due, q, v);
      rows.insert(rows.end(), q.begin(), q.end());
      rows.insert(rows.end(), v.begin(), v.end());
      const auto l = step.ledger();
      rows.insert(rows.end(), {l.drive, l.contact, l.friction, l.stabilisation, l.passed, l.closure()});
      rows.insert(rows.end(), step.multipliers().begin(), step.multipliers().end());
    }
  }
  double apart, due;
  long seen = 0;
  std::vector<double> rows;
};

/// The same from few steps.
struct FewSteps : AllSteps, Occasional {
  using AllSteps::AllSteps;
  double next() const override { return due; }
};

Scene lane_scene(const std::string& name, double duration) {
  auto scene = test::read_short(test::source_folder() / "cases" / name / "scene.toml", duration);
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  scene.nonsmooth.step = 2e-5;
  return scene;
}

}  // namespace

TEST_CASE("a run in its own lane shows few steps, and has the digits of the general path",
          "[lanes][compiled]") {
  const SingleLaneCache cache;
  for (const char* name : {"flores2011", "four-bar", "block-on-slope"}) {
    INFO(name);
    const auto scene = lane_scene(name, 0.2);
    FewSteps few(1.7e-3), general(1.7e-3);
    AllSteps all(1.7e-3);
    const auto run = [&](Compile compile, Observer& observer) {
      WindowStatistics window(0, scene.run.duration);
      ContactStatistics contacts(0);
      auto result = Simulation(scene, "nonsmooth", {.compile = compile})
                        .run({.observers = {&contacts, &window, &observer}});
      contacts.into(result);
      window.into(result);
      return result;
    };
    const auto expected = run(Compile::never, general), found = run(Compile::always, few),
               shown = run(Compile::always, all);
    CHECK(found.compiled.used);
    test::check_same_run(found, expected);
    test::check_same_run(shown, expected);
    CHECK(found.window->energy == expected.window->energy);
    CHECK(few.rows == general.rows);
    CHECK(all.rows == general.rows);
    CHECK(general.seen == expected.work.steps);
    CHECK(all.seen == expected.work.steps);
    // About three steps at each of 117 rows are the stepper's own, and those around its events.
    if (name != std::string("block-on-slope"))  // two contacts act there
      CHECK(few.seen < expected.work.steps / 2);
  }
}

TEST_CASE("a long run enters its lane when it is compiled, and continues in parts", "[lanes][compiled]") {
  const SingleLaneCache cache;
  const auto scene = lane_scene("flores2011", 1.2);  // 60,000 steps, of which 20,000 before
  FewSteps few(0.05), general(0.05);
  // Leaves the object in the cache: whether a compilation pays in the rest of the run depends on the machine.
  Simulation(scene, "nonsmooth", {.compile = Compile::always}).run({.until = 0.01, .keep_events = false});
  const auto found = Simulation(scene, "nonsmooth").run({.observers = {&few}});
  const auto expected =
      Simulation(scene, "nonsmooth", {.compile = Compile::never}).run({.observers = {&general}});
  CHECK(found.compiled.used);
  CHECK(found.compiled.from > 0.39);
  test::check_same_run(found, expected);
  CHECK(few.rows == general.rows);
  CHECK(few.seen < 40'000);

  Simulation parts(scene, "nonsmooth", {.compile = Compile::always}),
      other(scene, "nonsmooth", {.compile = Compile::always});
  for (int i = 1; i <= 7; ++i) {
    parts.run({.until = 0.011 * i, .keep_events = false});
    other.restore(parts.snapshot());  // of a run that has left its lane
    other.run({.until = 0.011 * i + 0.003, .keep_events = false});
    Simulation alone(scene, "nonsmooth", {.compile = Compile::never});
    for (int k = 1; k <= i; ++k) alone.run({.until = 0.011 * k, .keep_events = false});
    CHECK(parts.state().q == alone.state().q);
    CHECK(parts.state().v == alone.state().v);
    alone.run({.until = 0.011 * i + 0.003, .keep_events = false});
    CHECK(other.state().q == alone.state().q);
  }
}
