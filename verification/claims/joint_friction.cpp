// Friction in ideal joints, bounded by the joint reactions: closed forms of pins and guides, an
// impact, and a four-bar against independent Newton–Euler equations, by all formulations and
// schemes.
#include "verification/references/joint_friction.hpp"
#include "verification/claims/force_claims.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

constexpr double h = 1e-4;  // s, of fixed steps

using test::Way;
const Way ways[] = {
    {"penalty", Family::penalty, {}, 0, {"penalty.integrator=\"rosenbrock4\"", "penalty.tolerance=1e-10"}},
    test::fixed_steps(h, "Moreau–Jean, h = 1e-4 s"),
    test::chosen_steps,
    test::event_driven,
    test::automatic};

/// One body on one joint with friction.
std::string one(double spin, const std::string& body, const std::string& joint, const std::string& friction,
                double duration, const std::string& more = "") {
  return fmt::format(
      "gravity = [0, -9.81]\n[bodies.b]\nangular_velocity = {}\n{}\n[joints.j]\n"
      "between = [\"ground\", \"b\"]\n{}\n"
      "[loads.rub]\ntype = \"joint-friction\"\njoint = \"j\"\nregularisation = 1e-6\n{}\n[run]\n"
      "duration = {}\n{}",
      spin, body, joint, friction, duration, more);
}

constexpr const char* constant = "forces are constant: rounding of the steps, and the tolerance of 1e-10";
constexpr const char* wheel_body = "mass = 2.0\ninertia = 0.01";
constexpr const char* pin = "type = \"revolute\"";

void wheels(Findings& f) {
  const double alpha = reference::wheel_deceleration(0.2, 0.02, 2, 9.81, 0.01);
  const auto friction = "friction = 0.2\npin_radius = 0.02";
  for (const auto& way : ways) {
    const auto name = [&](const char* quantity) {
      return claim_name("wheel on a pin with friction", quantity, way.name);
    };
    const auto run = test::finished(way, one(30, wheel_body, pin, friction, 0.5));
    f.relative(name("speed after 0.5 s from 30 rad/s"), "rad/s", run.final_state.v[2], 30 - 0.5 * alpha, 1e-9,
               "ω̇ = −μ r m g/J", constant);
    const double lost = 0.5 * 0.01 * (900 - std::pow(30 - 0.5 * alpha, 2));
    f.relative(name("work of friction in the energy balance, 0.5 s"), "J", run.ledger.friction, lost, 1e-8,
               "½ J (ω₀² − ω²)", constant);
    const auto back = test::finished(way, one(-30, wheel_body, pin, friction, 0.5));
    f.within(name("sum of the speeds after 0.5 s from ±30 rad/s"), "rad/s",
             back.final_state.v[2] + run.final_state.v[2], 0, 1e-12 * 30, "0: mirror symmetry", "rounding");
    const auto still = test::finished(way, one(3, wheel_body, pin, friction, 0.6));
    // The regularised couple is linear below 1e-6 m/s.
    f.at_most(name("speed after 0.6 s from 3 rad/s, stop at 0.382 s"), "rad/s",
              std::abs(still.final_state.v[2]), way.penalty() ? 1e-6 / 0.02 : 1e-9, "0: the wheel is at rest",
              "penalty: regularisation speed over r; else rounding");
    f.within(name("angle after 0.6 s from 3 rad/s, stop at 0.382 s"), "rad", still.final_state.q[2],
             4.5 / alpha, 3e-6, "ω₀²/(2 ω̇)",
             "penalty: 1e-6/r times the time at rest; fixed steps: ω̇ h² of the step of the stop, 8e-8; "
             "adaptive steps: "
             "tolerance 1e-6");
    const auto none = test::finished(way, one(30, wheel_body, pin, "friction = 0.0\npin_radius = 0.02", 0.5));
    f.within(name("speed after 0.5 s from 30 rad/s, μ = 0"), "rad/s", none.final_state.v[2], 30, 3e-14 * 30,
             "constant speed", "rounding");
    const auto thin = test::finished(way, one(30, wheel_body, pin, "friction = 0.2\npin_radius = 1e-9", 0.5));
    f.within(name("loss of speed with a pin of radius 1e-9 m over that of 0.02 m"), "",
             (30 - thin.final_state.v[2]) / (0.5 * alpha), way.penalty() ? 1.5e-9 : 5e-8, 1e-12,
             "proportional to r; penalty: u = r ω = 3e-8 m/s is 1/30 of the regularisation speed",
             "1e-14 of 30 rad/s over 3.9 rad/s, margin of ten");
  }
}

