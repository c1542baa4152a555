// Freewheels: refusals of the reader, overrunning, holding and slipping in closed form, intermittent feed,
// impacts, and a wheel driven by a harmonic torque against an integration between located events (order 8,
// tolerance 1e-13, in Python).
#include "io/scene/write_scene.hpp"
#include "verification/property/comparison/snapshot_check.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

const test::Way by_penalty{
    "penalty", Family::penalty, {}, 0, {"penalty.integrator=\"rosenbrock4\"", "penalty.tolerance=1e-10"}};
const test::Way ways[] = {by_penalty, test::event_driven, test::fixed_steps(1e-4), test::chosen_steps,
                          test::automatic};

std::string freewheel(const std::string& first, const std::string& second, const std::string& keys) {
  return fmt::format(
      "[loads.clutch]\ntype = \"freewheel\"\nbetween = [\"{}\", \"{}\"]\nregularisation = 1e-5\n{}", first,
      second, keys);
}
std::string torque(const std::string& body, double torque, const std::string& keys = "") {
  return fmt::format("[loads.push]\ntype = \"torque\"\nbody = \"{}\"\ntorque = {}\n{}", body, torque, keys);
}
/// A wheel of 0.01 kg m² on a backstop of 0.2 N m: the ground lets it turn counter-clockwise.
std::string backstop(double spin, double duration, const std::string& more = "") {
  return test::body("b", 1, 0.01, fmt::format("angular_velocity = {}\n", spin)) +
         test::pin("j", "ground", "b") + freewheel("ground", "b", "torque_limit = 0.2\n") + more +
         test::run_for(duration);
}
/// A shaft of 0.01 kg m² under 0.2 N m sin(4π t), whose freewheel drives a wheel of 0.05 kg m² with a drag
/// of 0.02 N m s; side −1: the mirror image.
std::string ratchet(double capacity, double side, double duration) {
  return test::body("a", 1, 0.01) + test::body("b", 1, 0.05) + test::pin("shaft", "ground", "a") +
         test::pin("hub", "ground", "b") + test::harmonic("sine", 1, 0.5) +
         torque("a", 0.2 * side, "factor = \"sine\"\n") +
         test::torsion("drag", "ground", "b", 0, "damping = 0.02\n") +
         freewheel("a", "b",
                   fmt::format("torque_limit = {}\ndirection = \"{}\"\n", capacity,
                               side > 0 ? "forward" : "backward")) +
         test::run_for(duration);
}

}  // namespace

TEST_CASE("invalid keys of a freewheel are refused", "[freewheel]") {
  const auto with = [](const std::string& keys) {
    return test::refusal(test::body("b", 1, 0.01) + test::pin("j", "ground", "b") +
                         "[loads.clutch]\ntype = \"freewheel\"\n" + keys + test::run_for(1));
  };
  const std::string between = "between = [\"ground\", \"b\"]\n";
  test::check_messages(with, {{between, "loads.clutch.torque_limit: is missing"},
                              {between + "torque_limit = 0\n", "torque_limit: must be greater than 0"},
                              {between + "torque_limit = 1\ndirection = \"up\"\n", "loads.clutch.direction"},
                              {"torque_limit = 1\n", "loads.clutch.between: is missing"}});
  const auto scene = parse_scene(ratchet(1, -1, 1), "s.toml");
  CHECK(to_toml(parse_scene(to_toml(scene), "again")) == to_toml(scene));
}

TEST_CASE("a backstop overruns freely, holds up to its capacity, and slips beyond", "[freewheel]") {
  for (const auto& way : ways) {
    CAPTURE(way.name);
    const auto over = test::finished(way, backstop(10, 0.5));
    CHECK(over.final_state.v[2] == Approx(10).epsilon(1e-12));
    CHECK(over.final_state.q[2] == Approx(5).epsilon(1e-12));
    CHECK(over.ledger.friction == 0);
    // Penalty: creeps with half of 1e-5 rad/s.
    const auto held = test::finished(way, backstop(0, 0.1, torque("b", -0.1)));
    CHECK(std::abs(held.final_state.q[2]) < (way.penalty() ? 1e-6 : 1e-12));
    // −0.1 N m beyond the capacity: ω̇ = −10 rad/s²; 0.05 rad in 0.1 s.
    const auto slips = test::finished(way, backstop(0, 0.1, torque("b", -0.3)));
    CHECK(slips.final_state.v[2] == Approx(-1).epsilon(way.penalty() ? 1e-5 : 1e-9));
    CHECK(slips.final_state.q[2] == Approx(-0.05).epsilon(way.penalty() ? 1e-5 : 1e-9));
    CHECK(slips.ledger.friction == Approx(0.2 * 0.05).epsilon(way.penalty() ? 1e-5 : 1e-9));
    // From −10 rad/s it stops after 0.5 s and 2.5 rad.
    const auto stops = test::finished(way, backstop(-10, 0.6));
    CHECK(stops.final_state.q[2] == Approx(-2.5).epsilon(3e-6));
    CHECK(std::abs(stops.final_state.v[2]) < (way.penalty() ? 1e-5 : 1e-9));
    CHECK(stops.ledger.friction == Approx(0.5).epsilon(1e-6));
  }
}

