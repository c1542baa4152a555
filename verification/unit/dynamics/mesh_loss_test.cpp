// Losses of gears and racks: refusals of the reader, driving and driven motion in closed form, a worm that
// holds its load, a planet on a moving arm, and LossyGearDemo1 of the Modelica Standard Library against an
// integration of its mode equations between located events (order 8, tolerance 1e-13, in Python).
#include "io/scene/write_scene.hpp"
#include "verification/property/comparison/snapshot_check.hpp"
#include "verification/support/jacobian_check.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

const test::Way by_penalty{
    "penalty", Family::penalty, {}, 0, {"penalty.integrator=\"rosenbrock4\"", "penalty.tolerance=1e-10"}};
const test::Way ways[] = {by_penalty, test::event_driven, test::fixed_steps(1e-4), test::chosen_steps,
                          test::automatic};
constexpr double r1 = 0.05, r2 = 0.1;  // m

std::string torque(const std::string& name, const std::string& body, double torque,
                   const std::string& keys = "") {
  return fmt::format("[loads.{}]\ntype = \"torque\"\nbody = \"{}\"\ntorque = {}\n{}", name, body, torque,
                     keys);
}
/// Two gears on pins; `more`: loads.
std::string gears(double J1, double J2, Vec2 radii, const std::string& keys, const std::string& more,
                  double duration) {
  const double apart = radii.x() + radii.y();
  return test::body("a", 1, J1) + test::body("b", 1, J2, fmt::format("position = [{}, 0]\n", apart)) +
         test::pin("pin_a", "ground", "a") + test::pin("pin_b", "ground", "b", {apart, 0}) +
         test::gear("mesh", "a", "b", radii, "regularisation = 1e-6\n" + keys) + more +
         test::run_for(duration);
}
std::string lossy(const std::string& more, const std::string& keys = "", double duration = 0.1) {
  return gears(0.01, 0.08, {r1, r2}, "efficiency = 0.8\nback_efficiency = 0.6\n" + keys, more, duration);
}
const char* const flanks[] = {"forward", "backward"};

}  // namespace

TEST_CASE("invalid keys of the loss of a mesh are refused", "[mesh-loss]") {
  const auto with = [](const std::string& keys) {
    return test::refusal(gears(0.01, 0.08, {r1, r2}, keys, test::surface("s", 0.5), 1));
  };
  test::check_messages(
      with,
      {{"efficiency = 0\n", "joints.mesh.efficiency: must be greater than 0 and at most 1"},
       {"efficiency = 1.1\n", "joints.mesh.efficiency: must be greater than 0 and at most 1"},
       {"back_efficiency = 0.5\n", "joints.mesh.back_efficiency: goes with efficiency"},
       {"efficiency = 0.5\nback_efficiency = 2\n", "joints.mesh.back_efficiency: must be 1 or less"},
       {"lead_angle = 0.1\n", "joints.mesh.lead_angle: lead_angle and mesh_friction go together"},
       {"mesh_friction = 0.1\n", "joints.mesh.mesh_friction: lead_angle and mesh_friction go together"},
       {"lead_angle = 0.1\nmesh_friction = 0.1\nefficiency = 0.5\n", "joints.mesh.efficiency: follows from"},
       {"lead_angle = 1.5\nmesh_friction = 0.1\n", "joints.mesh.mesh_friction: is so great"},
       {"", "joints.mesh.regularisation: belongs to efficiency"},
       {"efficiency = 0.9\nbacklash = 1e-4\nsurface = \"s\"\n",
        "joints.mesh.efficiency: belongs to pairs without backlash"}});
  for (const char* good : {"efficiency = 0.9\n", "efficiency = 0.4\nback_efficiency = -0.4\n",
                           "lead_angle = \"5 deg\"\nmesh_friction = 0.12\n"}) {
    const auto scene = parse_scene(gears(0.01, 0.08, {r1, r2}, good, "", 1), "s.toml");
    CHECK(to_toml(parse_scene(to_toml(scene), "again")) == to_toml(scene));
  }
  const auto without = gears(0.01, 0.08, {r1, r2}, "efficiency = 0.9\n", "", 1);
  auto text = without;
  text.erase(text.find("regularisation = 1e-6\n"), std::string("regularisation = 1e-6\n").size());
  CHECK_THAT(test::refusal_of<std::exception>([&] { Simulation(parse_scene(text, "s.toml"), "penalty"); }),
             Contains("joints.mesh.regularisation: is missing"));
}