void stribeck(Findings& f) {
  const double T = reference::stribeck_time(0.1, 0.3, 0.05, 0.02, 2, 9.81, 0.01, 5, 1);
  for (const auto& way : ways) {
    const auto run = test::finished(
        way, one(5, wheel_body, pin,
                 "friction = 0.1\npin_radius = 0.02\nstatic_friction = 0.3\nstribeck_speed = 0.05", T));
    f.relative(claim_name("wheel on a pin with Stribeck friction", "speed at the time of 1 rad/s", way.name),
               "rad/s", run.final_state.v[2], 1,
               way.fixed()    ? 1e-5
               : way.chosen() ? 1e-4
                              : 1e-7,
               "1: time from ∫ J dω/(r m g μ(rω))",
               "fixed steps: (h/τ)² = 4e-6, τ ≥ 0.05 s being the time of change of μ, margin of two; "
               "adaptive steps: tolerance "
               "over some hundred steps; else 1e-10 per step");
  }
}

void rotors(Findings& f) {
  const reference::EccentricRotor rotor{0.3, 0.05, 2, 0.04, 0.01 + 2 * 0.04 * 0.04};
  const char* const subject = "eccentric rotor with friction from its centrifugal reaction";
  const double w0 = 20, T = 0.5;
  for (const auto& way : ways) {
    const auto run = test::finished(
        way,
        one(w0, "mass = 2.0\ninertia = 0.01\nposition = [0.04, 0]\nvelocity = [0, 0.8]",
            "type = \"revolute\"\nat = [[0, 0], [-0.04, 0]]", "friction = 0.3\npin_radius = 0.05", T),
        {"gravity=[0,0]"});
    f.relative(
        claim_name(subject, "speed after 0.5 s", way.name), "rad/s", run.final_state.v[2], rotor.speed(w0, T),
        way.fixed()    ? 4e-6
        : way.chosen() ? 1e-4
                       : 1e-7,
        "ω₀/(1 + c ω₀ t), c = k/√(1 − k²), k = μ r m ε/J",
        "fixed steps: (ω h)² = 4e-6; adaptive steps: tolerance over some hundred steps; else 1e-10 per step");
    f.at_most(
        claim_name(subject, "error of the energy balance over the initial energy", way.name), "",
        std::abs(run.ledger.closure()) / run.ledger.initial,
        way.fixed()    ? 4e-6
        : way.chosen() ? 1e-4
                       : 1e-7,
        "0",
        "fixed steps: (ω h)² = 4e-6; adaptive steps: tolerance over some hundred steps; else 1e-10 per step");
  }
}

void blocks(Findings& f) {
  const auto block = "mass = 3.0\ninertia = 1.0";
  const auto guide = "type = \"translational\"";
  const auto pull = [](double force) {
    return fmt::format("[loads.pull]\ntype = \"force\"\nbody = \"b\"\nforce = [{}, 0]\n", force);
  };
  for (const auto& way : ways) {
    const auto name = [&](const char* quantity) {
      return claim_name("block on a guide with friction", quantity, way.name);
    };
    const double weight = 3 * 9.81, mu = 0.25;
    for (const double side : {1.0, -1.0}) {
      const auto run = test::finished(way, one(0, block, guide, "friction = 0.25", 0.4, pull(side * 12)));
      f.within(name(side > 0 ? "velocity after 0.4 s at 12 N" : "velocity after 0.4 s at −12 N"), "m/s",
               run.final_state.v[0], side * 0.4 * (12 - mu * weight) / 3,
               way.penalty()  ? 2e-6
               : way.chosen() ? 1e-6
                              : 1e-9,
               "(F − μ m g) t/m",
               "penalty: twice the regularisation speed; adaptive steps: tolerance; else rounding");
    }
    const auto held =
        test::finished(way, one(0, block, guide, "friction = 0.25", 0.4, pull(0.99 * mu * weight)));
    f.at_most(name("speed after 0.4 s at 0.99 μ m g"), "m/s", std::abs(held.final_state.v[0]),
              way.penalty() ? 1e-6 : 1e-12, "0: the block sticks",
              "penalty: creep below the regularisation speed; else rounding");
    // A force parallel to the axis at distance b on a slider of length L, no weight: the couple
    // alone causes normal forces.
    for (const double b : {0.15, 0.3}) {
      const double k = reference::cantilever_share(0.25, b, 0.1);
      const auto run = test::finished(
          way,
          one(0, block, guide, "friction = 0.25\nslider_length = 0.1", 0.4,
              fmt::format("[loads.pull]\ntype = \"force\"\nbody = \"b\"\nat = [0, {}]\nforce = [6, 0]\n", b)),
          {"gravity=[0,0]"});
      f.within(claim_name("slider pulled beside its axis",
                          k < 1 ? "velocity after 0.4 s, 2 μ b/L = 0.75"
                                : "velocity after 0.4 s, 2 μ b/L = 1.5 (self-locking)",
                          way.name),
               "m/s", run.final_state.v[0], k < 1 ? 0.4 * (1 - k) * 6 / 3 : 0,
               way.penalty()  ? 2e-6
               : way.chosen() ? 1e-6
                              : 1e-9,
               k < 1 ? "(1 − 2 μ b/L) F t/m" : "0: self-locking",
               "penalty: twice the regularisation speed; adaptive steps: tolerance; else rounding");
    }
  }
}