TEST_CASE("a freewheel feeds intermittently: a wheel follows the forward strokes of a lever", "[freewheel]") {
  // The lever turns by A(1 − cos Ωt), A = 0.1 rad, Ω = 10 rad/s. A friction of 0.5 N m > J A Ω² = 0.1 N m
  // stops the wheel at the end of each forward stroke: 2 A a turn. Work of friction 0.5 N m · 0.6 rad.
  const auto text = test::body("a", 1, 0.01) + test::body("b", 1, 0.01) + test::pin("shaft", "ground", "a") +
                    test::pin("hub", "ground", "b") +
                    test::curve("stroke", "harmonic",
                                fmt::format("mean = 0.1\namplitude = 0.1\nperiod = {}\nphase = {}\n",
                                            std::numbers::pi / 5, -std::numbers::pi / 2)) +
                    test::drive("lever", "shaft", "position = \"stroke\"\n") +
                    test::joint_friction("brake", "hub", "torque = 0.5\nregularisation = 1e-5\n") +
                    freewheel("a", "b", "torque_limit = 2\n") + test::run_for(3 * std::numbers::pi / 5);
  for (const auto& way : ways) {
    CAPTURE(way.name);
    // Penalty: slips and creeps with 1e-5 rad/s. Fixed steps: A Ω² h² of six reversals. Adaptive: tolerance.
    const auto run = test::finished(way, text);
    CHECK(run.final_state.q[5] == Approx(0.6).margin(way.penalty() ? 1e-4 : way.chosen() ? 1e-4 : 1e-5));
    CHECK(run.ledger.friction == Approx(0.3).epsilon(way.penalty() || way.chosen() ? 1e-3 : 1e-4));
  }
}

TEST_CASE("a harmonic torque drives a wheel through a freewheel in one direction", "[freewheel]") {
  // T = 5 N m, engaged until 0.250809792 s and thrice again from 0.723455068 s on; no loss.
  // T = 0.1 N m, slipping from 0.051103718 s to 0.281675928 s, and never later.
  struct Reference {
    double capacity, theta_a, theta_b, omega_a, omega_b, loss;
  };
  for (const auto& r :
       {Reference{5, -1.9922189062, 0.731956416637, -2.87191342467, 0.281600118278, 0},
        Reference{0.1, -1.85221217252, 0.717329725919, -2.86661878219, 0.286391866071, 0.0101971275845}})
    for (const auto& way : ways)
      for (const double side : {1.0, -1.0}) {
        CAPTURE(r.capacity, way.name, side);
        // Penalty: 1e-5 rad/s of slip, and a delay of engagement of 1e-5/20 s. Fixed steps: h² Δω̇ of eight
        // events, with a margin of 100. Adaptive steps, of 6 ms on average: h² Δω̇/8 = 1e-4 rad at each event.
        const double error = way.penalty() || way.fixed() ? 1e-4 : way.chosen() ? 5e-3 : 1e-7;
        const auto run = test::finished(way, ratchet(r.capacity, side, 2));
        const auto& [q, v] = std::tie(run.final_state.q, run.final_state.v);
        CHECK(side * q[2] == Approx(r.theta_a).margin(error));
        CHECK(side * q[5] == Approx(r.theta_b).margin(error));
        CHECK(side * v[2] == Approx(r.omega_a).margin(error));
        CHECK(side * v[5] == Approx(r.omega_b).margin(error));
        CHECK(run.ledger.friction == Approx(r.loss).margin(0.1 * error));
      }
  const auto rows = test::motion_rows(test::scene_by(test::event_driven, ratchet(5, 1, 2)),
                                      test::event_driven.family, 1e-3);
  CHECK(rows.worst([](const auto& row) { return std::min(row.v[5], 0.0); }) < 1e-9);
}