TEST_CASE("gears with loss accelerate in closed form, driving and driven, on either flank", "[mesh-loss]") {
  // Reflected to wheel 1, J₂' = J₂ r₁²/r₂² and Λ the torque of the mesh: driving, friction is −c₁ Λ,
  //     J₁ α = T − (1 + c₁) Λ,  Λ = J₂' α + L:   α = (T − L/η₁)/(J₁ + J₂'/η₁);
  // driven, α = (η₂ L − T)/(J₁ + η₂ J₂') in the direction of the load. At rest it holds for η₂ L < T < L/η₁.
  const double J1 = 0.01, J2 = 0.08 / 4, T = 1;
  for (const auto& way : ways)
    for (const char* flank : flanks)
      for (const double side : {1.0, -1.0}) {
        CAPTURE(way.name, flank, side);
        const auto keys = fmt::format("flank = \"{}\"\n", flank);
        const double error = way.penalty() ? 2e-5 : 1e-9, t = 0.1;
        const auto loads = [&](double one, double other) {  // both reflected to wheel 1
          return torque("motor", "a", side * one) + torque("load", "b", side * other * r2 / r1);
        };
        // Wheel 2 turns the other way: a load opposed to wheel 1 has its sign.
        const auto lifts = test::finished(way, lossy(loads(T, 0.4), keys));
        const double up = (T - 0.4 / 0.8) / (J1 + J2 / 0.8);
        CHECK(side * lifts.final_state.v[2] == Approx(up * t).epsilon(error));
        CHECK(side * lifts.final_state.v[5] == Approx(-up * t * r1 / r2).epsilon(error));
        CHECK(lifts.ledger.friction ==
              Approx((1 / 0.8 - 1) * (J2 * up + 0.4) * up * t * t / 2).epsilon(3 * error));
        const auto sinks = test::finished(way, lossy(loads(0.1, 0.4), keys));
        const double down = (0.6 * 0.4 - 0.1) / (J1 + 0.6 * J2);
        CHECK(side * sinks.final_state.v[2] == Approx(-down * t).epsilon(error));
        CHECK(sinks.ledger.friction ==
              Approx((1 - 0.6) * (0.4 - J2 * down) * down * t * t / 2).epsilon(3 * error));
        for (const double motor : {0.25, 0.49}) {  // η₂ L = 0.24, L/η₁ = 0.5
          const auto holds = test::finished(way, lossy(loads(motor, 0.4), keys));
          // Penalty: creeps with at most 1e-6 rad/s.
          CHECK(std::abs(holds.final_state.q[2]) < (way.penalty() ? 1.5e-7 : 1e-12));
        }
        CHECK(std::abs(lifts.ledger.closure()) < 1e-5 * lifts.ledger.friction);
      }
}

TEST_CASE("a motor of constant speed supplies the loss of a mesh", "[mesh-loss]") {
  // 10 rad/s for 0.1 s against or with 0.4 N m at wheel 1: work of friction c · 0.4 N m · 1 rad.
  for (const auto& way : ways)
    for (const double side : {1.0, -1.0}) {
      CAPTURE(way.name, side);
      const auto run = test::finished(
          way, lossy(test::motor("motor", "pin_a", side * 10) + torque("load", "b", 0.4 * r2 / r1)));
      const double share = side > 0 ? 1 / 0.8 - 1 : 1 - 0.6;
      CHECK(run.ledger.friction == Approx(share * 0.4).epsilon(1e-8));
      CHECK(run.ledger.drive == Approx(side * 0.4 + share * 0.4).epsilon(1e-8));
    }
}

