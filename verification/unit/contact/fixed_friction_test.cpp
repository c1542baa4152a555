// Friction of ideal joints with a fixed bound and a static value: refusals of the reader, closed forms,
// and references that integrate the equations between located events (order 8, tolerance 1e-13, in Python).
#include "io/scene/write_scene.hpp"
#include "verification/property/comparison/snapshot_check.hpp"
#include "verification/support/jacobian_check.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

const test::Way by_penalty{
    "penalty", Family::penalty, {}, 0, {"penalty.integrator=\"rosenbrock4\"", "penalty.tolerance=1e-10"}};
const test::Way ways[] = {by_penalty, test::event_driven, test::fixed_steps(1e-4), test::chosen_steps,
                          test::automatic};

/// A wheel of 0.01 kg m² on a pin at its centre.
std::string wheel(double spin, const std::string& keys, double duration) {
  return test::body("b", 2, 0.01, fmt::format("angular_velocity = {}\n", spin)) +
         test::pin("j", "ground", "b") + test::joint_friction("rub", "j", "regularisation = 1e-5\n" + keys) +
         test::run_for(duration);
}
std::string block(const std::string& keys) {
  return test::body("b", 1, 1) + test::guide("j", "ground", "b") +
         test::joint_friction("rub", "j", "regularisation = 1e-6\n" + keys) + test::run_for(0.1);
}

/// Modelica.Mechanics.Translational.Examples.Friction, mass: 1 kg from rest under 25 N sin(2π 0.25 Hz t),
/// with f = 5 N + 1 N s/m v + 10 N exp(−2 s/m |v|).
std::string modelica_friction(double duration) {
  return test::body("b", 1, 1) + test::guide("j", "ground", "b") +
         test::joint_friction("rub", "j",
                              "force = 5\nstatic_force = 15\nstribeck_speed = 0.5\nstribeck_exponent = 1\n"
                              "regularisation = 1e-6\n") +
         test::spring("damper", "ground", "b", {-100, 0}, {}, 0, 0, "damping = 1\n") +
         test::harmonic("sine", 1, 4) + test::force("push", "b", {25, 0}, "factor = \"sine\"\n") +
         test::run_for(duration);
}

/// A block of 1 kg on a belt with 0.1 m/s, held by a spring of 100 N/m.
std::string belt(double duration) {
  return test::body("belt", 1, 1, "velocity = [0.1, 0]\n") + test::body("b", 1, 1, "velocity = [0.1, 0]\n") +
         test::guide("rail", "ground", "belt") + test::guide("j", "belt", "b") +
         test::table("pace", "[[0, 0.1], [1, 0.1]]") + test::drive("motor", "rail", "velocity = \"pace\"\n") +
         test::spring("spring", "ground", "b", {-1, 0}, {}, 100, 1) +
         test::joint_friction(
             "rub", "j", "force = 5\nstatic_force = 10\nstribeck_speed = 0.05\nregularisation = 1e-6\n") +
         test::run_for(duration);
}

}  // namespace

TEST_CASE("invalid keys of friction with a fixed bound are refused", "[joint-friction]") {
  test::check_messages(
      [](const std::string& text) { return test::refusal(text); },
      {{wheel(1, "torque = -1\n", 1), "loads.rub.torque: must be 0 or greater"},
       {wheel(1, "torque = 1\nforce = 1\n", 1), "loads.rub.torque: the bound is either a fixed torque or"},
       {wheel(1, "torque = 1\nfriction = 0.1\npin_radius = 0.1\n", 1),
        "loads.rub.torque: the bound is either"},
       {wheel(1, "torque = 1\nstatic_torque = 2\n", 1), "loads.rub.stribeck_speed: is missing"},
       {wheel(1, "torque = 1\nstatic_torque = 0.5\nstribeck_speed = 1\n", 1),
        "loads.rub.static_torque: must be at least torque, 1"},
       {wheel(1, "torque = 1\nstatic_force = 2\nstribeck_speed = 1\n", 1),
        "loads.rub.static_force: belongs to translational joints"},
       {wheel(1, "static_torque = 2\nstribeck_speed = 1\n", 1), "loads.rub.static_torque: goes with torque"},
       {block("torque = 1\n"), "loads.rub.torque: belongs to revolute joints"},
       {block("force = 1\nstatic_force = 2\nstribeck_speed = 0\n"),
        "loads.rub.stribeck_speed: must be greater than 0"},
       {block("force = 1\nstribeck_speed = 1\n"), "loads.rub.stribeck_speed: goes with a static value"},
       {block("force = 1\nstatic_force = 2\nstribeck_speed = 1\nstribeck_exponent = 0.5\n"),
        "loads.rub.stribeck_exponent: must be between 1 and 100"},
       {block("friction = 1\nstribeck_exponent = 2\n"),
        "loads.rub.stribeck_exponent: goes with stribeck_speed"}});
  for (const auto& good :
       {wheel(1, "torque = 0.2\n", 1), wheel(1, "torque = 0.2\nstatic_torque = 0.6\nstribeck_speed = 3\n", 1),
        block("force = 1\nstatic_force = 2\nstribeck_speed = 0.1\nstribeck_exponent = 1\n")}) {
    const auto scene = parse_scene(good, "s.toml");
    CHECK(to_toml(parse_scene(to_toml(scene), "again")) == to_toml(scene));
  }
}

