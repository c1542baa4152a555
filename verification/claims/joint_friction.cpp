// Friction in ideal joints, bounded by their own reactions: closed forms of pins and guides, an impact, and a four-bar
// against Newton and Euler by hand, in all formulations.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/four_bar_friction.hpp"
#include "verification/references/joint_friction.hpp"
#include "verification/support/support.hpp"
#include "verification/support/ways.hpp"

namespace freeplay::verification {
namespace {

constexpr double h = 1e-4;  // s, of fixed steps

using test::Way;
const Way ways[] = {
    {"penalty", Family::penalty, {}, 0, {"penalty.integrator=\"rosenbrock4\"", "penalty.tolerance=1e-10"}},
    test::fixed_steps(h),
    test::chosen_steps,
    test::event_driven,
    test::automatic};

/// One body on one joint with friction.
std::string one(double spin, const std::string& body, const std::string& joint, const std::string& friction,
                double duration, const std::string& more = "") {
  return fmt::format(
      "gravity = [0, -9.81]\n[bodies.b]\nangular_velocity = {}\n{}\n[joints.j]\nbetween = [\"ground\", \"b\"]\n{}\n"
      "[loads.rub]\ntype = \"joint-friction\"\njoint = \"j\"\nregularisation = 1e-6\n{}\n[run]\nduration = {}\n{}",
      spin, body, joint, friction, duration, more);
}

std::string said(const char* what, const Way& way) { return fmt::format("{}, {}", what, way.name); }

constexpr const char* constant =
    "the forces are constant: rounding of the steps, and of a tolerance of 1e-10";
constexpr const char* wheel_body = "mass = 2.0\ninertia = 0.01";
constexpr const char* pin = "type = \"revolute\"";

void wheels(Findings& f) {
  const double alpha = reference::wheel_deceleration(0.2, 0.02, 2, 9.81, 0.01);
  const auto friction = "friction = 0.2\npin_radius = 0.02";
  for (const auto& way : ways) {
    const auto run = test::finished(way, one(30, wheel_body, pin, friction, 0.5));
    f.relative(said("a wheel on its pin: speed after 0.5 s", way), "rad/s", run.final_state.v[2],
               30 - 0.5 * alpha, 1e-9, "ω̇ = −μ r m g/J", constant);
    const double lost = 0.5 * 0.01 * (900 - std::pow(30 - 0.5 * alpha, 2));
    f.relative("the same: lost to friction in the books", "J", run.ledger.friction, lost, 1e-8,
               "½ J (ω₀² − ω²)", constant);
    const auto back = test::finished(way, one(-30, wheel_body, pin, friction, 0.5));
    f.within("the same, turning the other way: sum of both speeds", "rad/s",
             back.final_state.v[2] + run.final_state.v[2], 0, 1e-12 * 30, "mirror image", "rounding");
    const auto still = test::finished(way, one(3, wheel_body, pin, friction, 0.6));
    // The regularised couple is linear below 1e-6 m/s.
    f.at_most(said("the same from 3 rad/s, which last 0.382 s: speed after 0.6 s", way), "rad/s",
              std::abs(still.final_state.v[2]), way.penalty() ? 1e-6 / 0.02 : 1e-9, "it stands",
              "penalty: the speed of its regularisation over r; else rounding");
    f.within(
        "the same: angle it came to", "rad", still.final_state.q[2], 4.5 / alpha, 3e-6, "ω₀²/(2 ω̇)",
        "penalty: 1e-6/r times the rest of the time; time stepping: ω̇ h² of the step that it stands in, 8e-8; chosen "
        "steps: their tolerance, 1e-6");
    const auto none = test::finished(way, one(30, wheel_body, pin, "friction = 0.0\npin_radius = 0.02", 0.5));
    f.within(said("the same with μ = 0: speed", way), "rad/s", none.final_state.v[2], 30, 3e-14 * 30,
             "nothing resists", "rounding");
    const auto thin = test::finished(way, one(30, wheel_body, pin, "friction = 0.2\npin_radius = 1e-9", 0.5));
    f.within("the same with a pin of 1e-9 m: loss of speed over that of 0.02 m", "",
             (30 - thin.final_state.v[2]) / (0.5 * alpha), way.penalty() ? 1.5e-9 : 5e-8, 1e-12,
             "in proportion to r; penalty: u = r ω is 3e-8 m/s, a thirtieth of the regularisation's",
             "1e-14 of 30 rad/s over 3.9 rad/s, and room of ten");
  }
}

void stribeck(Findings& f) {
  const double T = reference::stribeck_time(0.1, 0.3, 0.05, 0.02, 2, 9.81, 0.01, 5, 1);
  for (const auto& way : ways) {
    const auto run = test::finished(
        way, one(5, wheel_body, pin,
                 "friction = 0.1\npin_radius = 0.02\nstatic_friction = 0.3\nstribeck_speed = 0.05", T));
    f.relative(
        said("a wheel by Stribeck's law: speed when it should be 1 rad/s", way), "rad/s",
        run.final_state.v[2], 1,
        way.fixed()    ? 1e-5
        : way.chosen() ? 1e-4
                       : 1e-7,
        "∫ J dω/(r m g μ(rω)) by Simpson's rule",
        "time stepping: (h/τ)² with τ ≥ 0.05 s in which μ changes, 4e-6, and room; chosen steps: their tolerance "
        "over some hundred steps; else 1e-10 in a step");
  }
}

void rotors(Findings& f) {
  const reference::EccentricRotor rotor{0.3, 0.05, 2, 0.04, 0.01 + 2 * 0.04 * 0.04};
  const double w0 = 20, T = 0.5;
  for (const auto& way : ways) {
    const auto run = test::finished(
        way,
        one(w0, "mass = 2.0\ninertia = 0.01\nposition = [0.04, 0]\nvelocity = [0, 0.8]",
            "type = \"revolute\"\nat = [[0, 0], [-0.04, 0]]", "friction = 0.3\npin_radius = 0.05", T),
        {"gravity=[0,0]"});
    f.relative(
        said("a rotor whose friction holds its own reaction: speed after 0.5 s", way), "rad/s",
        run.final_state.v[2], rotor.speed(w0, T),
        way.fixed()    ? 4e-6
        : way.chosen() ? 1e-4
                       : 1e-7,
        "ω₀/(1 + c ω₀ t), c = k/√(1 − k²), k = μ r m ε/J",
        "time stepping: (ω h)² = 4e-6; chosen steps: their tolerance over some hundred steps; else 1e-10 in a step");
    f.at_most("the same: energy that the books do not explain, over the first", "",
              std::abs(run.ledger.closure()) / run.ledger.initial,
              way.fixed()    ? 4e-6
              : way.chosen() ? 1e-4
                             : 1e-7,
              "energy", "as the speed");
  }
}

void blocks(Findings& f) {
  const auto block = "mass = 3.0\ninertia = 1.0";
  const auto guide = "type = \"translational\"";
  const auto pull = [](double force) {
    return fmt::format("[loads.pull]\ntype = \"force\"\nbody = \"b\"\nforce = [{}, 0]\n", force);
  };
  for (const auto& way : ways) {
    const double weight = 3 * 9.81, mu = 0.25;
    for (const double side : {1.0, -1.0}) {
      const auto run = test::finished(way, one(0, block, guide, "friction = 0.25", 0.4, pull(side * 12)));
      f.within(
          said(side > 0 ? "a block pulled along its guide by 12 N: speed after 0.4 s" : "pulled to the left",
               way),
          "m/s", run.final_state.v[0], side * 0.4 * (12 - mu * weight) / 3,
          way.penalty()  ? 2e-6
          : way.chosen() ? 1e-6
                         : 1e-9,
          "(F − μ m g)/m",
          "penalty: the speed of the regularisation, twice; chosen steps: their tolerance; else rounding");
    }
    const auto held =
        test::finished(way, one(0, block, guide, "friction = 0.25", 0.4, pull(0.99 * mu * weight)));
    f.at_most(said("the same with 0.99 μ m g: speed", way), "m/s", std::abs(held.final_state.v[0]),
              way.penalty() ? 1e-6 : 1e-12, "it holds",
              "penalty: it creeps below the regularisation's speed; else none");
    // A force along the axis, b off it, on a slider of length L: no weight, the couple alone presses.
    for (const double b : {0.15, 0.3}) {
      const double k = reference::cantilever_share(0.25, b, 0.1);
      const auto run = test::finished(
          way,
          one(0, block, guide, "friction = 0.25\nslider_length = 0.1", 0.4,
              fmt::format("[loads.pull]\ntype = \"force\"\nbody = \"b\"\nat = [0, {}]\nforce = [6, 0]\n", b)),
          {"gravity=[0,0]"});
      f.within(
          said(k < 1 ? "pulled off its axis, 2 μ b/L = 0.75: speed after 0.4 s"
                     : "the same, 2 μ b/L = 1.5: self-locking, speed",
               way),
          "m/s", run.final_state.v[0], k < 1 ? 0.4 * (1 - k) * 6 / 3 : 0,
          way.penalty()  ? 2e-6
          : way.chosen() ? 1e-6
                         : 1e-9,
          "(1 − 2 μ b/L) F/m",
          "penalty: the speed of the regularisation, twice; chosen steps: their tolerance; else rounding");
    }
  }
}

/// A pendulum let go beside its lowest point stays where the weight passes the friction circle.
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
      f.within(
          said(share < 1 ? "a pendulum 2 % within its friction angle: speed after 0.1 s"
                         : "the same 2 % beyond",
               way),
          "rad/s", run.final_state.v[2], share < 1 ? 0 : expected,
          share < 1 ? (way.penalty() ? 1e-6 / r : 1e-9)
                    : 0.01 * std::abs(expected) + 2e-6 / r * (way.penalty()),
          "rest while l sin θ ≤ μ r, else δ' = −δ₀ Ω sin Ω t about the angle where l sin θ = μ r, Ω² = m g l/J",
          "within: as above; beyond: 1 %, for |F| is m g up to l ω̇/g and ω², 1e-3, and penalty its regularisation");
    }
}

