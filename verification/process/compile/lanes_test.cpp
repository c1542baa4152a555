// Runs in lanes (formulations/time_stepping/lanes.hpp) against each run alone in the general evaluation. The
// expected digits are those of the general evaluation, which other tests compare with closed forms.
#include "compile/compiled_object.hpp"
#include "formulations/time_stepping/lane_functions.hpp"
#include "io/scene/read_scene.hpp"
#include "numerics/trace.hpp"
#include "simulation/observer.hpp"
#include "simulation/statistics.hpp"
#include "study/ensemble/ensemble.hpp"
#include "verification/support/compiled_runs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// Random mechanisms: four-bars and slider-cranks with one to three loose pins, and chains of one to
/// four bars that hang on loose pins.
class LaneScenes {
 public:
  /// `guided`: slider-cranks with friction in the guide.
  LaneScenes(unsigned seed, int index, bool guided = false)
      : random_(seed + 7919 * static_cast<unsigned>(index)), kind_(guided ? 1 : index % 3), guided_(guided) {
    bars_ = 1 + index / 3 % 4;
    loose_ = random_() % 2 == 0;
    rubs_ = random_() % 4 != 0;
    heavy_ = kind_ == 2 || random_() % 2 == 0;
    angle_ = between(0, 360);
    step_ = index % 2 == 0 ? 1e-5 : 5e-5;
  }
  /// A scene of the mechanism with parameters of its own.
  Scene scene() {
    keys_ = {fmt::format("gravity=[0, {}]", heavy_ ? -9.81 : 0)};
    set("nonsmooth.step", step_);
    set("surfaces.steel.restitution", between(0, 0.9));
    set("surfaces.steel.friction", rubs_ ? between(0.01, 0.4) : 0);
    if (kind_ == 2) return parse_scene(chain(), "chain", keys_);
    set("drives.motor.speed_rpm", between(100, 600));
    set("drives.motor.initial_angle", angle_ * std::numbers::pi / 180);
    play("C");
    if (kind_ == 0) {
      for (const auto& [bar, length] : {std::pair{"crank", 0.1}, {"coupler", 0.35}, {"rocker", 0.3}})
        weigh(bar, length);
      play("B");
      if (loose_) play("D");
      return read_scene(test::scene_file("tests/loose_four_bar"), keys_);
    }
    for (const auto& [bar, length] : {std::pair{"crank", 0.05}, {"rod", 0.3}}) weigh(bar, length);
    set("bodies.slider.mass", between(0.3, 2));
    if (loose_) play("B");
    if (heavy_)  // a rope that slackens twice in each turn
      keys_.emplace_back(
          "loads.rope={type=\"spring-damper\", between=[\"ground\", \"slider\"], stiffness=200, "
          "free_length=0.3, one_way=\"pull\"}");
    if (guided_)
      keys_.push_back(fmt::format(
          "loads.guide={{type=\"joint-friction\", joint=\"guide\", force={}, regularisation=1e-3}}",
          between(0.5, 20)));
    return read_scene(test::scene_file("tests/loose_slider_crank"), keys_);
  }
  double step() const { return step_; }

 private:
  double between(double a, double b) { return a + (b - a) * static_cast<double>(random_()) / 4294967296.0; }
  void set(const std::string& key, double value) { keys_.push_back(fmt::format("{}={}", key, value)); }
  void weigh(const std::string& bar, double length) {
    const double mass = between(0.1, 2);
    set("bodies." + bar + ".mass", mass);
    set("bodies." + bar + ".inertia", mass * length * length / 12);
  }
  void play(const std::string& pin) {
    set("joints." + pin + ".clearance", between(1e-4, 8e-4));
    set("joints." + pin + ".bearing_radius", 0.01);
    keys_.push_back("joints." + pin + ".surface=steel");
  }
  std::string chain() {
    std::string text = "format = 2\n[surfaces.steel]\n[run]\nduration = 0.05\nstart = \"ideal\"\n",
                before = "ground";
    for (int i = 0; i < bars_; ++i) {
      const auto name = fmt::format("bar{}", i);
      text += test::body(name, 1, 1,
                         fmt::format("angle = \"{} deg\"\nangular_velocity = {}\n", i % 2 == 0 ? -50 : -130,
                                     between(-2, 2))) +
              test::pin(fmt::format("pin{}", i), before, name, {i == 0 ? 0 : 0.1, 0}, {-0.1, 0});
      weigh(name, 0.2);
      play(fmt::format("pin{}", i));
      before = name;
    }
    return text + "[nonsmooth]\nscheme = \"moreau-jean\"\n";
  }

