// Both formulations against the paper's scene re-derived by hand in two coordinates and integrated in long
// double (verification/references/slider_crank_oracle.hpp), which shares no code with the solvers; and impact
// laws against results by hand.
#include <fmt/format.h>

#include "verification/claims/claim.hpp"
#include "verification/references/delivered_restitution.hpp"
#include "verification/references/slider_crank_oracle.hpp"
#include "verification/support.hpp"

namespace freeplay::verification {

Findings oracle() {
  using Long = long double;
  Findings f;
  auto scene = read_scene(test::flores());
  scene.run.duration = 0.0119;
  scene.run.discard = 0;
  scene.instruments.clear();
  scene.penalty.contact = ContactLaw::exact;
  scene.penalty.tolerance = 1e-12;
  scene.nonsmooth.scheme = Scheme::event_driven;
  scene.nonsmooth.tolerance = 1e-12;
  reference::LooseSliderCrank<Long> mechanism;
  mechanism.friction = 0.01L;
  const reference::SliderCrankOracle<Long> solver(mechanism);
  const auto claim = [&](const char* name, const RunSummary& found,
                         const std::vector<reference::OracleImpact<Long>>& exact, std::size_t count,
                         double time) {
    for (std::size_t i = 0; i < count; ++i) {
      const auto& e = exact.at(i);
      const auto touch = test::touch(found, i);
      f.within(fmt::format("{}, touch {}", name, i + 1), "s", touch.t, double(e.t), time,
               "oracle in long double", "tolerance 1e-12 a step, positions over speeds");
      f.relative("its approach speed", "m/s", touch.v_n_minus, double(e.v_n_minus), 1e-6, "the same",
                 "errors grow up to tenfold an impact");
      f.relative("its impulse", "N s", touch.impulse_n, double(e.impulse_n), 1e-6, "the same", "as above");
    }
  };
  const auto nonsmooth = solver.nonsmooth(0.46L, 0.0119L);
  claim("event-driven", test::simulate(scene, Family::nonsmooth), nonsmooth.impacts, 6, 1e-11);
  const auto run = test::simulate(scene, Family::penalty);
  reference::PenaltyContact<Long> law;
  law.stiffness = run.contacts[0].model.stiffness;
  law.chi = reference::exact_chi(0.46L);
  const auto penalty = solver.penalty(law, 0.0119L);
  claim("penalty", run, penalty.impacts, 2, 1e-10);
  return f;
}

Findings impact_laws() {
  Findings f;
  const struct {
    ImpactLaw law;
    const char* name;
    double ratio;
  } rows[] = {{ImpactLaw::newton, "Newton", 2.757611078697394},
              {ImpactLaw::poisson, "Poisson", 0.5708817108903891},
              {ImpactLaw::energetic, "energetic", 0.6000916942651053}};
  auto scene = read_scene(test::scene_file("kane_levinson"));
  scene.run.duration = 1e-6;
  const auto kinetic = [&](const State& s) { return System(scene.mechanism).kinetic(s.v.data()); };
  const double before = kinetic(assemble(scene.mechanism, scene.run.start));
  for (const auto& row : rows) {
    scene.nonsmooth.impact_law = row.law;
    f.relative(fmt::format("Kane and Levinson's pendulum, energy after over before, {}", row.name), "",
               kinetic(test::simulate(scene, Family::nonsmooth).final_state) / before, row.ratio, 1e-9,
               "independent program, all cases enumerated", "rounding");
  }
  auto cradle = read_scene(test::scene_file("cradle"));
  const auto end = test::simulate(cradle, Family::nonsmooth).final_state;
  f.within("three balls, e = 1: the first one after", "m/s", end.v[0], -1.0 / 3, 1e-12, "by hand",
           "rounding");
  f.within("the other two", "m/s", end.v[6], 2.0 / 3, 1e-12, "by hand", "rounding");
  return f;
}

}  // namespace freeplay::verification