TEST_CASE("a friction torque of fixed bound stops a wheel in closed form", "[joint-friction]") {
  // ω̇ = −T/J = −20 rad/s²: ω(0.5 s) = 30 − 10; from 4 rad/s it stops at 0.2 s after 0.4 rad.
  for (const auto& way : ways) {
    CAPTURE(way.name);
    const auto run = test::finished(way, wheel(30, "torque = 0.2\n", 0.5));
    CHECK(run.final_state.v[2] == Approx(20).epsilon(1e-9));
    CHECK(run.ledger.friction == Approx(0.5 * 0.01 * (900 - 400)).epsilon(1e-8));
    const auto still = test::finished(way, wheel(4, "torque = 0.2\n", 0.3));
    // Penalty: linear below 1e-5 rad/s; fixed steps: ω̇ h² of the step of the stop, 2e-7 rad.
    CHECK(std::abs(still.final_state.v[2]) < (way.penalty() ? 1e-5 : 1e-9));
    CHECK(still.final_state.q[2] == Approx(0.4).margin(3e-6));
  }
}

TEST_CASE("a wheel under a torque with static value reaches a speed in closed form", "[joint-friction]") {
  // T(ω) = 0.2 + 0.4 exp(−ω/3 rad/s): t = ∫ J dω/T = J v/T₀ [ln(T₀ e^{ω/v} + T_s − T₀)], from 20 to 1 rad/s.
  const double J = 0.01, T0 = 0.2, more = 0.4, v = 3;
  const auto at = [&](double w) { return J * v / T0 * std::log(T0 * std::exp(w / v) + more); };
  for (const auto& way : ways) {
    CAPTURE(way.name);
    const auto run = test::finished(
        way, wheel(20, "torque = 0.2\nstatic_torque = 0.6\nstribeck_speed = 3\nstribeck_exponent = 1\n",
                   at(20) - at(1)));
    // Fixed steps: (h/τ)², τ = J v/T_s = 0.05 s, 4e-6; adaptive steps: tolerance over some hundred steps.
    CHECK(run.final_state.v[2] == Approx(1).epsilon(way.fixed() ? 1e-5 : way.chosen() ? 1e-4 : 1e-7));
  }
}

TEST_CASE("friction with a static value holds up to it and falls beyond", "[joint-friction]") {
  const auto pulled = [](double force) {
    return block("force = 5\nstatic_force = 15\nstribeck_speed = 0.5\n") +
           test::force("pull", "b", {force, 0});
  };
  for (const auto& way : ways) {
    CAPTURE(way.name);
    const auto held = test::finished(way, pulled(14.9));
    // Penalty: creeps with F/F_s of 1e-6 m/s, nearly.
    CHECK(std::abs(held.final_state.q[0]) < (way.penalty() ? 1e-6 * 0.1 : 1e-12));
    // ẍ = 20 N − F(u), from rest: between 5 and 15 m/s², at least that of the static value.
    const auto slides = test::finished(way, pulled(20));
    CHECK(slides.final_state.v[0] > 0.5);
    CHECK(slides.final_state.v[0] < 1.5);
  }
}

