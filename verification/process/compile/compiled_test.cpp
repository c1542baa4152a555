// Compiled mechanisms: their functions against the templates of System, and whole runs with and
// without them. The expected digits are those of the templates, which other tests compare with closed
// forms.
#include <variant>

#include "compile/compile.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/movable_rows.hpp"
#include "dynamics/system.hpp"
#include "verification/random_scenes/scene.hpp"
#include "verification/support/compiled_runs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
namespace rs = freeplay::verification::random_scenes;

TEST_CASE("random scenes: compiled functions give the digits of the templates", "[compiled]") {
  const test::CompilerCache cache;
  int compiled = 0, solved = 0;
  for (int index = 0; index < 60; ++index) {
    const auto drawn = rs::draw(7, index);
    const auto& way = rs::ways(drawn.suite).front();
    INFO(drawn.kind << " " << index);
    const auto scene = rs::scene_for(drawn, way);
    System system(scene.mechanism);
    const auto start = assemble(scene.mechanism, scene.run.start);
    const RowFacts facts{!redundant_rows(system, start.q).empty(), true};
    const auto traced = trace_system(system, start, facts);
    if (traced.object.functions() == 0) continue;
    auto functions = test::compiled(traced);
    ++compiled;
    solved += traced.solves;
    CHECK(differing_quantities(system, functions, start, facts) == 0);
    if (system.n() == 0 || functions.constants.empty()) continue;
    // A wrong constant must be noticed.
    auto wrong = functions;
    for (double& k : wrong.constants) k *= 1.5;
    CHECK(differing_quantities(system, wrong, start, facts) > 0);
  }
  CHECK(compiled >= 40);
  CHECK(solved >= 30);
}

TEST_CASE("runs of compiled mechanisms have the digits of general runs", "[compiled]") {
  const test::CompilerCache cache;
  auto scene = test::read_short(test::flores(), 0.1);
  struct Case {
    const char* formulation;
    Integrator integrator = Integrator::adams_bashforth_moulton;
    Scheme scheme = Scheme::event_driven;
    bool eliminate = true;
  };
  for (const auto& c :
       {Case{"penalty"}, Case{"penalty", Integrator::rosenbrock4}, Case{"nonsmooth"},
        Case{"nonsmooth", {}, Scheme::moreau_jean}, Case{"penalty", Integrator::dopri5, {}, false}}) {
    INFO(c.formulation << " " << static_cast<int>(c.integrator) << " " << static_cast<int>(c.scheme));
    scene.penalty.integrator = c.integrator;
    scene.nonsmooth.scheme = c.scheme;
    scene.run.eliminate = c.eliminate;
    const auto general = test::run_as(scene, c.formulation, Compile::never);
    const auto compiled = test::run_as(scene, c.formulation, Compile::always);
    CHECK(compiled.compiled.reason.empty());
    CHECK(compiled.compiled.used);
    CHECK_FALSE(general.compiled.used);
    test::check_same_run(compiled, general);
  }
}

TEST_CASE("a snapshot of a compiled run continues in a general one", "[compiled]") {
  const test::CompilerCache cache;
  auto scene = read_scene(test::flores());
  for (const char* formulation : {"penalty", "nonsmooth"}) {
    scene.nonsmooth.scheme = Scheme::event_driven;
    Simulation compiled(scene, formulation, {.compile = Compile::always});
    Simulation general(scene, formulation, {.compile = Compile::never});
    compiled.run({.until = 0.05});
    general.restore(compiled.snapshot());
    compiled.run({.until = 0.08});
    general.run({.until = 0.08});
    CHECK(compiled.state().q == general.state().q);
    CHECK(compiled.state().v == general.state().v);
  }
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

TEST_CASE("elements that cannot be traced keep their templates, and the result says so",
          "[compiled]") {
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
  setenv("FREEPLAY_COMPILE", "never", 1);
  CHECK(compile_choice(Compile::automatic) == Compile::never);
  CHECK(compile_choice(Compile::always) == Compile::always);
  setenv("FREEPLAY_COMPILE", "perhaps", 1);
  CHECK_THROWS_AS(compile_choice(Compile::automatic), ModelError);
  unsetenv("FREEPLAY_COMPILE");
  CHECK(compile_choice(Compile::automatic) == Compile::automatic);
  setenv("FREEPLAY_COMPILE", "never", 1);  // as for all tests
}

TEST_CASE("without a compiler or a private cache a run takes the general path and says why",
          "[compiled]") {
  const test::TemporaryFolder folder;
  const auto run = [&](const std::string& name) {
    const auto out = folder.path() / name;
    test::succeeded("run " + test::flores().string() +
                    " --formulation penalty --compile --no-figures --set run.revolutions=0.1 "
                    "--set run.discard=0 -o " +
                    out.string());
    return test::file_text(out / "run.json");
  };
  const std::string path = std::getenv("PATH"), home = std::getenv("HOME") ? std::getenv("HOME") : "/";
  setenv("XDG_CACHE_HOME", folder.path().c_str(), 1);
  CHECK(run("compiled").find("\"used\": true") != std::string::npos);
  const auto ensemble = [&](const char* choice, const char* name) {
    setenv("FREEPLAY_COMPILE", choice, 1);
    const auto out = folder.path() / name;
    // Its status is that of the figures, which need gnuplot.
    (void)test::freeplay(
        "ensemble " + test::flores().string() +
        " --starts 5 --threads 1 --rows 5 --set run.revolutions=0.1 --set run.discard=0 -o " + out.string());
    return out;
  };
  setenv("PATH", "/nonexistent", 1);
  CHECK(run("no-compiler").find("no C compiler") != std::string::npos);
  const auto uncompiled = ensemble("always", "uncompiled");
  setenv("PATH", path.c_str(), 1);
  const auto lanes = ensemble("always", "lanes"), alone = ensemble("never", "alone");
  const auto has_lanes = [](const std::filesystem::path& out) {
    return test::file_text(out / "ensemble.json").find("\"steps_in_lanes\": 0,") == std::string::npos;
  };
  CHECK(has_lanes(lanes));
  CHECK_FALSE(has_lanes(uncompiled));
  CHECK_FALSE(has_lanes(alone));
  for (const char* file : {"starts.csv", "statistics.csv", "bands.csv"})
    for (const auto& other : {lanes, uncompiled})
      CHECK(test::file_text(other / file) == test::file_text(alone / file));
  unsetenv("XDG_CACHE_HOME");
  unsetenv("HOME");
  CHECK(run("no-cache").find("there is no cache folder") != std::string::npos);
  setenv("HOME", home.c_str(), 1);
}
