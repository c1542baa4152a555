// Snapshots of mechanisms with beams, full and reduced: runs continue bit for bit from states in flight, within an
// impact and in the contact that lasts while elastic waves run through a rod.
#include "verification/property/comparison/snapshot_check.hpp"

using namespace freeplay;
using namespace freeplay::snapshots;

namespace {

const std::string reduced = " beams.rod.modes=2";

/// An elastic rod between two light bodies, which meets a wall with its nose: the contact lasts for two passages of the
/// wave, about 0.021 s of 0.03 s.
std::string rod_on_wall() {
  const auto end = [](const char* name, double x) {
    return test::body(name, 0.0025, 1e-6,
                      fmt::format("position = [{}, 0.0]\nangle = 0.0\nvelocity = [-0.1, 0.0]\n", x));
  };
  return end("nose", 1e-4) + end("tail", 1.0001) +
         "[beams.rod]\nbetween = [\"nose\", \"tail\"]\nlength = 1.0\nelements = 4\nyoung = 1e4\ndensity = 1\n"
         "area = 1\nsecond_moment = 1e-3\ndamping = 1e-4\n" +
         test::plane("wall", "ground", "nose", 0, "s", "axis = [0.0, -1.0]\nstiffness = 1e6\n") +
         test::surface("s", 0.1) +
         test::run_for(0.03, "output_step = 1e-3\n[penalty]\ncontact = \"exact\"\n");
}

const std::string events = "nonsmooth.scheme=event-driven",
                  stepping = "nonsmooth.scheme=moreau-jean nonsmooth.step=",
                  adaptive = stepping + "automatic", automatic = "nonsmooth.scheme=automatic";

}  // namespace

TEST_CASE("snapshots: an elastic rod in flight and in contact with a wall", "[snapshot][beams]") {
  for (const auto& keys : {std::string(), reduced}) {
    for (const auto& scheme : {events, adaptive, automatic})
      check(rod_on_wall(), "nonsmooth", scheme + keys, {flight, contact, impact});
    check(rod_on_wall(), "nonsmooth", stepping + "1e-4" + keys,
          {flight, impact});  // all impulses are impacts
    for (const std::string integrator :
         {"adams_bashforth_moulton", "rosenbrock4", "dopri5", "bulirsch_stoer"})
      check(rod_on_wall(), "penalty", "penalty.integrator=" + integrator + keys, {flight, contact});
  }
}

TEST_CASE("snapshots: a slider-crank with a flexible rod, a loose pin and instruments", "[snapshot][beams]") {
  // Explicit schemes resolve the axial waves of the rod. The first impacts occur after 4.5 ms. A reduced rod has no
  // strain gauge.
  const auto whole = test::file_text(test::source_folder() / "cases/flores2011-flexible/scene.toml");
  auto without = whole;
  const auto gauge = without.find("[instruments.strain]");
  without.erase(gauge, without.find("[instruments.accelerometer]") - gauge);
  for (const auto& [text, keys] : {std::pair{whole, std::string()}, std::pair{without, reduced}}) {
    const auto brief = keys + " run.revolutions=0.025 run.discard=0";
    check(text, "nonsmooth", events + brief, {flight, impact});
    check(text, "nonsmooth", stepping + "2e-5" + brief, {flight, impact});
    check(text, "penalty", brief, {flight, contact});
  }
  check(whole, "nonsmooth", adaptive + " run.revolutions=0.025 run.discard=0", {flight, impact});
}
