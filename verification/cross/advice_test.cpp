// Advice held to its word on scenes that it was not made from, by the oracle; and --accuracy.
#include <catch2/catch.hpp>

#include "cli/makers.hpp"
#include "study/tradeoff.hpp"
#include "verification/references/delivered_restitution.hpp"
#include "verification/references/slider_crank_oracle.hpp"
#include "verification/support.hpp"

using namespace freeplay;

namespace {

using Oracle = reference::SliderCrankOracle<long double>;

std::vector<ContactEvent> events(const reference::OracleRun<long double>& run) {
  std::vector<ContactEvent> list;
  for (const auto& i : run.impacts) {
    ContactEvent e;
    e.t = static_cast<double>(i.t);
    e.v_n_minus = static_cast<double>(i.v_n_minus);
    e.impulse_n = static_cast<double>(i.impulse_n);
    list.push_back(e);
  }
  return list;
}

}  // namespace

TEST_CASE("advice keeps its word on scenes that no setting was chosen from", "[advice]") {
  struct Rig {
    const char* scene;
    long double clearance, rpm, friction;
  };
  for (const auto& rig :
       {Rig{"gudgeon_1mm_250rpm", 1e-3L, 250, 0.01L}, Rig{"gudgeon_mu03", 0.25e-3L, 200, 0.3L}}) {
    auto scene = read_scene(test::scene_file(rig.scene));
    scene.penalty.contact = ContactLaw::exact;
    scene.run.duration = 0.02;
    scene.run.discard = 0;
    const double e = *scene.mechanism.surfaces[0].restitution;
    reference::LooseSliderCrank<long double> mechanism;
    mechanism.clearance = rig.clearance;
    mechanism.speed = reference::from_rpm(rig.rpm);
    mechanism.friction = rig.friction;
    for (const double asked : {0.05, 0.001}) {
      for (const char* formulation : {"penalty", "nonsmooth"}) {
        CAPTURE(rig.scene, asked, formulation);
        const auto advice = advise(scene, formulation, asked, cli::makers(), {});
        REQUIRE(advice.chosen >= 0);
        REQUIRE(advice.by_events);
        std::vector<ContactEvent> exact;
        if (formulation[0] == 'p') {
          reference::PenaltyContact<long double> law;
          law.stiffness = test::simulate(scene, Family::penalty).contacts[0].model.stiffness;
          law.chi = reference::exact_chi(e);
          law.friction_v0 = scene.penalty.friction_v0;
          law.friction_v1 = scene.penalty.friction_v1;
          exact = events(Oracle(mechanism).penalty(law, 0.02L));
        } else {
          exact = events(Oracle(mechanism).nonsmooth(e, 0.02L));
        }
        REQUIRE(exact.size() >= 2);
        exact.resize(std::min(exact.size(), advice.reference.touches.size()));
        auto advised = scene;
        advice.tried[advice.chosen].setting.apply(advised);
        auto found = test::touches(
            test::simulate(advised, formulation[0] == 'p' ? Family::penalty : Family::nonsmooth));
        std::erase_if(found, [](const ContactEvent& x) { return x.kind != EventKind::impact; });
        for (auto& x : exact) x.joint = 0;
        CHECK(touch_error(found, exact) <= asked);
        // And it is cheaper than the finest.
        CHECK(advice.tried[advice.chosen].work.rhs < advice.tried.back().work.rhs);
      }
    }
  }
}

TEST_CASE("--accuracy chooses settings, --set still wins, advise prints what to set", "[advice][program]") {
  test::TemporaryFolder folder;
  const auto scene = test::flores().string() + " --set run.revolutions=0.05 --set run.discard=0 -o " +
                     folder.path().string();
  long steps[3];
  int i = 0;
  for (const char* accuracy : {"fast", "balanced", "reference"}) {
    const auto o = test::freeplay("run " + scene + " --formulation penalty --accuracy " + accuracy);
    REQUIRE(o.status == 0);
    steps[i++] = std::stol(o.out.substr(o.out.find(" in ") + 4));
  }
  CHECK(steps[0] < steps[1]);
  CHECK(steps[1] < steps[2]);
  const auto o =
      test::freeplay("run " + scene + " --formulation nonsmooth --accuracy fast --set nonsmooth.step=1e-3");
  CHECK_THAT(o.out, Catch::Matchers::Contains("in 15 steps"));
  CHECK(test::freeplay("run " + scene + " --formulation penalty --accuracy quick").status == 2);
  const auto advice = test::freeplay(
      "advise " + test::flores().string() +
      " --set run.revolutions=0.05 --set run.discard=0 --set penalty.contact=exact --error 1%");
  CHECK(advice.status == 0);
  CHECK_THAT(advice.out, Catch::Matchers::Contains("--set penalty.integrator=") &&
                             Catch::Matchers::Contains("--set nonsmooth."));
}