/// A pendulum released near its lowest position sticks while its weight acts within the friction
/// circle.
void pendulums(Findings& f) {
  const double l = 0.2, r = 0.02, mu = 0.3;
  for (const auto& way : ways)
    for (const double share : {0.98, 1.02}) {
      const double angle = std::asin(share * mu * r / l);
      const auto run =
          test::finished(way, one(0,
                                  fmt::format("mass = 1.0\ninertia = 0.001\nposition = [{}, {}]\nangle = {}",
                                              l * std::sin(angle), -l * std::cos(angle), angle),
                                  fmt::format("type = \"revolute\"\nat = [[0, 0], [0, {}]]", l),
                                  "friction = 0.3\npin_radius = 0.02", 0.1));
      const double rate = std::sqrt(9.81 * l / (0.001 + l * l)), beyond = angle - std::asin(mu * r / l);
      const double expected = -rate * beyond * std::sin(rate * 0.1);
      f.within(claim_name("pendulum with friction in its pivot",
                          share < 1 ? "speed after 0.1 s, released 2 % below the friction angle"
                                    : "speed after 0.1 s, released 2 % above the friction angle",
                          way.name),
               "rad/s", run.final_state.v[2], share < 1 ? 0 : expected,
               share < 1 ? (way.penalty() ? 1e-6 / r : 1e-9)
                         : 0.01 * std::abs(expected) + 2e-6 / r * (way.penalty()),
               share < 1 ? "0: at rest while l sin θ ≤ μ r"
                         : "−δ₀ Ω sin Ω t about the angle where l sin θ = μ r, Ω² = m g l/J",
               share < 1
                   ? "penalty: regularisation speed over r; else rounding"
                   : "1 %: the reaction is m g up to l ω̇/g and ω², 1e-3; penalty: also its regularisation");
    }
}

/// Impact of a rod on a pin against a wall: the impulse of the pin bounds its friction impulse.
void impacts(Findings& f) {
  const double mu = 0.4, r = 0.05, m = 1, l = 0.15, a = 0.35, J = 0.01 + m * l * l, e = 0.5;
  const auto text = one(
      -5, "mass = 1.0\ninertia = 0.01\nangle = 0.02", "type = \"revolute\"\nat = [[0, 0], [-0.15, 0]]",
      "friction = 0.4\npin_radius = 0.05", 0.02,
      "[surfaces.s]\nrestitution = 0.5\n[contacts.wall]\ntype = \"plane\"\nbetween = [\"ground\", \"b\"]\n"
      "at = [[0, 0], [0.2, 0]]\nsurface = \"s\"\n");
  for (const auto& way : ways) {
    // its friction acts on the sliding speed within the impact: another law
    if (way.penalty()) continue;
    const auto run = test::finished(way, text, {"gravity=[0,0]"});
    const auto hit = test::touch(run, 0);
    f.relative(
        claim_name("rod on a pin with friction hitting a wall", "impulse over approach speed", way.name),
        "N s²/m", hit.impulse_n / -hit.v_n_minus, reference::rod_impulse(mu, r, m, l, a, J, e, 1), 1e-4,
        "J_p (1 + e) w = a P − μ r |Λ|",
        "fixed steps: m l ω² h within the step against m l (1 + e) ω, "
        "and (ω h)² of the angle at contact, 1e-7; forces within the "
        "step of the impact; margin of 1000");
    f.relative(claim_name("rod on a pin with friction hitting a wall", "separation speed over approach speed",
                          way.name),
               "", hit.v_n_plus / -hit.v_n_minus, e, way.fixed() ? 1e-3 : 1e-6, "e, Newton's law",
               "fixed steps: ω̇ h/ω = 1e-4, margin of ten; else rounding");
  }
}