  std::mt19937 random_;
  int kind_, bars_;
  bool guided_, loose_, rubs_, heavy_;
  double angle_, step_;
  std::vector<std::string> keys_;
};

/// Totals over scenes.
struct LaneCounts {
  long steps = 0, in_lanes = 0, events = 0;
  int laned = 0;
};

/// Runs scenes together, scene i until `until(i)`, and compares each with its run alone.
void compare_with_runs_alone(const std::vector<Scene>& scenes,
                             const std::function<double(std::size_t)>& until, LaneCounts& counts) {
  std::vector<Simulation> together;
  for (const auto& scene : scenes)
    together.emplace_back(scene, "nonsmooth", SimulationOptions{.compile = Compile::always});
  std::vector<Result> found(scenes.size());
  std::size_t next = 0;
  long in_lanes = 0;
  Simulation::run_together([&]() -> std::optional<Simulation::LaneJob> {
    if (next == scenes.size()) return {};
    const auto i = next++;
    Simulation::LaneJob one{&together[i], {.until = until(i)}, [] { return INFINITY; }};
    one.ended = [&, i](Result result, long steps) {
      in_lanes += steps;
      found[i] = std::move(result);
    };
    return one;
  });
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    INFO("run " << i);
    Simulation alone(scenes[i], "nonsmooth", {.compile = Compile::never});
    test::check_same_run(found[i], alone.run({.until = until(i)}));
    counts.steps += found[i].work.steps;
    counts.events += static_cast<long>(found[i].events.size());
  }
  counts.laned += in_lanes > 0;
  counts.in_lanes += in_lanes;
}

/// Runs of one structure: one more than there are lanes, so that one starts in a lane that another has
/// left.
void compare_lanes(unsigned seed, int index, double steps, int lanes, LaneCounts& counts,
                   bool guided = false) {
  INFO("mechanism " << index);
  LaneScenes kind(seed, index, guided);
  std::vector<Scene> scenes;
  for (int i = 0; i <= lanes; ++i) scenes.push_back(kind.scene());
  const auto until = [&](std::size_t i) { return kind.step() * (steps - 7.3 * static_cast<double>(i)); };
  compare_with_runs_alone(scenes, until, counts);
}

}  // namespace

TEST_CASE("runs in lanes have the digits of runs alone", "[lanes][compiled]") {
  const test::CompilerCache cache;
  LaneCounts counts;
  for (const int index : {0, 1, 3, 11}) compare_lanes(5, index, 2000, lanes_of_machine(), counts);
  CHECK(counts.laned == 4);
  CHECK(counts.events > 20);
  // Between impacts, and in contact with one pin, all steps are made in lanes.
  CHECK(counts.in_lanes > counts.steps / 4);
}

TEST_CASE("slider-cranks with friction in the guide: lanes and runs alone", "[lanes][compiled]") {
  const test::CompilerCache cache;
  LaneCounts counts;
  for (const int index : {0, 1, 2, 3, 4, 5}) compare_lanes(7, index, 4000, 3, counts, true);
  CHECK(counts.laned >= 4);
  CHECK(counts.events > 20);
  CHECK(counts.in_lanes > counts.steps / 4);
}

TEST_CASE("fifty random scenes with one to four contacts: lanes and runs alone", "[lanes][compiled][slow]") {
  const test::CompilerCache cache;
  LaneCounts counts;
  for (int index = 0; index < 50; ++index) compare_lanes(17, index, 20000, lanes_of_machine(), counts);
  CHECK(counts.laned >= 45);
}

TEST_CASE("runs of different structures together are runs alone", "[lanes][compiled]") {
  const test::CompilerCache cache;
  LaneScenes first(5, 0), second(5, 1);
  LaneCounts counts;
  compare_with_runs_alone(
      {first.scene(), second.scene(), first.scene()}, [](std::size_t) { return 0.01; }, counts);
  CHECK(counts.in_lanes > 0);
}

