// Compiled mechanisms: their functions and right-hand sides (dynamics/motion_kernel.cpp) against the
// templates of System and the general solution of the linear system, and where they are not used. The
// expected digits are those of the templates, which other tests compare with closed forms.
#include "compile/compile.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/movable_rows.hpp"
#include "dynamics/motion_kernel.hpp"
#include "dynamics/system.hpp"
#include "verification/random_scenes/scene.hpp"
#include "verification/support/compiled_runs.hpp"
#include "verification/support/named.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using test::penalty, test::penalty_by, test::event_driven, test::fixed_steps, test::check_compiled;

namespace rs = freeplay::verification::random_scenes;

namespace {

/// A random mechanism at the start of its scene.
struct RandomSystem {
  RandomSystem(std::uint64_t seed, int index)
      : drawn(rs::draw(seed, index)), scene(rs::scene_for(drawn, rs::ways(drawn.suite).front())) {}
  rs::RandomScene drawn;
  Scene scene;
  System system{scene.mechanism};
  State start = assemble(scene.mechanism, scene.run.start);
  RowFacts facts{!redundant_rows(system, start.q).empty(), true};
};

}  // namespace

TEST_CASE("random scenes: compiled functions give the digits of the templates", "[compiled]") {
  const test::CompilerCache cache;
  int compiled = 0, solved = 0;
  for (int index = 0; index < 60; ++index) {
    RandomSystem random(7, index);
    INFO(random.drawn.kind << " " << index);
    const auto traced = trace_system(random.system, random.start, random.facts);
    if (traced.object.functions() == 0) continue;
    auto functions = test::compiled(traced);
    ++compiled;
    solved += traced.solves;
    CHECK(differing_quantities(random.system, functions, random.start, random.facts) == 0);
    if (random.system.n() == 0 || functions.constants.empty()) continue;
    // A wrong constant must be noticed.
    for (double& k : functions.constants) k *= 1.5;
    CHECK(differing_quantities(random.system, functions, random.start, random.facts) > 0);
  }
  CHECK(compiled >= 40);
  CHECK(solved >= 30);
}

TEST_CASE("random scenes: compiled right-hand sides have the digits of general ones", "[compiled]") {
  const test::CompilerCache cache;
  int whole = 0, contacts = 0, jointed = 0, noticed = 0;
  for (int index = 0; index < 24; ++index)
    for (const auto scheme : {TracedFor::event_driven, TracedFor::penalty}) {
      RandomSystem random(12, index);
      auto& system = random.system;
      INFO(random.drawn.kind << " " << index);
      const auto traced = trace_system(system, random.start, random.facts, scheme);
      if (!traced.motion && !traced.state) continue;
      CHECK(traced.motion == (scheme == TracedFor::event_driven));
      auto functions = test::compiled(traced);
      ++whole;
      contacts += system.contacts() > 0;
      CHECK(differing_motions(system, functions, random.start, random.facts, 3) == 0);
      for (double& k : functions.constants)
        for (const double mass : system.mass())
          if (k == 1 / mass) k *= 1 + 1e-12;
      if (system.rows() == 0) continue;  // free bodies without forces have no accelerations
      ++jointed;
      noticed += differing_motions(system, functions, random.start, random.facts, 3) > 0;
    }
  CAPTURE(whole, contacts, jointed, noticed);
  CHECK(whole >= 15);
  CHECK(contacts >= 10);
  CHECK(jointed >= 10);
  CHECK(noticed >= jointed - 2);  // the factor may have no effect on the digits of a slow motion
}

TEST_CASE("a guard that fails at run time leaves the state to the templates", "[compiled]") {
  const test::CompilerCache cache;
  // A concentric journal has no normal. The trace is made beside that state, so its guard fails there.
  const auto scene = read_scene(test::flores());
  System system(scene.mechanism);
  const auto start = assemble(scene.mechanism, RunOptions::Start::ideal);
  ContactRow general, compiled;
  auto e = system.make_evaluation();
  system.place(start.t, start.q.data(), e);
  system.contact(0, start.q.data(), start.v.data(), e, general);
  REQUIRE(compile_system(system, start, {}, {})->used);
  system.contact(0, start.q.data(), start.v.data(), e, compiled);
  CHECK(system.compiled().refused() == 1);
  CHECK(compiled.normal.size == general.normal.size);
  CHECK(compiled.gap == general.gap);
  // A coordinate that the guide holds still moves.
  auto q = start.q;
  q[8] = 1e-3;
  system.place(start.t, q.data(), e);
  CHECK(system.compiled().refused() == 2);
  CHECK(e.sine[2] == std::sin(1e-3));
}

TEST_CASE("elements that cannot be traced keep their templates, and the result says so", "[compiled]") {
  const test::CompilerCache cache;
  auto scene = read_scene(test::source_folder() / "cases/cam-follower/scene.toml");
  auto& cam = std::get<CamContact>(scene.mechanism.contacts.at(0));
  cam.follower = CamContact::Follower::roller;  // its place on the cam is found by iteration
  cam.base_radius = 0.02;
  cam.roller_radius = 0.01;
  scene.run.duration = 0.01;
  scene.run.discard = 0;
  const auto compiled = test::run_as(scene, "penalty", Compile::always),
             general = test::run_as(scene, "penalty", Compile::never);
  REQUIRE(compiled.compiled.general_parts.size() == 1);
  CHECK(compiled.compiled.general_parts[0].starts_with("lobe: "));
  test::check_same_run(compiled, general);
}

