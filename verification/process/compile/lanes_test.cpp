// Runs in lanes (formulations/time_stepping/lanes.hpp) against each run alone in the general evaluation. The
// expected digits are those of the general evaluation, which other tests compare with closed forms.
#include "compile/compiled_object.hpp"
#include "formulations/time_stepping/lane_functions.hpp"
#include "io/scene/read_scene.hpp"
#include "numerics/trace.hpp"
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
    loose_ = kind_ == 2 ? 15 : 1 + static_cast<int>(random_() % 7);
    bars_ = 1 + index / 3 % 4;
    rubs_ = random_() % 4 != 0;
    heavy_ = kind_ == 2 || random_() % 2 == 0;
    for (double& x : sizes_) x = between(0.95, 1.05);
    angle_ = between(0, 360);
    step_ = index % 2 == 0 ? 1e-5 : 5e-5;
  }
  /// A scene of the mechanism with parameters of its own.
  Scene scene() {
    std::string text = fmt::format("format = 2\ngravity = [0, {}]\n", heavy_ ? -9.81 : 0.0);
    if (kind_ == 2)
      text += chain();
    else
      text += kind_ == 0 ? four_bar() : slider_crank();
    text += fmt::format("[surfaces.steel]\nrestitution = {}\n", between(0, 0.9));
    if (rubs_) text += fmt::format("friction = {}\n", between(0.01, 0.4));
    text += fmt::format("[nonsmooth]\nscheme = \"moreau-jean\"\nstep = {}\n", step_);
    return parse_scene(text, "");
  }
  double step() const { return step_; }

 private:
  double between(double a, double b) { return a + (b - a) * static_cast<double>(random_()) / 4294967296.0; }
  std::string bar(const char* name, double length, const std::string& more = "") {
    const double mass = between(0.1, 2);
    return fmt::format(
        "[bodies.{}]\nmass = {}\ninertia = {}\n{}points = {{ a = [0, 0], b = [{}, 0], "
        "mass_centre = [{}, 0] }}\n",
        name, mass, mass * length * length / 12, more, length, 0.5 * length);
  }
  std::string pin(const char* name, const std::string& ends, int bit) {
    auto text = fmt::format("[joints.{}]\ntype = \"revolute\"\n{}\n", name, ends);
    if ((loose_ >> bit & 1) != 0)
      text +=
          fmt::format("clearance = {}\nbearing_radius = 0.01\nsurface = \"steel\"\n", between(1e-4, 8e-4));
    return text;
  }
  std::string driven() {
    return fmt::format(
        "[drives.motor]\njoint = \"A\"\nspeed = \"{} rpm\"\ninitial_angle = \"{} deg\"\n[run]\n"
        "duration = 0.05\n"
        "start = \"ideal\"\n",
        between(100, 600), angle_);
  }
  std::string four_bar() {
    return bar("crank", 0.1 * sizes_[0]) + bar("coupler", 0.35 * sizes_[1]) + bar("rocker", 0.3 * sizes_[2]) +
           "[joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"crank\"]\nat = [[0, 0], \"a\"]\n" +
           pin("B", "between = [\"crank\", \"coupler\"]\nat = [\"b\", \"a\"]", 0) +
           pin("C", "between = [\"coupler\", \"rocker\"]\nat = [\"b\", \"b\"]", 1) +
           pin("D", "between = [\"ground\", \"rocker\"]\nat = [[0.4, 0], \"a\"]", 2) +
           "[assembly]\nbranch = \"open\"\n" + driven();
  }
  std::string slider_crank() {
    loose_ = 1 + loose_ % 3;
    return bar("crank", 0.05 * sizes_[0]) + bar("rod", 0.3 * sizes_[1]) +
           fmt::format("[bodies.slider]\nmass = {}\ninertia = 0.001\n", between(0.3, 2)) +
           "[joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"crank\"]\nat = [[0, 0], \"a\"]\n" +
           pin("B", "between = [\"crank\", \"rod\"]\nat = [\"b\", \"a\"]", 0) +
           pin("C", "between = [\"rod\", \"slider\"]\nat = [\"b\", [0, 0]]", 1) +
           "[joints.guide]\ntype = \"translational\"\nbetween = [\"ground\", \"slider\"]\n"
           "at = [[0, 0], [0, 0]]\n"
           "axis = [1, 0]\n" +
           (heavy_ ? rope : "") +
           (guided_ ? fmt::format("[loads.guide]\ntype = \"joint-friction\"\njoint = "
                                  "\"guide\"\nforce = {}\nregularisation = 1e-3\n",
                                  between(0.5, 20))
                    : "") +
           driven();
  }
  // It slackens twice in each turn.
  static constexpr const char* rope =
      "[loads.rope]\ntype = \"spring-damper\"\nbetween = [\"ground\", \"slider\"]\nstiffness = 200\n"
      "free_length = 0.3\none_way = \"pull\"\n";
  std::string chain() {
    std::string text, before = "ground", joints;
    for (int i = 0; i < bars_; ++i) {
      const auto name = fmt::format("bar{}", i);
      text += bar(name.c_str(), 0.2 * sizes_[0],
                  fmt::format("angle = \"{} deg\"\nangular_velocity = {}\n", -90 + 40 * (i % 2 == 0 ? 1 : -1),
                              between(-2, 2)));
      joints += pin(fmt::format("pin{}", i).c_str(),
                    fmt::format("between = [\"{}\", \"{}\"]\nat = [{}, \"a\"]", before, name,
                                i == 0 ? "[0, 0]" : "\"b\""),
                    i);
      before = name;
    }
    return text + joints + "[run]\nduration = 0.05\nstart = \"ideal\"\n";
  }

  std::mt19937 random_;
  int kind_, loose_, bars_;
  bool guided_, rubs_, heavy_;
  double sizes_[3], angle_, step_;
};

