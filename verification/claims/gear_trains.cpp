// Gears with moving centres, and racks: transmission ratios, and the involute's relation of
// distance and angles.
#include "verification/claims/gear_claims.hpp"

#include "verification/support/runs.hpp"

namespace freeplay::verification::gear_claims {

void planet(Findings& f) {
  const auto ideal = read_scene(test::scene_file("planetary_gear"));
  std::vector<std::string> backlash;
  for (const char* mesh : {"inner", "outer"})
    for (const char* key : {"backlash=1e-4", "mesh_stiffness=2e8", "surface=steel"})
      backlash.push_back(fmt::format("joints.{}.{}", mesh, key));
  const auto loose = read_scene(test::scene_file("planetary_gear"), backlash);
  const double carrier = 30.0 * 20 / 80 * 3;
  for (const auto& way : ways) {
    auto scene = scene_by(ideal, way);
    if (way.fixed()) scene.nonsmooth.step = 1e-4;
    const auto end = test::finished(scene, way.family).final_state;
    const double bound = way.penalty() ? 1e-7 : 1e-10;
    const char* why = way.penalty() ? "drift at α = β = 5, 1e-8 m over 0.05 m at most"
                                    : "positions are projected to rounding at each step";
    const char* const subject = "planetary gear with fixed ring";
    const auto scheme = scheme_of(way, "1e-4");
    f.within(claim_name(subject, "angle of the carrier after 3 s", scheme), "rad", end.q[5], carrier, bound,
             "Willis: ω_c = ω_s z_s/(z_s + z_r)", why);
    f.within(claim_name(subject, "angle of the planet after 3 s", scheme), "rad", end.q[8], -2 * carrier,
             bound, "ω_p = ω_c (1 − z_r/z_p)", why);
  }
  for (const auto& way : ways) {
    auto scene = scene_by(loose, way);
    if (way.fixed()) scene.nonsmooth.step = 2e-5;
    scene.run.duration = 1;
    const auto end = test::finished(scene, way.family).final_state;
    // Each mesh starts in the middle of its backlash; a hundredth is added for penetration.
    f.within(claim_name("planetary gear with fixed ring and backlash", "angle of the carrier after 1 s",
                        scheme_of(way, "2e-5")),
             "rad", end.q[5], carrier / 3, (1e-4 + 1e-6) / (4 * 0.05 * std::cos(alpha)),
             "Willis: ω_c = ω_s z_s/(z_s + z_r)",
             "half the backlash of both meshes: 2 (b/2)/(r_b (z_s + z_r)/z_s), and a hundredth");
  }
}

void distance(Findings& f) {
  const auto moving = read_scene(test::scene_file("gears_with_moving_centre"));
  const long double S = 0.15L * std::cos(20 * M_PIl / 180);
  for (const auto& way : ways) {
    auto scene = scene_by(moving, way);
    if (way.fixed()) scene.nonsmooth.step = 1e-4;
    if (way.penalty()) scene.penalty.tolerance = 1e-12;
    double worst = 0;
    std::vector<double> q(9), v(9);
    double least = 1, most = 0;
    Simulation simulation(scene, test::name_of(way.family));
    const auto run = test::watch_steps(simulation, [&](const Step& step) {
      step.state(step.t1, q, v);
      const long double a = q[6];
      least = std::min(least, q[6]), most = std::max(most, q[6]);
      const long double turned = S / 3 * q[2] + 2 * S / 3 * q[8];
      worst = greatest(worst,
                       double(std::abs(turned - reference::involute(S, a) + reference::involute(S, 0.151L))));
    });
    const auto name = [&](const char* quantity) {
      return claim_name("gear pair with oscillating centre distance", quantity, scheme_of(way, "1e-4"));
    };
    f.at_most(
        name("S inv α = r₁ θ₁ + r₂ θ₂, greatest error"), "m", worst, way.penalty() ? 1e-9 : 1e-12,
        "the involute function",
        way.penalty() ? "drift at α = β = 5, as of all joints" : "positions are projected at each step");
    f.between(name("range of the centre distance"), "m", most - least, 5e-4, 0.01, "",
              "amplitude 0.05 m/s over 100 rad/s: the centre moves");
    const auto& l = run.ledger;
    f.at_most(
        name("relative change of energy in 0.5 s"), "", std::abs((l.kinetic + l.potential) / l.initial - 1),
        way.fixed() ? 2e-4 : 1e-7, "0: no force does work",
        way.fixed() ? "the energy of the midpoint rule oscillates by (ω h)² with the spring, margin of two"
                    : "tolerance in some thousand steps");
  }
}

namespace {

std::string rack(const std::string& mesh, const std::string& more) {
  return test::body("pinion", 1.0, 0.001, "angular_velocity = 10.0\n") +
         test::body("bar", 2.0, 0.004, "position = [0.3, -0.05]\n") + test::pin("front", "ground", "pinion") +
         test::guide("guide", "ground", "bar", {1, 0}, {0.0, -0.05}) + R"([joints.mesh]
type = "rack"
between = ["pinion", "bar"]
pitch_radius = 0.05
module = 5e-3
)" + mesh +
         test::surface("steel", 0.6) + more;
}

}  // namespace

void racks(Findings& f) {
  const double r = 0.05, base = r * std::cos(alpha), e = 0.6;
  // The bar's effective mass along the line of action is m/cos²α.
  const double mass = 1 / (base * base / 0.001 + std::cos(alpha) * std::cos(alpha) / 2.0);
  const auto exact = reference::bounces(0.5e-4, 1e-4, 10 * base, e, mass, 5);
  const double flight = 1e-4 / (10 * base * std::pow(e, 5)), M = 2.0, a = M / r / (0.001 / (r * r) + 2.0);
  for (const auto& way : ways) {
    auto scene = scene_by(rack(loose_teeth, "[run]\nduration = 1\nstart = \"given\"\n"), way);
    scene.run.duration = exact.back().t + 0.5 * flight;
    impacts(f, "gear and rack with backlash, rattling", way, scheme_of(way, "1e-6"),
            test::finished(scene, way.family), exact, e);
    scene = scene_by(
        rack("",
             fmt::format(
                 "[loads.a]\ntype = \"torque\"\nbody = \"pinion\"\ntorque = {}\n[run]\nduration = 0.1\n", M)),
        way);
    if (way.fixed()) scene.nonsmooth.step = 1e-5;
    const auto end = test::finished(scene, way.family).final_state;
    const double bound = way.penalty() ? 1e-8 : 1e-11;
    const char* const subject = "ideal gear and rack under a torque";
    const auto scheme = scheme_of(way, "1e-5");
    f.within(claim_name(subject, "speed of the rack after 0.1 s", scheme), "m/s", end.v[3], r * end.v[2],
             bound, "v = r ω",
             way.penalty() ? "drift of velocities at α = β = 5"
                           : "velocity constraints are met at the end of every step");
    scene.run.duration = 0.001;
    const auto at = force_of(scene, way.family, "front");
    f.at_most(claim_name(subject, "force of the gear's bearing, relative error", scheme), "",
              std::hypot(at.fx - 2 * a, at.fy + 2 * a * std::tan(alpha)) / (2 * a), way.fixed() ? 1e-7 : 1e-9,
              "m a along the rack and m a tan α across it", "rounding: the forces are constant");
  }
}

}  // namespace freeplay::verification::gear_claims
