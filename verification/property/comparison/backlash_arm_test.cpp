// Gears with backlash on a moving arm. Both centres of the second pair move, so a trial step may
// bring them within the base circles, where the gap of the flanks has no bound. Such a step is
// repeated with a shorter length.
#include "io/scene/read_scene.hpp"
#include "values/warning.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

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