/// A rod on a pin strikes a wall: the pin's impulse bounds a friction impulse.
void impacts(Findings& f) {
  const double mu = 0.4, r = 0.05, m = 1, l = 0.15, a = 0.35, J = 0.01 + m * l * l, e = 0.5;
  const auto text = one(
      -5, fmt::format("mass = 1.0\ninertia = 0.01\nposition = [{}, 0.0]\nangle = 0.02", l),
      "type = \"revolute\"\nat = [[0, 0], [-0.15, 0]]", "friction = 0.4\npin_radius = 0.05", 0.02,
      "[surfaces.s]\nrestitution = 0.5\n[contacts.wall]\ntype = \"plane\"\nbetween = [\"ground\", \"b\"]\n"
      "at = [[0, 0], [0.2, 0]]\nsurface = \"s\"\n");
  for (const auto& way : ways) {
    if (way.penalty()) continue;  // its friction follows the speed within the impact: another law
    const auto run = test::finished(way, text, {"gravity=[0,0]"});
    const auto hit = test::touch(run, 0);
    f.relative(
        said("a rod on a pin strikes a wall: impulse over approach speed", way), "N s²/m",
        hit.impulse_n / -hit.v_n_minus, reference::rod_impulse(mu, r, m, l, a, J, e, 1), 1e-4,
        "J_p (1 + e) w = a P − μ r |Λ|",
        "time stepping: the step's own m l ω² h beside m l (1 + e) ω across it, and the angle ω h at the touch, squared: 1e-7; "
        "what lasts in the event's step; room");
    f.relative("the same: its speed after over before", "", hit.v_n_plus / -hit.v_n_minus, e,
               way.fixed() ? 1e-3 : 1e-6, "Newton's law",
               "time stepping: ω̇ h/ω of the step, 1e-4, and room; else rounding");
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
    const auto find = [&](const std::string& name) {
      for (std::size_t i = 0; i < layout.forces.size(); ++i)
        if (layout.forces[i].name == name) return i;
      throw std::runtime_error("no element " + name);
    };
    const std::array<std::size_t, 4> joints{find("A0"), find("A"), find("B"), find("B0")},
        rubs{find("rub_A0"), find("rub_A"), find("rub_B"), find("rub_B0")};
    const auto motor = find("motor");
    Forces now{std::vector<ElementForce>(layout.forces.size()), std::vector<double>(9)};
    double torque = 0, torque_off = 0, couple = 0, couple_off = 0, force = 0, force_off = 0, compared = 0,
           all = 0, longest = 0;
    test::Listener listener;
    listener.want.forces = true;
    listener.on_step = [&](const Step& step) {
      if (step.t0 == 0 || step.t1 >= scene.run.duration) return;
      const double t = 0.5 * (step.t0 + step.t1);
      longest = std::max(longest, step.t1 - step.t0);
      all += step.t1 - step.t0;
      const auto exact = reference::four_bar_forces(bar, t),
                 before = reference::four_bar_forces(bar, step.t0),
                 after = reference::four_bar_forces(bar, step.t1);
      // Where a pivot turns round within a step, or is slower than twice the regularisation, there is no one direction.
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
    };
    const auto run = test::finished(simulation, {&listener});
    const double bound = way.fixed() ? 1e-4 : way.chosen() ? std::pow(3 * bar.speed * longest, 2) / 24 : 1e-6;
    const char* const why =
        "time stepping: forces of a step are its mean, (n ω h)²/24 off its middle in the n-th harmonic, n = 3 for chosen steps "
        "by the longest of them; of fixed ones 4e-7, and drift of the order (ω h)², 1e-6, at the reversals' kinks, room of a "
        "hundred; else 1e-10 in a step, the dense output's order lower";
    const char* const source = "references/four_bar_friction: Newton and Euler";
    f.at_most(
        said("four-bar with friction in all pivots: torque of the drive, greatest error over greatest", way),
        "", torque_off / torque, bound, source, why);
    f.at_most("the same: couples of friction", "", couple_off / couple, bound, source, why);
    f.at_most("the same: reactions", "", force_off / force, bound, source, why);
    f.at_most("the same: share of the time that is not compared, where a pivot turns round", "",
              1 - compared / all, 0.05, "", "some reversals a turn, a step each");
    f.at_most(
        "the same: energy that the books do not explain over what friction took", "",
        std::abs(run.ledger.closure()) / run.ledger.friction,
        way.fixed()    ? 1e-5
        : way.chosen() ? 1e-3
                       : 1e-6,
        "energy",
        "time stepping: (ω h)² and a reversal's step; chosen steps: their tolerance; else 1e-10 in a step");
  }
}

}  // namespace

Findings joint_friction() {
  Findings f;
  wheels(f);
  stribeck(f);
  rotors(f);
  blocks(f);
  pendulums(f);
  impacts(f);
  four_bars(f);
  return f;
}

}  // namespace freeplay::verification