TEST_CASE("FREEPLAY_COMPILE decides where nothing else is asked", "[compiled]") {
  const auto choice = [](const char* value, Compile asked = Compile::automatic) {
    const test::Environment compile("FREEPLAY_COMPILE", value);
    return compile_choice(asked);
  };
  CHECK(choice("never") == Compile::never);
  CHECK(choice("never", Compile::always) == Compile::always);
  CHECK(choice(nullptr) == Compile::automatic);
  CHECK_THROWS_AS(choice("perhaps"), ModelError);
}

TEST_CASE("without a compiler or a private cache a run takes the general path and says why", "[compiled]") {
  const test::TemporaryFolder folder;
  const std::string brief = " --set run.revolutions=0.1 --set run.discard=0 -o ";
  const auto run = [&](const std::string& name) {
    const auto out = folder.path() / name;
    test::succeeded("run " + test::flores().string() + " --formulation penalty --compile --no-figures" +
                    brief + out.string());
    return test::file_text(out / "run.json");
  };
  const auto ensemble = [&](const char* choice, const char* name) {
    const test::Environment compile("FREEPLAY_COMPILE", choice);
    const auto out = folder.path() / name;
    // Its status is that of the figures, which need gnuplot.
    (void)test::freeplay("ensemble " + test::flores().string() + " --starts 5 --threads 1 --rows 5" + brief +
                         out.string());
    return out;
  };
  const auto has_lanes = [](const std::filesystem::path& out) {
    return test::file_text(out / "ensemble.json").find("\"steps_in_lanes\": 0,") == std::string::npos;
  };
  {
    const test::Environment cache("XDG_CACHE_HOME", folder.path().c_str());
    CHECK(run("compiled").find("\"used\": true") != std::string::npos);
    std::filesystem::path uncompiled;
    {
      const test::Environment no_tools("PATH", "/nonexistent");
      CHECK(run("no-compiler").find("no C compiler") != std::string::npos);
      uncompiled = ensemble("always", "uncompiled");
    }
    const auto lanes = ensemble("always", "lanes"), alone = ensemble("never", "alone");
    CHECK(has_lanes(lanes));
    CHECK_FALSE(has_lanes(uncompiled));
    CHECK_FALSE(has_lanes(alone));
    for (const char* file : {"starts.csv", "statistics.csv", "bands.csv"})
      for (const auto& other : {lanes, uncompiled})
        CHECK(test::file_text(other / file) == test::file_text(alone / file));
  }
  const test::Environment no_cache("XDG_CACHE_HOME", nullptr), no_home("HOME", nullptr);
  CHECK(run("no-cache").find("there is no cache folder") != std::string::npos);
}

// Whole runs of compiled mechanisms against general runs: every digit of the result, and of the rest
// of a run that a snapshot of the compiled one continues. The expected digits are those of the general
// path, which other tests compare with closed forms.

namespace {

/// The second joint of the four-bar with clearance, too.
const std::vector<std::string> two_clearances{"joints.B.clearance=0.2 mm", "joints.B.bearing_radius=10 mm",
                                              "joints.B.surface=steel"};

}  // namespace

TEST_CASE("compiled runs with adaptive steps: impacts, clearances, and friction that sticks", "[compiled]") {
  const test::CompilerCache cache;
  for (const auto& way : {penalty, event_driven}) check_compiled("flores2011/scene", 0.1, way, 0.02);
  // Jacobians, and states at which a dependent row is not resolved, are refused without a bound.
  check_compiled("flores2011/scene", 0.1, penalty_by("rosenbrock4"), INFINITY);
  check_compiled("flores2011/scene", 0.1, penalty_by("dopri5"), INFINITY, {"run.eliminate=false"});
  for (const auto& way : {penalty, event_driven})
    check_compiled("four-bar/scene", 0.1, way, 0.02, two_clearances);
  check_compiled("block-on-slope/scene", 0.1, event_driven, 0.02);
}

TEST_CASE("compiled runs of fixed steps: impacts, clearances, sticking, dampers, and friction of a joint",
          "[compiled]") {
  const test::CompilerCache cache;
  for (const char* name : {"flores2011/scene", "block-on-slope/scene", "press/scene", "spring-balance/scene",
                           "flores2011-experiment/guide"})
    check_compiled(name, 0.2, fixed_steps(2e-5), 0.01);
  check_compiled("four-bar/scene", 0.2, fixed_steps(2e-5), 0.01, two_clearances);
}

TEST_CASE("compiled runs from concentric journals, which have no row, to their first impacts", "[compiled]") {
  const test::CompilerCache cache;
  // Many steps before the first impact. Concentric journals are evaluated by the general path.
  const auto found = check_compiled("flores2011/scene", 0.05, fixed_steps(2e-6), 1);
  CHECK(found.events_seen > 10);
  CHECK(found.compiled.refused < found.work.steps);
}

// Runs of compiled mechanisms with tables, stops, teeth and cams against general runs. The claims of
// "compiled" contain random scenes with tables and curves in every scheme.

TEST_CASE("compiled runs with tables, stops, teeth and cams", "[compiled]") {
  const test::CompilerCache cache;
  for (const auto& [name, duration] : {std::pair{"gear-rattle/scene", 0.05},
                                       {"published/exudyn-contact-coordinate/scene", 0.3},
                                       {"published/backlash-joint-driven/scene", 0.3},
                                       {"published/car-axis/scene", 0.2},
                                       {"motor-startup/scene", 0.1},
                                       {"positioning-axis/scene", 0.1},
                                       {"ball-on-table/scene", 0.2}})
    // Interpolated states of event location may be refused.
    for (const auto& way : {test::penalty, test::fixed_steps(1e-4)})
      CHECK(test::check_compiled(name, duration, way, 0.5).compiled.general_parts.empty());
}