TEST_CASE("a self-locking worm holds its load and must be driven down", "[mesh-loss]") {
  // γ = 5°, μ = 0.12: η₁ = tan γ/tan(γ + ρ) and η₂ = tan(γ − ρ)/tan γ < 0. Ratio 40.
  const double gamma = std::numbers::pi / 36, rho = std::atan(0.12), tan = std::tan(gamma);
  const double up = tan / std::tan(gamma + rho), back = std::tan(gamma - rho) / tan;
  REQUIRE(back == Approx(-0.3674).epsilon(1e-3));
  const double J1 = 1e-4, J2 = 0.1 / 1600, L = 8.0 / 40, t = 0.1;
  const auto worm = [&](double motor) {
    return gears(J1, 0.1, {0.005, 0.2}, "lead_angle = \"5 deg\"\nmesh_friction = 0.12\n",
                 torque("motor", "a", motor) + torque("load", "b", 8), t);
  };
  for (const auto& way : ways) {
    CAPTURE(way.name);
    const double error = way.penalty() ? 2e-5 : 1e-9;
    for (const double motor : {0.0, 0.99 * back * L, 0.99 * L / up}) {
      const auto holds = test::finished(way, worm(motor));
      CHECK(std::abs(holds.final_state.q[2]) < (way.penalty() ? 1.5e-7 : 1e-11));
    }
    const auto lifts = test::finished(way, worm(2 * L / up));
    CHECK(lifts.final_state.v[2] == Approx(L / up / (J1 + J2 / up) * t).epsilon(error));
    // Driven down by T < η₂ L < 0: α = (T − η₂ L)/(J₁ + η₂ J₂').
    const auto sinks = test::finished(way, worm(2 * back * L));
    CHECK(sinks.final_state.v[2] == Approx(back * L / (J1 + back * J2) * t).epsilon(error));
  }
}

TEST_CASE("a gear drives a rack with loss, and a rack a gear", "[mesh-loss]") {
  // α = (T − r F/η₁)/(J + m r²/η₁), driven (η₂ r F − T)/(J + η₂ m r²) the other way.
  const double J = 0.01, m = 2, r = 0.05, t = 0.1;
  for (const auto& way : ways)
    for (const char* flank : flanks) {
      CAPTURE(way.name, flank);
      const double error = way.penalty() ? 2e-5 : 1e-9;
      const auto speed = [&](double motor, double force) {
        const auto text =
            test::body("a", 1, J, fmt::format("position = [0, {}]\n", r)) + test::body("b", m, 1) +
            test::pin("pin", "ground", "a", {0, r}) + test::guide("guide", "ground", "b") +
            test::joint("mesh", "rack", "a", "b", {}, {},
                        fmt::format("pitch_radius = {}\nefficiency = 0.8\nback_efficiency = 0.6\n"
                                    "regularisation = 1e-6\nflank = \"{}\"\n",
                                    r, flank)) +
            torque("motor", "a", motor) + test::force("load", "b", {force, 0}) + test::run_for(t);
        const auto run = test::finished(way, text);
        CHECK(std::abs(run.final_state.v[3]) == Approx(r * std::abs(run.final_state.v[2])).margin(1e-9));
        return run.final_state.v[2];
      };
      // A wheel that turns counter-clockwise moves the rack, below it, along +x.
      for (const double side : {1.0, -1.0}) {
        CHECK(speed(side, -side * 8) ==
              Approx(side * (1 - r * 8 / 0.8) / (J + m * r * r / 0.8) * t).epsilon(error));
        CHECK(speed(side * 0.1, -side * 8) ==
              Approx(-side * (0.6 * r * 8 - 0.1) / (J + 0.6 * m * r * r) * t).epsilon(error));
        CHECK(std::abs(speed(side * 0.3, -side * 8)) < (way.penalty() ? 1e-5 : 1e-11));
      }
    }
}