TEST_CASE("the friction example of the Modelica library", "[joint-friction]") {
  // Events: slip at t = (2/π) asin(0.6), reversal at 2.4426906360 s at x = 13.4555881185 m, and 4.4419424229 s.
  // At 3 s: x = 11.7820382183 m, v = −6.86223560185 m/s; at 5 s: 1.76851781139 m, 6.8648403711 m/s.
  for (const auto& way : ways) {
    CAPTURE(way.name);
    // Penalty: 1e-6 m/s of creep for half a second, growing with e^{20 s⁻¹ 0.02 s} where slip begins.
    // Fixed steps: (h/τ)² with τ = 0.05 s where slip begins; that time's error h²/24 F̈, margin of ten.
    // Adaptive steps: tolerance 1e-6 over some hundred steps.
    const double error = way.penalty() ? 1e-4 : way.fixed() ? 1e-4 : way.chosen() ? 1e-3 : 1e-6;
    const auto back = test::finished(way, modelica_friction(3));
    CHECK(back.final_state.q[0] == Approx(11.7820382183).epsilon(error));
    CHECK(back.final_state.v[0] == Approx(-6.86223560185).epsilon(error));
    const auto run = test::finished(way, modelica_friction(5));
    CHECK(run.final_state.q[0] == Approx(1.76851781139).margin(10 * error));
    CHECK(run.final_state.v[0] == Approx(6.8648403711).epsilon(error));
    CHECK(std::abs(run.ledger.closure()) < error * run.ledger.friction);
  }
}

TEST_CASE("a block on a belt sticks and slips with the period of an independent integration",
          "[joint-friction]") {
  // Slip begins at x = F_s/k = 0.1 m, t = 1 s, and ends 0.404293443543 s later at x = −0.00560348603414 m:
  // period 1.46032830388 s. At 3 s the block has stuck for the second time and moves with the belt, at
  // x = −0.00560348603414 m + 0.1 m/s (3 − 1 − 1.46032830388 − 0.404293443543) s.
  const double slip = 0.404293443543, period = 1.46032830388, end = -0.00560348603414;
  for (const auto& way : ways) {
    CAPTURE(way.name);
    // Adaptive steps: 2e-3 of the end of sliding with a fixed force by the same steps, margin of two.
    const double error = way.penalty() || way.fixed() ? 1e-4 : way.chosen() ? 5e-3 : 1e-6;
    const auto run = test::finished(way, belt(3));
    CHECK(run.final_state.q[3] == Approx(end + 0.1 * (3 - 1 - period - slip)).margin(0.1 * error));
    CHECK(run.final_state.v[3] == Approx(0.1).margin(way.penalty() ? 1e-6 : 1e-9));
    const auto third = test::finished(way, belt(1 + 2 * period));  // where slip begins again
    CHECK(third.final_state.q[3] == Approx(0.1).margin(0.1 * error));
  }
}

TEST_CASE("a fixed bound needs no reaction: redundant supports and phase-based impact laws are accepted",
          "[joint-friction]") {
  const auto twice =
      block("force = 1\nstatic_force = 2\nstribeck_speed = 0.1\n") + test::guide("second", "ground", "b");
  const auto wall = test::surface("s", 0.5) +
                    test::plane("wall", "ground", "b", 0, "s", "at = [[0.5, 0], [0, 0]]\naxis = [0, 1]\n") +
                    "[nonsmooth]\nimpact_law = \"poisson\"\n";
  for (const auto& way : {by_penalty, test::event_driven, test::fixed_steps(1e-4)})
    CHECK(test::finished(way, way.penalty() || way.fixed() ? twice : twice + wall).ledger.friction ==
          Approx(0).margin(1e-15));
}

TEST_CASE("snapshots and the exact Jacobian with friction of fixed bound and static value",
          "[joint-friction][snapshot][jacobian]") {
  const auto text = belt(1.6);
  snapshots::check({text + "[penalty]\nintegrator = \"rosenbrock4\"\n", "penalty", {}});
  for (const char* option :
       {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.step=1e-3", "nonsmooth.scheme=\"moreau-jean\""})
    snapshots::check({text, "nonsmooth", {option}});
  for (const char* exponent : {"1", "2", "1.5"}) {
    const auto scene =
        parse_scene(test::two_bodies() +
                        test::joint_friction(
                            "rub_pin", "pin",
                            "torque = 0.4\nstatic_torque = 0.7\nstribeck_speed = 3\nregularisation = 50.0\n" +
                                fmt::format("stribeck_exponent = {}\n", exponent)) +
                        test::joint_friction(
                            "rub_slide", "slide",
                            "force = 3\nstatic_force = 4\nstribeck_speed = 0.5\nregularisation = 10.0\n") +
                        test::run_for(1),
                    "jacobian");
    CHECK(test::jacobian_error(scene, 20261130, 6) < 1e-6);
  }
}
