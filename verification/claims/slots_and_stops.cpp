// Pins in slots, end stops and bump stops: free flight, impacts, and the reactions of joints to
// impacts.
#include "verification/claims/gear_claims.hpp"

#include "verification/support/runs.hpp"

namespace freeplay::verification::gear_claims {

void slots(Findings& f) {
  const double r = 0.05, w = 20, phi = 0.7, c = 1e-4;
  const auto ideal = read_scene(test::scene_file("scotch_yoke")),
             loose = read_scene(
                 test::scene_file("scotch_yoke"),
                 {"joints.pin.clearance=1e-4", "joints.pin.pin_radius=8e-3", "joints.pin.surface=steel"});
  const double t = reference::pin_flight(r, w, phi, c, 0.04);
  const double approach = r * w * std::abs(std::sin(phi + w * t) - std::sin(phi));
  for (const auto& way : ways) {
    auto scene = scene_by(loose, way);
    scene.run.duration = t + 3e-3;  // the whole contact, under a contact law
    const auto touch = test::touch(test::finished(scene, way.family), 0);
    const bool stepped = way.fixed(), chosen = way.scheme == Scheme::automatic;
    const auto name = [&](const char* quantity) {
      return claim_name("Scotch yoke with clearance at the pin", quantity, scheme_of(way, "1e-6"));
    };
    f.within(name("time of 1st impact"), "s", touch.t, t,
             stepped  ? way.step
             : chosen ? touch.t_uncertainty + 1e-9
                      : 1e-9,
             "uniform motion of the yoke against r cos φ of the pin",
             stepped  ? "step h"
             : chosen ? "reported uncertainty"
                      : "tolerance 1e-10 in some tens of steps");
    f.relative(name("approach speed of 1st impact"), "m/s", -touch.v_n_minus, approach,
               stepped || chosen ? 1e-4 : 1e-7, "r ω |sin(φ + ω t) − sin φ|",
               stepped  ? "r ω² h"
               : chosen ? "r ω² times the reported uncertainty"
                        : "tolerance");
    if (way.family == Family::nonsmooth)
      f.relative(name("impulse of 1st impact"), "N s", touch.impulse_n, 1.6 * 2.0 * -touch.v_n_minus,
                 stepped || chosen ? 1e-4 : 1e-9, "(1 + e) m u: the crank is driven",
                 stepped || chosen ? "force within the step of the impact" : "rounding");
    scene = scene_by(ideal, way);
    if (way.fixed()) scene.nonsmooth.step = 1e-5;
    const auto end = test::finished(scene, way.family).final_state;
    const double angle = phi + w * 0.1;
    f.within(claim_name("ideal Scotch yoke", "yoke position after 0.1 s", scheme_of(way, "1e-5")), "m",
             end.q[3], r * std::cos(angle), way.penalty() ? 1e-9 : 1e-11, "x = r cos φ",
             way.penalty() ? "drift at α = β = 5" : "positions are projected at each step");
  }
}

void stops(Findings& f) {
  const std::string slide =
      test::body("block", 2.0, 0.01, "velocity = [1.5, 0.0]\n") + test::guide("guide", "ground", "block") +
      test::stop("end", "travel-stop", "guide", "lower = -0.1\nupper = 0.2\nstiffness = 1e11\n", "rubber") +
      test::surface("rubber", 0.7) + test::run_for(1, "start = \"given\"\n");
  const double e = 0.7;
  const auto exact = reference::bounces(0.2, 0.3, 1.5, e, 2.0, 4);
  for (const auto& way : ways) {
    auto scene = scene_by(slide, way);
    scene.run.duration = exact.back().t + 0.1;
    if (way.fixed()) scene.nonsmooth.step = 1e-4;
    auto by = way;
    if (by.step > 0) by.step = 1e-4;
    impacts(f, "block between end stops", by, scheme_of(way, "1e-4"), test::finished(scene, way.family),
            exact, e);
  }
  // A rod on a pin against a stop, at its centre of percussion and nearer to the pin: the impulse
  // of the pin.
  const double l = 0.1, Jc = 0.01, JO = Jc + l * l, w = 10, limit = 0.5, er = 0.6, T = 0.06;
  for (const double radius : {JO / l, 0.05}) {
    const auto text =
        test::body("rod", 1.0, 0.01,
                   "position = [0.1, 0.0]\nvelocity = [0.0, 1.0]\nangular_velocity = 10.0\n") +
        test::pin("pin", "ground", "rod", {}, {-0.1, 0.0}) +
        test::stop("stop", "angle-stop", "pin",
                   fmt::format("upper = 0.5\nradius = {}\ndirection = 0.5\nstiffness = 1e12\n", radius),
                   "steel") +
        test::surface("steel", 0.6) + test::run_for(0.06, "start = \"given\"\n");
    for (const auto& way : ways) {
      auto scene = scene_by(text, way);
      if (way.fixed()) scene.nonsmooth.step = 1e-5;
      Simulation simulation(scene, test::name_of(way.family));
      const auto& elements = simulation.layout().forces;
      Forces sum;
      sum.elements.resize(elements.size());
      sum.acceleration.resize(3);
      const auto run = test::watch_steps(simulation, [&](const Step& step) {
        sum.add(1, step.before());
        step.add_impulse(step.t0, step.t1, sum);
        sum.add(1, step.within());
      });
      const auto touch = test::touch(run, 0);
      ElementForce pin;
      for (std::size_t k = 0; k < elements.size(); ++k)
        if (elements[k].name == "pin") pin = sum.elements[k];
      const auto name = [&](const char* quantity) {
        return claim_name(fmt::format("rod on a pin against a stop at {:.3g} m", radius), quantity,
                          scheme_of(way, "1e-5"));
      };
      const double bound = way.penalty() ? 1e-6 : way.fixed() ? 1e-6 : 1e-9;
      f.relative(name("angular velocity after the impact"), "rad/s", run.final_state.v[2], -er * w, bound,
                 "−e ω",
                 way.penalty() ? "the exact law delivers e; drift"
                 : way.fixed() ? "velocities at the end of a step: (ω h)², margin of 100"
                               : "tolerance");
      f.within(name("time of the impact"), "s", touch.t, limit / w, way.fixed() ? 1e-5 : 1e-8,
               "constant speed", way.fixed() ? "step h" : "tolerance");
      // The pin's impulse is the change of momentum of the rod less the stop's impulse, which acts
      // along −perp c.
      const double P = JO * (1 + er) * w / radius, end = limit - er * (w * T - limit);
      const double px = l * (er * w * std::sin(end)), py = l * (-er * w * std::cos(end) - w);
      const double bx = px - P * std::sin(limit), by = py + P * std::cos(limit);
      const double scale = l * w * (1 + er);
      f.at_most(name("impulse of the pin, error over m l Δω"), "",
                std::hypot(pin.fx - bx, pin.fy - by) / scale,
                way.penalty() ? 2e-3
                : way.fixed() ? 2e-3
                              : 1e-8,
                "momentum of the rod",
                way.family == Family::nonsmooth && way.step == 0
                    ? "tolerance"
                    : "rotation during a step or a contact, 1e-5 s × 10 rad/s, times P over m l Δω, 10, "
                      "margin of two");
    }
  }
}

/// m ÿ + c ẏ + k y = 0 until the force is zero; the force cannot pull.
void bumps(Findings& f) {
  const double k = 2e4, m = 2.0, zeta = 0.3, w0 = std::sqrt(k / m), s = std::sqrt(1 - zeta * zeta), v = 1.5;
  const double lasts = std::atan2(2 * zeta * s, 2 * zeta * zeta - 1) / (s * w0),
               rebound = v * std::exp(-zeta * w0 * lasts);
  const auto buffered = read_scene(test::scene_file("bump_stops"));
  for (const auto& way : ways) {
    const auto run = test::finished(scene_by(buffered, way), way.family);
    const auto& end = run.final_state;
    const bool stepped = way.fixed(), chosen = way.scheme == Scheme::automatic;
    const double bound = stepped ? 1e-4 : chosen ? 1e-4 : 1e-7;
    const char* why = stepped  ? "the force begins within a step: ζ ω₀ h = 3e-5, margin of three"
                      : chosen ? "step tolerance 1e-6, some tens of steps at the jump of the force"
                               : "tolerance 1e-10 per step, some hundred steps at the jump of the force";
    const auto scheme = scheme_of(way, "1e-6");
    const char *linear = "bump stop, ζ = 0.3", *torsional = "torsional bump stop, ζ = 0.3";
    f.relative(claim_name(linear, "rebound velocity", scheme), "m/s", end.v[0], -rebound, bound,
               "v exp(−ζ ω₀ t), t where the force is zero", why);
    f.relative(claim_name(torsional, "rebound angular velocity", scheme), "rad/s", end.v[2], -rebound, bound,
               "v exp(−ζ ω₀ t), t where the force is zero", why);
    f.within(claim_name(linear, "position after 0.1 s", scheme), "m", end.q[0],
             0.02 - v * std::exp(-zeta * w0 * lasts) * std::sin(s * w0 * lasts) / (s * w0) * -1 -
                 rebound * (0.1 - 0.02 / v - lasts),
             0.1 * bound, "y(t) = (v/ω_d) e^{−ζω₀t} sin ω_d t, then free", why);
    f.at_most(
        claim_name("bump stops, ζ = 0.3", "error of the energy balance over the initial energy", scheme), "",
        std::abs(run.ledger.closure()) / run.ledger.initial, bound,
        "energy balance with ½ k y² and the damper's work", why);
  }
}

}  // namespace freeplay::verification::gear_claims