TEST_CASE("a freewheel takes no impulse in an impact, and stops the rebound", "[freewheel]") {
  // From 1 rad/s it hits the stop at 0.1 rad, leaves with −0.5 rad/s, and slips with 20 rad/s²: 0.00625 rad.
  const auto text = backstop(
      1, 0.3,
      test::surface("s", 0.5) + test::stop("limit", "angle-stop", "j", "upper = 0.1\nradius = 0.1\n"));
  for (const auto& way : {test::event_driven, test::fixed_steps(1e-5), test::automatic})
    for (const char* law : {"newton", "poisson"}) {
      if (way.fixed() && law == std::string_view("poisson")) continue;  // time stepping has Newton's law
      CAPTURE(way.name, law);
      const auto run = test::finished(way, text, {fmt::format("nonsmooth.impact_law=\"{}\"", law)});
      // Fixed steps: the step of the impact, 1e-5 s of 1 rad/s.
      CHECK(run.final_state.q[2] == Approx(0.1 - 0.00625).margin(way.fixed() ? 2e-5 : 1e-8));
      CHECK(std::abs(run.final_state.v[2]) < 1e-9);
      CHECK(run.ledger.friction == Approx(0.00125).epsilon(way.fixed() ? 1e-2 : 1e-6));
    }
}

TEST_CASE("a freewheel behind a joint with play engages later by the play over the relative rate",
          "[freewheel]") {
  // A motor of Ω takes a light ring along after the play p, and the ring drives a wheel of ω₀ through the
  // freewheel: ω₀ until t₁ = p/Ω, then α = T/J_b until Ω, then Ω. The ring bounces with Ω(1 ± e), above ω₀.
  const double Jb = 0.01, Jm = 1e-4, Omega = 4, start = 1, T = 0.2, k = 1e8, end = 0.3, r = 0.1;
  const double alpha = T / Jb, slip = (Omega - start) / alpha;
  const auto text = [&](bool stops) {
    const double side = stops ? 1 : -1, x = stops ? 0 : 2 * r;  // gears: ring and wheel turn the other way
    const auto at = fmt::format("position = [{}, 0]\n", x);
    return test::body("a", 1, 0.01, fmt::format("angular_velocity = {}\n", Omega)) +
           test::body("m", 1, Jm, at) +
           test::body("b", 1, Jb, at + fmt::format("angular_velocity = {}\n", side * start)) +
           test::pin("shaft", "ground", "a") + test::pin("hub", "ground", "b", {x, 0}) +
           (stops ? test::pin("ring", "a", "m") +
                        test::stop(
                            "play", "angle-stop", "ring",
                            fmt::format("lower = -0.1\nupper = 0.1\nradius = {}\nstiffness = {}\n", r, k))
                  : test::pin("ring", "ground", "m", {x, 0}) +
                        test::joint("play", "gear", "a", "m", {}, {},
                                    fmt::format("teeth = [20, 20]\nmodule = 0.01\nbacklash = 2e-3\n"
                                                "mesh_stiffness = {}\nsurface = \"s\"\n",
                                                k))) +
           test::surface("s", 0.5) + test::motor("motor", "shaft", Omega) +
           freewheel(
               "m", "b",
               fmt::format("torque_limit = {}\ndirection = \"{}\"\n", T, stops ? "forward" : "backward")) +
           test::run_for(end, "start = \"given\"\n");
  };
  for (const bool stops : {true, false})
    for (const auto& way : ways) {
      CAPTURE(stops, way.name);
      // Half of the backlash lies on either side of a tooth, along the line of action at 20°.
      const double radius = stops ? r : r * std::cos(M_PI / 9), play = stops ? 0.1 : 1e-3 / radius,
                   touch = play / Omega, rest = end - touch - slip, side = stops ? 1 : -1;
      // Penalty: the deflection T/(k r) of the stop is released with this rate. Fixed steps: α h of one step.
      const double error = way.penalty()  ? T / (radius * std::sqrt(k * (Jm + Jb)))
                           : way.fixed()  ? alpha * way.step
                           : way.chosen() ? 1e-6
                                          : 1e-9;
      const auto run = test::finished(way, text(stops));
      CHECK(test::touch(run, 0).t == Approx(touch).margin(way.fixed() ? way.step : 1e-9));
      CHECK(side * run.final_state.v[8] == Approx(Omega).margin(error));
      CHECK(side * run.final_state.q[8] ==
            Approx(start * (touch + slip) + 0.5 * alpha * slip * slip + Omega * rest)
                .margin(error * rest + 1e-9));
    }
}

TEST_CASE("snapshots of freewheels", "[freewheel][snapshot]") {
  const auto text = ratchet(0.1, 1, 0.8);
  snapshots::check({text + "[penalty]\nintegrator = \"rosenbrock4\"\n", "penalty", {}});
  for (const char* option :
       {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.step=1e-3", "nonsmooth.scheme=\"moreau-jean\""})
    snapshots::check({text, "nonsmooth", {option}});
}
