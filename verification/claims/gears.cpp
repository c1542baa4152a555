// Gear pairs: rattle, and reactions along the line of action. Also the ways to run the scenes of
// the whole set.
#include "verification/claims/gear_claims.hpp"

#include "verification/support/runs.hpp"

namespace freeplay::verification::gear_claims {

const std::array<Way, 4> ways{
    Way{test::penalty, 1e-6,
        "the exact law delivers e at any stiffness; tolerance 1e-10 in some ten steps of a contact"},
    Way{test::fixed_steps(1e-6), 1e-11, "rounding: no force between impacts"},
    Way{test::event_driven, 1e-11, "rounding: no force between impacts"},
    Way{test::automatic, 1e-11, "rounding: no force between impacts"}};

Scene scene_by(Scene scene, const Way& way) {
  way.choose(scene);
  scene.penalty.contact = ContactLaw::exact;
  scene.penalty.tolerance = 1e-10;
  return scene;
}
Scene scene_by(const std::string& text, const Way& way) {
  return scene_by(parse_scene("format = 2\n" + text, "gears"), way);
}

std::string scheme_of(const Way& way, const char* step) {
  return way.fixed() ? fmt::format("Moreau–Jean, h = {} s", step) : way.name;
}

void impacts(Findings& f, const char* subject, const Way& way, const std::string& scheme, const Result& run,
             const std::vector<reference::BounceImpact>& exact, double e) {
  const auto found = test::touches(run);
  double off = found.size() == exact.size() ? 0 : NAN, late = 0, reported = 0;
  for (std::size_t k = 0; k < found.size() && k < exact.size(); ++k) {
    off = greatest(off, std::abs(found[k].impulse_n / exact[k].impulse - 1));
    off = greatest(off, std::abs(-found[k].v_n_minus / exact[k].approach - 1));
    reported += way.fixed() ? way.step : found[k].t_uncertainty;
    const double rounding = 1e-15 * static_cast<double>(k + 1) / exact.back().approach;
    late = greatest(late, std::abs(found[k].t - exact[k].t) / ((1 + 1 / e) * reported + rounding));
  }
  f.at_most(claim_name(subject,
                       fmt::format("approach speeds and impulses of {} impacts, greatest relative error",
                                   exact.size()),
                       scheme),
            "", off, way.speeds, "Newton's impact law", way.reason);
  if (way.family == Family::nonsmooth)
    f.at_most(
        claim_name(subject,
                   fmt::format("times of {} impacts, greatest error over reported uncertainty", exact.size()),
                   scheme),
        "", late, 1, "uniform motion between impacts",
        "sum of the reported uncertainties (Moreau–Jean: a step each); "
        "an impact δ late delays the next by δ (1 + 1/e); "
        "rounding of lengths below 1 m, 1e-15 m over the slowest speed");
}

ElementForce force_of(const Scene& scene, Family family, const std::string& name) {
  Simulation simulation(scene, test::name_of(family));
  const auto& elements = simulation.layout().forces;
  ElementForce found;
  int steps = 0;
  Forces now;
  test::watch_steps(simulation, [&](const Step& step) {
    if (++steps > 3) return;
    step.forces(0.5 * (step.t0 + step.t1), now);
    for (std::size_t k = 0; k < elements.size(); ++k)
      if (elements[k].name == name) found = now.elements[k];
  });
  return found;
}

namespace {

std::string pair_of_gears(const std::string& mesh, const std::string& more) {
  return test::body("pinion", 1.0, 0.001, "angular_velocity = 10.0\n") +
         test::body("wheel", 2.0, 0.004, "position = [0.15, 0.0]\n") +
         test::pin("front", "ground", "pinion") + test::pin("rear", "ground", "wheel", {0.15, 0.0}) +
         R"([joints.mesh]
type = "gear"
between = ["pinion", "wheel"]
teeth = [20, 40]
module = 5e-3
)" + mesh +
         test::surface("steel", 0.6) + more;
}

}  // namespace

