// Compiled time steps (dynamics/step_trace.cpp) against the general path of time stepping. The
// expected digits are those of the general path, which other tests compare with closed forms.
#include <variant>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/movable_rows.hpp"
#include "dynamics/system.hpp"
#include "formulations/time_stepping/lanes.hpp"
#include "verification/random_scenes/scene.hpp"
#include "verification/support/compiled_runs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
namespace rs = freeplay::verification::random_scenes;

TEST_CASE("random scenes: compiled steps have the digits of general ones", "[compiled][program]") {
  const test::CompilerCache cache;
  int whole = 0, contacts = 0, noticed = 0;
  for (int index = 0; index < 60; ++index) {
    const auto drawn = rs::draw(11, index);
    INFO(drawn.kind << " " << index);
    const auto scene = rs::scene_for(drawn, rs::ways(drawn.suite).front());
    System system(scene.mechanism);
    const auto start = assemble(scene.mechanism, scene.run.start);
    const RowFacts facts{!redundant_rows(system, start.q).empty(), true};
    const auto traced = trace_system(system, start, facts, TracedFor::fixed_steps);
    if (!traced.steps) continue;
    auto functions = test::compiled(traced);
    ++whole;
    contacts += system.contacts() > 0;
    CHECK(differing_steps(system, functions, start, facts) == 0);
    for (double& k : functions.constants)
      if (k == 0.5) k = 0.51;
    noticed += differing_steps(system, functions, start, facts) > 0;
  }
  CHECK(whole >= 15);
  CHECK(contacts >= 10);
  CHECK(noticed >= whole - 2);  // the factor of the rates has no effect on a body at rest
}

TEST_CASE("runs in compiled steps: impacts, clearances, sticking, dampers, tables, and friction of a joint",
          "[compiled][program]") {
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
    const System system(scene.mechanism);
    CHECK(trace_system(system, assemble(scene.mechanism, scene.run.start), {}, TracedFor::fixed_steps).steps);
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
