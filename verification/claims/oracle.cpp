// Both formulations against an independent derivation of the paper's slider-crank: two coordinates,
// integrated in long double, no code shared with the solvers
// (verification/references/slider_crank_oracle.hpp). Also impact laws against independent results.
#include "dynamics/assembly/assembly.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/delivered_restitution.hpp"
#include "verification/references/impact_tables.hpp"
#include "verification/references/slider_crank_oracle.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {

namespace {

using Long = long double;
using Impacts = std::vector<reference::OracleImpact<Long>>;

constexpr const char* subject = "paper's slider-crank with clearance";
constexpr const char* source = "independent derivation in long double";

/// Claims on the first `count` impacts of a run by `scheme`.
void touches(Findings& f, const char* scheme, const Result& found, const Impacts& exact, std::size_t count,
             double time) {
  for (std::size_t i = 0; i < count; ++i) {
    const auto& e = exact[i];
    const auto touch = test::touch(found, i);
    f.within(claim_name(subject, fmt::format("time of impact {}", i + 1), scheme), "s", touch.t, double(e.t),
             time, source, "tolerance 1e-12 per step, error of positions over speed");
    const auto relative = [&](const char* what, const char* unit, double measured, Long expected) {
      f.relative(claim_name(subject, fmt::format("{} of impact {}", what, i + 1), scheme), unit, measured,
                 double(expected), 1e-6, source, "errors grow up to tenfold per impact");
    };
    relative("approach speed", "m/s", touch.v_n_minus, e.v_n_minus);
    relative("normal impulse", "N s", touch.impulse_n, e.impulse_n);
    relative("tangential impulse", "N s", touch.impulse_t, e.impulse_t);
    relative("separation speed", "m/s", touch.v_n_plus, e.v_n_plus);
    relative("sliding speed at the end", "m/s", touch.v_t_plus, e.v_t_plus);
  }
}

/// Moreau–Jean with step h resolves the first impact within h. An impact δ late delays the next by
/// (1 + 2e) δ through its rebound speed, and by (v/v′) h/2 since the contact separates up to half a
/// step's travel away from the wall: together less than 4 δ.
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
    const auto name = [&](const char* what) {
      return claim_name(subject, fmt::format("{} of impact {}", what, i + 1), "Moreau–Jean, h = 1e-6 s");
    };
    f.within(name("time"), "s", touch.t, double(e.t), late, source, "h, times four per further impact");
    f.within(name("approach speed"), "m/s", touch.v_n_minus, double(e.v_n_minus), 50 * late, source,
             "bound of the time × 50 m/s², twice the ideal slider's ω² r (1 + r/l)");
    f.within(name("normal impulse"), "N s", touch.impulse_n, double(e.impulse_n), 75 * late, source,
             "bound of the speed × (1 + e) m = 1.5 kg");
  }
}

void first_impacts(Findings& f) {
  auto scene = test::read_short(test::flores(), 0.0119);
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
  compliant("penalty, exact law", ContactLaw::exact, reference::exact_chi(0.46L));
  compliant("penalty, Lankarani–Nikravesh", ContactLaw::lankarani_nikravesh, 0.75L * (1 - 0.46L * 0.46L));
}

void two_impacts(Findings& f) {
  auto scene = read_scene(test::scene_file("kane_levinson"));
  scene.run.duration = 1e-6;
  const auto kinetic = [&](const State& s) { return test::kinetic_energy(scene, s); };
  const double before = kinetic(assemble(scene.mechanism, scene.run.start));
  const auto claim = [&](ImpactLaw law, const char* name, double e, double ratio) {
    scene.nonsmooth.impact_law = law;
    scene.mechanism.surfaces[0].restitution = e;
    f.relative(claim_name(fmt::format("Kane and Levinson's pendulum, e = {}", e),
                          "kinetic energy after over before the impact", name),
               "", kinetic(test::simulate(scene, Family::nonsmooth).final_state) / before, ratio, 1e-9,
               "independent program that enumerates cases", "rounding");
  };
  for (const auto& row : reference::kane_levinson) {
    claim(ImpactLaw::newton, "Newton", row.e, row.newton);
    claim(ImpactLaw::poisson, "Poisson", row.e, row.poisson);
    claim(ImpactLaw::energetic, "energetic", row.e, row.energetic);
  }
  auto cradle = read_scene(test::scene_file("cradle"));
  const auto end = test::simulate(cradle, Family::nonsmooth).final_state;
  f.within("row of three balls, e = 1: velocity of the 1st ball after the impact [Newton]", "m/s", end.v[0],
           -1.0 / 3, 1e-12, "Newton's law at both contacts simultaneously", "rounding");
  f.within("row of three balls, e = 1: velocity of the 3rd ball after the impact [Newton]", "m/s", end.v[6],
           2.0 / 3, 1e-12, "Newton's law at both contacts simultaneously", "rounding");
}

}  // namespace

Parts oracle() { return {first_impacts}; }
Parts impact_laws() { return {two_impacts}; }

}  // namespace freeplay::verification