/// Results of simulations that run together, in their order; `in_lanes` counts the steps made in lanes.
std::vector<Result> run_together(const std::vector<Simulation::LaneJob>& all, long& in_lanes) {
  std::vector<Result> results(all.size());
  std::size_t next = 0;
  Simulation::run_together([&]() -> std::optional<Simulation::LaneJob> {
    if (next == all.size()) return {};
    auto one = all[next];
    one.ended = [&, place = next++](Result result, long steps) {
      in_lanes += steps;
      results[place] = std::move(result);
    };
    return one;
  });
  return results;
}

/// Totals over scenes.
struct LaneCounts {
  long steps = 0, in_lanes = 0, events = 0;
  int scenes = 0, laned = 0;
  std::vector<int> by_contacts = std::vector<int>(5);
};

void compare_lanes(unsigned seed, int index, double steps, int lanes, LaneCounts& counts,
                   bool guided = false) {
  LaneScenes kind(seed, index, guided);
  std::vector<Scene> scenes;
  // One more than there are lanes, so that one starts in a lane that another has left.
  for (int i = 0; i <= lanes; ++i) scenes.push_back(kind.scene());
  std::vector<Simulation> together;
  for (const auto& scene : scenes)
    together.emplace_back(scene, "nonsmooth", SimulationOptions{.compile = Compile::always});
  std::vector<Simulation::LaneJob> all;
  for (std::size_t i = 0; i < together.size(); ++i)
    all.push_back({&together[i], {.until = kind.step() * (steps - 7.3 * static_cast<double>(i))}, [] {
                     return INFINITY;
                   }});
  long in_lanes = 0;
  const auto found = run_together(all, in_lanes);
  REQUIRE(found.size() == scenes.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    INFO("scene " << index << ", lane " << i);
    Simulation alone(scenes[i], "nonsmooth", {.compile = Compile::never});
    test::check_same_run(found[i], alone.run({.until = all[i].request.until}));
    counts.steps += found[i].work.steps;
    counts.events += static_cast<long>(found[i].events.size());
  }
  ++counts.scenes;
  counts.laned += in_lanes > 0;
  counts.in_lanes += in_lanes;
  ++counts.by_contacts[together.front().layout().contacts.size()];
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

TEST_CASE("slider-cranks with friction in the guide: lanes and runs alone", "[lanes]") {
  const test::CompilerCache cache;
  LaneCounts counts;
  for (const int index : {0, 1, 2, 3, 4, 5}) compare_lanes(7, index, 4000, 3, counts, true);
  CHECK(counts.laned >= 4);
  CHECK(counts.events > 20);
  CHECK(counts.in_lanes > counts.steps / 4);
}

TEST_CASE("fifty random scenes with one to four contacts: lanes and runs alone", "[lanes][.]") {
  const test::CompilerCache cache;
  LaneCounts counts;
  for (int index = 0; index < 50; ++index) compare_lanes(17, index, 20000, lanes_of_machine(), counts);
  UNSCOPED_INFO(fmt::format(
      "{} scenes, {} in lanes, {} of {} steps, {} events; with 1 to 4 contacts: {} {} {} {}", counts.scenes,
      counts.laned, counts.in_lanes, counts.steps, counts.events, counts.by_contacts[1],
      counts.by_contacts[2], counts.by_contacts[3], counts.by_contacts[4]));
  for (int contacts = 1; contacts <= 4; ++contacts)
    CHECK(counts.by_contacts[static_cast<std::size_t>(contacts)] > 0);
  CHECK(counts.laned >= 45);
  WARN(fmt::format("{} of {} steps in lanes, {} of {} scenes, {} events; with 1 to 4 contacts: {} {} {} {}",
                   counts.in_lanes, counts.steps, counts.laned, counts.scenes, counts.events,
                   counts.by_contacts[1], counts.by_contacts[2], counts.by_contacts[3],
                   counts.by_contacts[4]));
}

TEST_CASE("runs of different structures together are runs alone", "[lanes][compiled]") {
  const test::CompilerCache cache;
  LaneScenes first(5, 0), second(5, 1);
  const std::vector<Scene> scenes{first.scene(), second.scene(), first.scene()};
  std::vector<Simulation> together;
  for (const auto& scene : scenes)
    together.emplace_back(scene, "nonsmooth", SimulationOptions{.compile = Compile::always});
  std::vector<Simulation::LaneJob> all;
  for (auto& simulation : together) all.push_back({&simulation, {.until = 0.01}, [] { return INFINITY; }});
  long in_lanes = 0;
  const auto found = run_together(all, in_lanes);
  CHECK(in_lanes > 0);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    test::check_same_run(
        found[i], Simulation(scenes[i], "nonsmooth", {.compile = Compile::never}).run({.until = 0.01}));
}

TEST_CASE("an ensemble has the same statistics and bands with and without lanes",
          "[lanes][ensemble][compiled]") {
  const test::CompilerCache cache;
  const auto scene = open_scene(test::flores(), {"run.revolutions=0.2", "run.discard=0.05"});
  const EnsemblePlan plan{.starts = 11, .rows = 11, .threads = 2};
  const auto with = [&](const char* choice) {
    setenv("FREEPLAY_COMPILE", choice, 1);
    auto all = run_ensemble(*scene, plan, {});
    unsetenv("FREEPLAY_COMPILE");
    return all;
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

TEST_CASE("functions in lanes: each lane has its constants, choices and guards",
          "[lanes][compiled]") {
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

TEST_CASE(
    "compiled runs of fixed steps: impacts, clearances, sticking, dampers, tables, and friction of a joint",
    "[compiled]") {
  const test::CompilerCache cache;
  for (const std::string name :
       {"flores2011/scene", "four-bar/scene", "block-on-slope/scene", "press/scene", "spring-balance/scene",
        "gear-rattle/scene", "flores2011-experiment/guide"}) {
    INFO(name);
    auto scene = test::read_short(test::source_folder() / "cases" / (name + ".toml"), 0.2);
    scene.nonsmooth.scheme = Scheme::moreau_jean;
    scene.nonsmooth.step = 2e-5;
    if (name == "four-bar/scene") {
      auto& joints = scene.mechanism.joints;
      std::get<RevoluteJoint>(joints[1]).clearance = std::get<RevoluteJoint>(joints[2]).clearance;
    }
    const SimulationOptions by_compiled{.compile = Compile::always}, by_general{.compile = Compile::never};
    const auto found = Simulation(scene, "nonsmooth", by_compiled).run();
    CHECK(found.compiled.used);
    CHECK(found.compiled.refused < found.work.steps / 100);
    test::check_same_run(found, Simulation(scene, "nonsmooth", by_general).run());
    Simulation first(scene, "nonsmooth", by_compiled), second(scene, "nonsmooth", by_general);
    first.run({.until = 0.1});
    second.restore(first.snapshot());
    second.run();
    CHECK(second.state().q == found.final_state.q);
  }
}

TEST_CASE("compiled runs from concentric journals, which have no row, to their first impacts",
          "[compiled]") {
  const test::CompilerCache cache;
  auto scene = test::read_short(test::source_folder() / "cases/flores2011/scene.toml", 0.05);
  scene.nonsmooth.step = 2e-6;  // many steps before the first impact
  const auto found = Simulation(scene, "nonsmooth", {.compile = Compile::always}).run();
  CHECK(found.compiled.used);
  CHECK(found.events_seen > 10);
  test::check_same_run(found, Simulation(scene, "nonsmooth", {.compile = Compile::never}).run());
}