TEST_CASE("an ensemble has the same statistics and bands with and without lanes",
          "[lanes][ensemble][compiled]") {
  const test::CompilerCache cache;
  const auto scene = open_scene(test::flores(), {"run.revolutions=0.2", "run.discard=0.05"});
  const EnsemblePlan plan{.starts = 11, .rows = 11, .threads = 2};
  const auto with = [&](const char* choice) {
    const test::Environment compile("FREEPLAY_COMPILE", choice);
    return run_ensemble(*scene, plan, {});
  };
  const auto lanes = with("always"), alone = with("never");
  CHECK(alone.in_lanes == 0);
  CHECK(static_cast<double>(lanes.in_lanes) > 0.8 * static_cast<double>(lanes.steps));
  CHECK(lanes.steps == alone.steps);
  CHECK(lanes.statistics == alone.statistics);
  const auto equal = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
  REQUIRE(lanes.finished() == 11);
  for (std::size_t k = 0; k < lanes.runs.size(); ++k)
    for (std::size_t i = 0; i < lanes.statistics.size(); ++i)
      CHECK(equal(lanes.runs[k][i], alone.runs[k][i]));
  REQUIRE(lanes.bands.size() == alone.bands.size());
  for (std::size_t i = 0; i < lanes.bands.size(); ++i) {
    CHECK(lanes.bands[i].of.mean == alone.bands[i].of.mean);
    CHECK(lanes.bands[i].quantile == alone.bands[i].quantile);
  }
}

TEST_CASE("functions in lanes: each lane has its constants, choices and guards", "[lanes][compiled]") {
  const test::CompilerCache cache;
  constexpr int lanes = 4;
  const auto object_of = [&](double factor) {
    TracedObject object(lanes);
    {
      Trace trace(object, "f");
      const auto x = trace.inputs(0, std::vector{0.3, 2.0});
      const auto y = Traced(factor) * sin(x[0]) * cos(x[0]) + sqrt(x[1]) / atan2(x[0], x[1]);
      (void)(x[0] < x[1]);
      trace.require(either(holds(x[1], Relation::less, 7), holds(x[1], Relation::equal, 9)));
      const auto small = both(holds(x[0], Relation::less_equal, 0.5), holds(0, Relation::less, x[0]));
      trace.output(0, 0, select(small, max(y, x[1]), -abs(y)));
    }
    return object;
  };
  const std::vector<double> factors{1.5, 2.5, 3.5, 4.5};
  alignas(64) double constants[64], x[2 * lanes] = {0.3, 0.7, 0.5, 3.0, 2.0, 9.0, 8.0, 2.5}, out[lanes];
  const auto first = object_of(factors[0]);
  for (int lane = 0; lane < lanes; ++lane) {
    const auto object = object_of(factors[static_cast<std::size_t>(lane)]);
    CHECK(object.same_structure(first));
    CHECK(object.text() == first.text());
    for (std::size_t i = 0; i < object.constants().size(); ++i)
      constants[i * lanes + static_cast<std::size_t>(lane)] = object.constants()[i];
  }
  CHECK_FALSE(first.same_structure(TracedObject(lanes)));
  const auto compiled = compiled_object(first.text(), 1);
  REQUIRE(compiled.reason.empty());
  const double* in[] = {x};
  double* outs[] = {out};
  // Lane 2 fails by 8, which is neither below 7 nor 9; lane 3 because 3 is not below 2.5.
  CHECK(compiled.table[0](constants, in, outs) == 0b1100);
  const auto y = [&](int lane) {
    const double a = x[lane], b = x[lanes + lane];
    return factors[static_cast<std::size_t>(lane)] * std::sin(a) * std::cos(a) +
           std::sqrt(b) / std::atan2(a, b);
  };
  CHECK(out[0] == std::max(y(0), 2.0));
  CHECK(out[1] == -std::abs(y(1)));
}

// Runs in a lane of their own (formulations/time_stepping/lanes.hpp): the digits of the general path, for
// observers that need all steps, some of them, or none.

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
