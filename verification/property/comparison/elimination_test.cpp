// Absent elements cost nothing, and elimination of coordinates does not change the motion.
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "numerics/saddle_point.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

double greatest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

}  // namespace

// Both solve the same equations in another order: 1e-16 apart at first, some ten times more after
// each of the few impacts, and with adaptive steps by the step's error bound of 1e-9.
TEST_CASE("the motion with and without elimination of coordinates is the same", "[elimination]") {
  for (const char* name : {"gudgeon", "four_bar", "big_end", "pendulum", "dragged_block"})
    for (const auto& way : {test::penalty, test::fixed_steps(1e-5), test::event_driven}) {
      auto scene = read_scene(test::scene_file(name));
      // Up to the first few impacts: later, rounding separates any two runs.
      scene.run.duration = std::min(scene.run.duration, 0.012);
      scene.run.discard = 0;
      if (!way.penalty()) scene.nonsmooth.scheme = way.scheme;
      if (way.penalty() && !scene.mechanism.surfaces.empty() && !scene.mechanism.surfaces[0].young) continue;
      Result run[2];
      for (const bool eliminate : {false, true}) {
        scene.run.eliminate = eliminate;
        run[eliminate] = test::finished(scene, way.family);
      }
      CAPTURE(name, way.name);
      CHECK(greatest_difference(run[0].final_state.q, run[1].final_state.q) <= 1e-9);
      CHECK(greatest_difference(run[0].final_state.v, run[1].final_state.v) <= 1e-6);
      CHECK(std::abs(run[1].ledger.drive - run[0].ledger.drive) <= 1e-6);
    }
}

namespace {

struct Rung {
  const char* name;
  Scene scene;
  int rows, tangents, contacts, eliminated, largest, preloaded = 0, instruments = 0;
};

std::vector<Rung> ladder() {
  std::vector<Rung> rungs;
  auto pendulum = read_scene(test::scene_file("pendulum"));
  pendulum.mechanism = idealised(pendulum.mechanism);
  rungs.push_back({"pendulum", pendulum, 2, 0, 0, 0, 2});
  auto rig = read_scene(test::flores());
  const auto instruments = rig.instruments;
  rig.instruments.clear();
  auto ideal = rig;
  ideal.mechanism = idealised(rig.mechanism);
  // 3 pins of 2 rows, a guide of 2, a drive: 9. The crank's three and the slider's two coordinates
  // are fixed.
  rungs.push_back({"ideal rig", ideal, 9, 0, 0, 5, 4});
  auto smooth = rig;
  smooth.mechanism.surfaces[0].friction.reset();
  rungs.push_back({"loose, frictionless", smooth, 7, 0, 1, 5, 2});
  rungs.push_back({"loose, with friction", rig, 7, 1, 1, 5, 2});
  auto watched = rig;
  watched.instruments = instruments;
  rungs.push_back({"with accelerometer", watched, 7, 1, 1, 5, 2, 0, 1});
  // The guide's friction is a separate row, no constraint; the LVDT only measures.
  const auto guided = read_scene(test::source_folder() / "cases/flores2011-experiment/guide.toml");
  rungs.push_back({"with guide friction and LVDT", guided, 7, 1, 1, 5, 2, 1, 2});
  return rungs;
}

}  // namespace

TEST_CASE("each mechanism of the cost ladder adds its own elements and no others", "[elimination]") {
  for (const auto& rung : ladder()) {
    CAPTURE(rung.name);
    const System system(rung.scene.mechanism);
    const SaddlePoint saddle(system.mass(), system.pattern());
    int tangents = 0;
    auto e = system.make_evaluation();
    const auto state = assemble(rung.scene.mechanism, rung.scene.run.start);
    system.place(0, state.q.data(), e);
    for (int k = 0; k < system.contacts(); ++k) {
      ContactRow row;
      system.contact(k, state.q.data(), state.v.data(), e, row);
      tangents += system.has_friction(k);
      if (!system.has_friction(k)) CHECK(row.tangent.size == 0);
      CHECK(row.film.size == 0);
    }
    CHECK(system.rows() == rung.rows);
    CHECK(tangents == rung.tangents);
    CHECK(system.contacts() == rung.contacts);
    CHECK(static_cast<int>(saddle.eliminated().size()) == rung.eliminated);
    CHECK(saddle.largest_block() == rung.largest);
    CHECK(system.frictions() == rung.preloaded);
    CHECK(static_cast<int>(rung.scene.instruments.size()) == rung.instruments);
    auto scene = rung.scene;
    scene.run.duration = 0.01;
    scene.run.discard = 0;
    const auto run = test::simulate(scene, Family::nonsmooth);
    if (rung.contacts == 0) CHECK(run.work.lcp_solves == 0);
    CHECK(run.contacts.size() == static_cast<std::size_t>(rung.contacts));
  }
}