void four_bars(Findings& f) {
  const reference::FourBar bar{0.1,  0.3,   0.25, 0.4, {0.8, 2.0, 1.6}, {0.7e-3, 16e-3, 9e-3}, 9.81,
                               0.15, 0.012, 10,   0};
  for (const auto& way : ways) {
    auto options = way.options;
    options.insert(options.end(), {"run.revolutions=1", "run.discard=0"});
    auto scene = read_scene(test::source_folder() / "cases/four-bar-friction/scene.toml", options);
    way.choose(scene);
    Simulation simulation(scene, test::name_of(way.family));
    const auto& layout = simulation.layout();
    const auto find = [&](const char* name) { return force_claims::find(layout, name); };
    const std::array<std::size_t, 4> joints{find("A0"), find("A"), find("B"), find("B0")},
        rubs{find("rub_A0"), find("rub_A"), find("rub_B"), find("rub_B0")};
    const auto motor = find("motor");
    Forces now{std::vector<ElementForce>(layout.forces.size()), std::vector<double>(9)};
    double torque = 0, torque_off = 0, couple = 0, couple_off = 0, force = 0, force_off = 0, compared = 0,
           all = 0, longest = 0;
    const auto run = test::watch_steps(simulation, [&](const Step& step) {
      if (step.t0 == 0 || step.t1 >= scene.run.duration) return;
      const double t = 0.5 * (step.t0 + step.t1);
      longest = std::max(longest, step.t1 - step.t0);
      all += step.t1 - step.t0;
      const auto exact = reference::four_bar_forces(bar, t),
                 before = reference::four_bar_forces(bar, step.t0),
                 after = reference::four_bar_forces(bar, step.t1);
      // Friction has no unique direction where a pivot reverses within a step or is slower than
      // twice the regularisation.
      for (std::size_t p = 0; p < 4; ++p)
        if (before.spin[p] * after.spin[p] <= 0 || std::abs(exact.spin[p]) * bar.r < 2e-6) return;
      compared += step.t1 - step.t0;
      step.forces(t, now);
      torque = std::max(torque, std::abs(exact.torque));
      torque_off = greatest(torque_off, std::abs(now.elements[motor].m - exact.torque));
      for (std::size_t p = 0; p < 4; ++p) {
        couple = std::max(couple, std::abs(exact.couple[p]));
        couple_off = greatest(couple_off, std::abs(now.elements[rubs[p]].m - exact.couple[p]));
        force = std::max(force, std::hypot(exact.force[p][0], exact.force[p][1]));
        force_off = greatest(force_off, std::hypot(now.elements[joints[p]].fx - exact.force[p][0],
                                                   now.elements[joints[p]].fy - exact.force[p][1]));
      }
    });
    const double bound = way.fixed() ? 1e-4 : way.chosen() ? std::pow(3 * bar.speed * longest, 2) / 24 : 1e-6;
    const char* const why =
        "time stepping: the mean force of a step differs from that at its middle by (n ω h)²/24 in the "
        "n-th harmonic; adaptive "
        "steps: n = 3 and the longest step; fixed steps: 4e-7, and drift of (ω h)² = 1e-6 at reversals, "
        "margin of 100; else "
        "1e-10 per step, of lower order in the dense output";
    const char* const source = "references/joint_friction: Newton–Euler equations";
    const auto name = [&](const char* quantity) {
      return claim_name("four-bar with friction in all pivots", quantity, way.name);
    };
    f.at_most(name("driving torque, greatest error over greatest torque"), "", torque_off / torque, bound,
              source, why);
    f.at_most(name("friction couples, greatest error over greatest couple"), "", couple_off / couple, bound,
              source, why);
    f.at_most(name("reactions, greatest error over greatest force"), "", force_off / force, bound, source,
              why);
    f.at_most(name("share of time excluded at reversals of pivots"), "", 1 - compared / all, 0.05, "0",
              "some reversals per turn, a step each");
    f.at_most(
        name("error of the energy balance over the work of friction"), "",
        std::abs(run.ledger.closure()) / run.ledger.friction,
        way.fixed()    ? 1e-5
        : way.chosen() ? 1e-3
                       : 1e-6,
        "0",
        "fixed steps: (ω h)² and the steps of reversals; adaptive steps: tolerance; else 1e-10 per step");
  }
}

}  // namespace

Parts joint_friction() { return {wheels, stribeck, rotors, blocks, pendulums, impacts, four_bars}; }

}  // namespace freeplay::verification