void rattle(Findings& f) {
  const double r1 = 0.05 * std::cos(alpha), r2 = 0.1 * std::cos(alpha), e = 0.6;
  const reference::GearPair gears{0.001, 0.004, r1, r2};
  const auto exact = reference::bounces(0.5e-4, 1e-4, 10 * r1, e, gears.mass(), 5);
  const double flight = 1e-4 / (10 * r1 * std::pow(e, 5));
  for (const auto& way : ways) {
    auto scene = scene_by(pair_of_gears(loose_teeth, "[run]\nduration = 1\nstart = \"given\"\n"), way);
    scene.run.duration = exact.back().t + 0.5 * flight;
    const auto run = test::finished(scene, way.family);
    const char* const subject = "gear pair with backlash, rattling";
    const auto scheme = scheme_of(way, "1e-6");
    impacts(f, subject, way, scheme, run, exact, e);
    // P alternates between the flanks.
    double sum = 0;
    for (std::size_t k = 0; k < exact.size(); ++k) sum += (k % 2 == 0 ? 1 : -1) * exact[k].impulse;
    f.relative(claim_name(subject, "angular velocity of the pinion after 5 impacts", scheme), "rad/s",
               run.final_state.v[2], 10 - r1 * sum / gears.J1, 10 * way.speeds, "ω₁ − Σ ± r₁ P/J₁",
               "bound of an impact, margin of ten for five");
    f.relative(claim_name(subject, "angular velocity of the wheel after 5 impacts", scheme), "rad/s",
               run.final_state.v[5], -r2 * sum / gears.J2, 10 * way.speeds, "−Σ ± r₂ P/J₂",
               "bound of an impact, margin of ten for five");
  }
}

void reactions(Findings& f) {
  const double r1 = 0.05 * std::cos(alpha), r2 = 0.1 * std::cos(alpha);
  for (const int side : {1, -1}) {
    const double M1 = 3.0 * side, M2 = 1.0 * side;
    // r₁ ω₁ + r₂ ω₂ = 0: J₁ α₁ = M₁ − s r₁ F, J₂ α₂ = M₂ − s r₂ F.
    const double F = side * (r1 * M1 / 0.001 + r2 * M2 / 0.004) / (r1 * r1 / 0.001 + r2 * r2 / 0.004);
    for (const auto& way : ways) {
      auto scene = scene_by(
          pair_of_gears(
              side > 0 ? "" : "flank = \"backward\"\n",
              fmt::format("[loads.a]\ntype = \"torque\"\nbody = \"pinion\"\ntorque = {}\n[loads.b]\ntype = "
                          "\"torque\"\nbody = \"wheel\"\ntorque = {}\n[run]\nduration = 0.01\n",
                          M1, M2)),
          way);
      const auto at = force_of(scene, way.family, "front"), mesh = force_of(scene, way.family, "mesh");
      const double bound = way.fixed() ? 1e-7 : 1e-9;
      const char* why = way.fixed() ? "rounding of velocities, 1e-15 m/s, over a step, margin of 100"
                                    : "rounding over steps of 1e-4 s: the forces are constant";
      const auto off = [&](const ElementForce& e, double fx, double fy) {
        return std::hypot(e.fx - fx, e.fy - fy) / F;
      };
      const auto name = [&](const char* quantity) {
        return claim_name(
            fmt::format("ideal gear pair under torques, {} flank", side > 0 ? "forward" : "backward"),
            quantity, scheme_of(way, "1e-6"));
      };
      f.at_most(name("force of the mesh on the wheel, relative error"), "",
                off(mesh, F * std::sin(alpha), side * F * std::cos(alpha)), bound,
                "Newton–Euler equations, force along the line of action", why);
      f.at_most(name("force of the pinion's bearing, relative error"), "",
                off(at, F * std::sin(alpha), side * F * std::cos(alpha)), bound,
                "the pinion's centre is fixed: opposite of the mesh force", why);
    }
  }
}

}  // namespace freeplay::verification::gear_claims

namespace freeplay::verification {

Parts gears() {
  using namespace gear_claims;
  return {rattle, reactions, planet, distance, racks, slots, stops, bumps};
}

}  // namespace freeplay::verification
