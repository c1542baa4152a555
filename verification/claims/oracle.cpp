// Both formulations against the paper's scene re-derived by hand in two coordinates and integrated in long
// double (verification/references/slider_crank_oracle.hpp), which shares no code with the solvers; and impact
// laws against results by hand.
#include <fmt/format.h>

#include "dynamics/assembly/assembly.hpp"
#include "mechanism/scene.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/delivered_restitution.hpp"
#include "verification/references/impact_tables.hpp"
#include "verification/references/slider_crank_oracle.hpp"
#include "verification/support/support.hpp"

namespace freeplay::verification {

namespace {

using Long = long double;
using Impacts = std::vector<reference::OracleImpact<Long>>;

/// The first `count` touches of a run against the oracle's.
void touches(Findings& f, const std::string& name, const Result& found, const Impacts& exact,
             std::size_t count, double time) {
  const auto horizon = fmt::format("of {}, to {:.1f} ms", count, 1e3 * double(exact.at(count - 1).t));
  for (std::size_t i = 0; i < count; ++i) {
    const auto& e = exact[i];
    const auto touch = test::touch(found, i);
    f.within(fmt::format("{}, touch {} {}", name, i + 1, horizon), "s", touch.t, double(e.t), time,
             "oracle in long double", "tolerance 1e-12 a step, positions over speeds");
    const auto relative = [&](const char* what, const char* unit, double measured, Long expected) {
      f.relative(what, unit, measured, double(expected), 1e-6, "the same",
                 "errors grow up to tenfold an impact");
    };
    relative("its approach speed", "m/s", touch.v_n_minus, e.v_n_minus);
    relative("its impulse", "N s", touch.impulse_n, e.impulse_n);
    relative("its tangential impulse", "N s", touch.impulse_t, e.impulse_t);
    relative("the gap's rate after it", "m/s", touch.v_n_plus, e.v_n_plus);
    relative("the sliding speed after it", "m/s", touch.v_t_plus, e.v_t_plus);
  }
}

/// Moreau–Jean at the step h places the first touch within h. One that is δ late makes the next (1 + 2e) δ
/// late by the speed it leaves with, and (v/v′) h/2 by leaving up to half a step's way off the wall: together
/// less than four times as late.
void time_stepping(Findings& f, Scene scene, const Impacts& exact) {
  constexpr std::size_t count = 3;
  const double h = 1e-6;
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  scene.nonsmooth.step = h;
  const auto found = test::simulate(scene, Family::nonsmooth);
  double late = h;  // s
  for (std::size_t i = 0; i < count; ++i, late *= 4) {
    const auto& e = exact.at(i);
    const auto touch = test::touch(found, i);
    f.within(fmt::format("Moreau–Jean at h = 1e-6 s, touch {} of {}, to {:.1f} ms", i + 1, count,
                         1e3 * double(exact.at(count - 1).t)),
             "s", touch.t, double(e.t), late, "oracle in long double", "h, and four times more an impact");
    f.within("its approach speed", "m/s", touch.v_n_minus, double(e.v_n_minus), 50 * late, "the same",
             "that late at 50 m/s², twice the ideal slider's ω² r (1 + r/l)");
    f.within("its impulse", "N s", touch.impulse_n, double(e.impulse_n), 75 * late, "the same",
             "that speed times (1 + e) m = 1.5 kg");
  }
}

}  // namespace

Findings oracle() {
  Findings f;
  auto scene = read_scene(test::flores());
  scene.run.duration = 0.0119;
  scene.run.discard = 0;
  scene.instruments.clear();
  scene.penalty.tolerance = 1e-12;
  scene.nonsmooth.scheme = Scheme::event_driven;
  scene.nonsmooth.tolerance = 1e-12;
  reference::LooseSliderCrank<Long> mechanism;
  mechanism.friction = 0.01L;
  const reference::SliderCrankOracle<Long> solver(mechanism);
  const auto nonsmooth = solver.nonsmooth(0.46L, 0.0119L);
  touches(f, "event-driven", test::simulate(scene, Family::nonsmooth), nonsmooth.impacts, 6, 1e-11);
  time_stepping(f, scene, nonsmooth.impacts);
  const auto compliant = [&](const char* name, ContactLaw contact, Long chi) {
    scene.penalty.contact = contact;
    const Long outer = mechanism.bearing_radius, inner = outer - mechanism.clearance;
    reference::PenaltyContact<Long> law;  // K = (4/3) E/(2(1 − ν²)) √(R_i R_j/(R_i − R_j))
    law.stiffness = 4.0L / 3 * 207e9L / (2 * (1 - 0.09L)) * std::sqrt(outer * inner / mechanism.clearance);
    law.chi = chi;
    touches(f, name, test::simulate(scene, Family::penalty), solver.penalty(law, 0.0119L).impacts, 2, 1e-10);
  };
  compliant("penalty", ContactLaw::exact, reference::exact_chi(0.46L));
  compliant("penalty, Lankarani–Nikravesh", ContactLaw::lankarani_nikravesh, 0.75L * (1 - 0.46L * 0.46L));
  return f;
}

Findings impact_laws() {
  Findings f;
  auto scene = read_scene(test::scene_file("kane_levinson"));
  scene.run.duration = 1e-6;
  const auto kinetic = [&](const State& s) { return test::kinetic_energy(scene, s); };
  const double before = kinetic(assemble(scene.mechanism, scene.run.start));
  const auto claim = [&](ImpactLaw law, const char* name, double e, double ratio) {
    scene.nonsmooth.impact_law = law;
    scene.mechanism.surfaces[0].restitution = e;
    f.relative(fmt::format("Kane and Levinson's pendulum, e = {}, energy after over before, {}", e, name), "",
               kinetic(test::simulate(scene, Family::nonsmooth).final_state) / before, ratio, 1e-9,
               "independent program", "rounding");
  };
  for (const auto& row : reference::kane_levinson) {
    claim(ImpactLaw::newton, "Newton", row.e, row.newton);
    claim(ImpactLaw::poisson, "Poisson", row.e, row.poisson);
    claim(ImpactLaw::energetic, "energetic", row.e, row.energetic);
  }
  auto cradle = read_scene(test::scene_file("cradle"));
  const auto end = test::simulate(cradle, Family::nonsmooth).final_state;
  f.within("three balls, e = 1: the first one after", "m/s", end.v[0], -1.0 / 3, 1e-12, "by hand",
           "rounding");
  f.within("the other two", "m/s", end.v[6], 2.0 / 3, 1e-12, "by hand", "rounding");
  return f;
}

}  // namespace freeplay::verification
