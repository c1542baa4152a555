// Compiled right-hand sides (dynamics/motion_kernel.cpp) against the templates of System and the
// general solution of the linear system, and whole runs with and without them. The expected digits are
// those of the general path, which other tests compare with closed forms.
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/movable_rows.hpp"
#include "dynamics/motion_kernel.hpp"
#include "dynamics/system.hpp"
#include "verification/random_scenes/scene.hpp"
#include "verification/support/compiled_runs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
namespace rs = freeplay::verification::random_scenes;

TEST_CASE("random scenes: compiled right-hand sides have the digits of general ones", "[compiled]") {
  const test::CompilerCache cache;
  int whole = 0, contacts = 0, jointed = 0, noticed = 0;
  for (int index = 0; index < 24; ++index) {
    const auto drawn = rs::draw(12, index);
    INFO(drawn.kind << " " << index);
    const auto scene = rs::scene_for(drawn, rs::ways(drawn.suite).front());
    System system(scene.mechanism);
    const auto start = assemble(scene.mechanism, scene.run.start);
    const RowFacts facts{!redundant_rows(system, start.q).empty(), true};
    for (const auto scheme : {TracedFor::event_driven, TracedFor::penalty}) {
      const auto traced = trace_system(system, start, facts, scheme);
      if (!traced.motion && !traced.state) continue;
      CHECK(traced.motion == (scheme == TracedFor::event_driven));
      auto functions = test::compiled(traced);
      ++whole;
      contacts += system.contacts() > 0;
      CHECK(differing_motions(system, functions, start, facts, 3) == 0);
      for (double& k : functions.constants)
        for (const double mass : system.mass())
          if (k == 1 / mass) k *= 1 + 1e-12;
      if (system.rows() == 0) continue;  // free bodies without forces have no accelerations
      ++jointed;
      noticed += differing_motions(system, functions, start, facts, 3) > 0;
    }
  }
  CAPTURE(whole, contacts, jointed, noticed);
  CHECK(whole >= 15);
  CHECK(contacts >= 10);
  CHECK(jointed >= 10);
  CHECK(noticed >= jointed - 2);  // the factor may have no effect on the digits of a slow motion
}

TEST_CASE("runs with compiled right-hand sides: impacts, two clearances, and friction that sticks",
          "[compiled]") {
  const test::CompilerCache cache;
  for (const char* name : {"flores2011", "four-bar", "block-on-slope"})
    for (const char* formulation : {"nonsmooth", "penalty"}) {
      const bool stiff = name != std::string("block-on-slope");  // it has no stiffness of its contacts
      if (!stiff && formulation == std::string("penalty")) continue;
      CAPTURE(name, formulation);
      auto scene = test::read_short(test::source_folder() / "cases" / name / "scene.toml", 0.1);
      scene.nonsmooth.scheme = Scheme::event_driven;
      if (name == std::string("four-bar")) {
        auto& joints = scene.mechanism.joints;
        std::get<RevoluteJoint>(joints[1]).clearance = std::get<RevoluteJoint>(joints[2]).clearance;
      }
      const SimulationOptions by_compiled{.compile = Compile::always}, by_general{.compile = Compile::never};
      const auto a = Simulation(scene, formulation, by_compiled).run(),
                 b = Simulation(scene, formulation, by_general).run();
      CHECK(a.compiled.used);
      CHECK(a.compiled.refused <= a.work.rhs / 50);
      test::check_same_run(a, b);
      Simulation first(scene, formulation, by_compiled), second(scene, formulation, by_general),
          whole(scene, formulation, by_general);
      first.run({.until = 0.05});
      second.restore(first.snapshot());
      second.run();
      whole.run({.until = 0.05});
      whole.run();
      CHECK(second.state().q == whole.state().q);
      CHECK(second.state().v == whole.state().v);
    }
}