TEST_CASE("the loss of a planet follows its rotation against the arm", "[mesh-loss]") {
  // An arm turns about a fixed sun of radius r₁; its planet of radius r₂ turns k = 1 + r₁/r₂ times as fast
  // and carries a torque L. In the frame of the arm the sun drives with the torque Λ = (J_p k α + L) r₁/r₂:
  //     (J_a + m (r₁ + r₂)² + J_p k²) α = M − k L − c₁ Λ.
  const double Ja = 0.02, Jp = 0.005, m = 1, M = 2, L = 0.3, k = 1 + r1 / r2, c = 1 / 0.8 - 1, t = 0.2;
  const double inertia = Ja + m * (r1 + r2) * (r1 + r2) + Jp * k * k;
  const double alpha = (M - k * L - c * L * r1 / r2) / (inertia + c * Jp * k * r1 / r2);
  const auto text =
      test::body("arm", 3, Ja) + test::body("planet", m, Jp, "position = [0.15, 0]\n") +
      test::pin("hub", "ground", "arm") + test::pin("pin", "arm", "planet", {0.15, 0}) +
      test::gear("mesh", "ground", "planet", {r1, r2}, "efficiency = 0.8\nregularisation = 1e-6\n") +
      torque("motor", "arm", M) + torque("load", "planet", -L) + test::run_for(t);
  for (const auto& way : ways) {
    CAPTURE(way.name);
    // Fixed steps: (ω h)² of rows that turn, 1e-6, margin of ten; adaptive steps: tolerance.
    const double error = way.penalty() ? 2e-5 : way.fixed() ? 1e-5 : way.chosen() ? 1e-4 : 1e-8;
    const auto run = test::finished(way, text);
    CHECK(run.final_state.v[2] == Approx(alpha * t).epsilon(error));
    CHECK(run.final_state.v[5] == Approx(k * alpha * t).epsilon(error));
    CHECK(run.ledger.friction ==
          Approx(c * (Jp * k * alpha + L) * r1 / r2 * alpha * t * t / 2).epsilon(10 * error));
  }
}

TEST_CASE("LossyGearDemo1 of the Modelica Standard Library: rolling both ways, and stuck", "[mesh-loss]") {
  // J₁ = 1 kg m², J₂ = 1.5 kg m², ratio 2, η = 0.5 both ways, 10 N m sin(2π t) against −10 N m + 2.5 N m/s t.
  // Backwards until 0.0804771339 s, stuck, forwards from 0.1995199008 s, stuck from 0.3713427780 s, backwards
  // from 0.4645394616 s. Angle and speed of the first inertia, and the energy lost:
  struct At {
    double t, angle, speed, loss;
  };
  const At list[] = {{0.3, -0.00103463629777, 0.0263623901183, 0.0112484677667},
                     {0.5, 3.32487044322e-05, -0.032523858762, 0.0185210832517},
                     {2, -3.81041571407, -4.78025803371, 4.54448892386}};
  const auto text = [](double duration) {
    return gears(1, 1.5, {r1, r2}, "efficiency = 0.5\n",
                 test::harmonic("sine", 1, 1) + test::table("ramp", "[[0, 1], [2, 0.5]]") +
                     torque("drive", "a", 10, "factor = \"sine\"\n") +
                     torque("load", "b", 10, "factor = \"ramp\"\n"),
                 duration);
  };
  for (const auto& way : ways)
    for (const auto& at : list) {
      CAPTURE(way.name, at.t);
      // Penalty: 1e-6 rad/s of creep. Fixed steps: h² α̇ of five events. Adaptive: some hundred steps with errors of 1e-6.
      const double error = way.penalty() || way.fixed() ? 1e-5 : way.chosen() ? 5e-4 : 1e-8;
      const auto run = test::finished(way, text(at.t));
      CHECK(run.final_state.q[2] == Approx(at.angle).margin(error));
      CHECK(run.final_state.v[2] == Approx(at.speed).margin(error));
      CHECK(run.final_state.v[5] == Approx(-0.5 * at.speed).margin(error));
      CHECK(run.ledger.friction == Approx(at.loss).margin(error));
    }
}

TEST_CASE("snapshots and the exact Jacobian of gears with loss", "[mesh-loss][snapshot][jacobian]") {
  const auto text = lossy(test::harmonic("sine", 1, 0.1) + torque("motor", "a", 1, "factor = \"sine\"\n") +
                              torque("load", "b", 0.4),
                          "", 0.2);
  snapshots::check({text + "[penalty]\nintegrator = \"rosenbrock4\"\n", "penalty", {}});
  for (const char* option :
       {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.step=1e-3", "nonsmooth.scheme=\"moreau-jean\""})
    snapshots::check({text, "nonsmooth", {option}});
  auto soft = lossy(test::harmonic("sine", 1, 1) + torque("motor", "a", 1, "factor = \"sine\"\n") +
                    torque("load", "b", 0.4));
  soft.replace(soft.find("regularisation = 1e-6"), 21, "regularisation = 50.0");
  CHECK(test::jacobian_error(parse_scene(soft, "jacobian"), 20261130, 6) < 1e-6);
}
