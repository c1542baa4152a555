// Scenes whose periodic motions have closed forms (verification/references/orbits.hpp).
#pragma once

#include "verification/references/orbits.hpp"
#include "verification/references/published/woodpecker.hpp"
#include "verification/references/two_mass_oscillator.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::scenes {

inline const char* const event_driven = "[nonsmooth]\nscheme = \"event-driven\"\ntolerance = 1e-12\n";

/// The scene begins beside the periodic motion by this share of its height and velocity. `duration`: s.
inline std::string shaken_ball(const reference::ShakenBall& b, long double beside, double duration = 1) {
  const long double after = b.period() - b.impact_time();
  return fmt::format("gravity = [0, {:.17g}]\n", -static_cast<double>(b.gravity)) +
         test::body("table", 1, 0.01) +
         test::body("ball", 0.3, 3e-4,
                    fmt::format("position = [0, {:.17g}]\nvelocity = [0, {:.17g}]\n",
                                static_cast<double>(0.05L + b.height(after) * (1 + beside)),
                                static_cast<double>(b.velocity(after) * (1 + beside)))) +
         test::guide("guide", "ground", "table", {0, 1}) + test::guide("rail", "ground", "ball", {0, 1}) +
         test::plane("pair", "table", "ball", 0.05, "hard") +
         test::surface("hard", static_cast<double>(b.restitution)) +
         test::harmonic("shake", static_cast<double>(b.amplitude), static_cast<double>(b.period() / b.number),
                        fmt::format("phase = {:.17g}\n", static_cast<double>(b.start))) +
         test::drive("shaker", "guide", "position = \"shake\"\n") + test::run_for(duration) + event_driven;
}

/// The bodies rest on the table at the middle of its stroke.
inline std::string loaded_table(const reference::LoadedTable& b, long double amplitude) {
  const double radius = 0.05, length = 0.3, start = 2;
  const auto A = static_cast<double>(amplitude), w = static_cast<double>(b.frequency);
  const double at = A * std::sin(start) + radius;
  const auto moving = [&](double height) {
    return fmt::format("position = [0, {:.17g}]\nvelocity = [0, {:.17g}]\n", height, A * w * std::cos(start));
  };
  std::string text =
      fmt::format("gravity = [0, {:.17g}]\n", -static_cast<double>(b.gravity)) +
      test::body("table", 1, 0.01) + test::body("lower", static_cast<double>(b.mass), 0.01, moving(at)) +
      test::guide("guide", "ground", "table", {0, 1}) + test::guide("rail", "ground", "lower", {0, 1});
  if (b.upper > 0) {
    const auto M = static_cast<double>(b.upper), k = static_cast<double>(b.stiffness);
    text += test::body("upper", M, 0.01, moving(at + length - M * static_cast<double>(b.gravity) / k)) +
            test::guide("upper_rail", "ground", "upper", {0, 1}) +
            test::spring("spring", "lower", "upper", {0, 0}, {0, 0}, k, length,
                         fmt::format("damping = {:.17g}\n", static_cast<double>(b.damping)));
  }
  return text + test::plane("pair", "table", "lower", radius, "hard") + test::surface("hard", 0.5) +
         test::harmonic("shake", A, static_cast<double>(b.period()),
                        fmt::format("phase = {:.17g}\n", start)) +
         test::drive("shaker", "guide", "position = \"shake\"\n") +
         test::run_for(1, "start = \"assembled\"\n") + event_driven;
}

/// The force is F sin(Ωt) in the time of the scene, which begins one part in a thousand beside the
/// periodic motion. `impact`: s, its time.
inline std::string impact_oscillator(const reference::ImpactOscillator& o, long double& impact) {
  const auto m = o.motion();
  const long double turn = 2 * std::acos(-1.0L), cycle = turn / o.frequency;
  impact = (m.psi + turn / 4) / o.frequency;
  impact -= cycle * std::floor(impact / cycle);
  const long double after = o.period() - impact;
  return test::body("mass", static_cast<double>(o.mass), 0.01,
                    fmt::format("position = [{:.17g}, 0]\nvelocity = [{:.17g}, 0]\n",
                                static_cast<double>(o.position(m, after) - 1e-3L * std::abs(o.stop)),
                                static_cast<double>(o.velocity(m, after)))) +
         test::guide("rail", "ground", "mass") +
         test::spring("spring", "ground", "mass", {-1, 0}, {0, 0}, static_cast<double>(o.stiffness), 1,
                      fmt::format("damping = {:.17g}\n", static_cast<double>(o.damping))) +
         test::stop("stop", "travel-stop", "rail",
                    fmt::format("upper = {:.17g}\n", static_cast<double>(o.stop)), "hard") +
         test::surface("hard", static_cast<double>(o.restitution)) +
         test::harmonic("force", static_cast<double>(o.force), static_cast<double>(cycle)) +
         test::drive("shaker", "rail", "force = \"force\"\nagainst = \"time\"\n") + test::run_for(1) +
         event_driven;
}

/// The scene begins half a period after the impact.
inline std::string two_mass_oscillator(const reference::TwoMassOscillator& o) {
  const auto m = o.motion();
  const auto y = o.at(m, o.period() / 2);
  const auto number = [](long double x) { return static_cast<double>(x); };
  const auto moving = [&](std::size_t i, double at) {
    return fmt::format("position = [{:.17g}, 0]\nvelocity = [{:.17g}, 0]\n", at + number(y[i]),
                       number(y[i + 2]));
  };
  const auto damped = [&](long double damping) {
    return fmt::format("damping = {:.17g}\n", number(damping));
  };
  return test::body("first", number(o.m1), 0.01, moving(0, 0)) +
         test::body("second", number(o.m2), 0.01, moving(1, 10)) + test::guide("rail", "ground", "first") +
         test::guide("second_rail", "ground", "second", {1, 0}) +
         test::spring("spring", "ground", "first", {-10, 0}, {0, 0}, number(o.k1), 10, damped(o.d1)) +
         test::spring("coupling", "first", "second", {0, 0}, {0, 0}, number(o.k2), 10, damped(o.d2)) +
         "[contacts.stop]\ntype = \"travel-stop\"\njoint = \"rail\"\nupper = 0\n"
         "surface = \"hard\"\n" +
         test::surface("hard", number(o.restitution)) +
         test::harmonic("force", number(o.force), number(o.period()),
                        fmt::format("phase = {:.17g}\n", number(m.phase + o.frequency * o.period() / 2))) +
         test::drive("shaker", "rail", "force = \"force\"\nagainst = \"time\"\n") + test::run_for(1) +
         event_driven;
}

/// The woodpecker toy (cases/published/woodpecker) with its arms divided by `stretch`, inertias and
/// stiffness by its square, and the same clearances: with a small stretch the published model,
/// which is linear in the angles.
inline std::string stretched_woodpecker(const reference::Woodpecker& toy) {
  const auto number = [](long double x) { return static_cast<double>(x); };
  const double a = -0.1034 * number(toy.stretch), b = -0.2788 * number(toy.stretch),
               rate = -7.4583 * number(toy.stretch);
  const double L = number(toy.l_M), G = number(toy.l_G);
  const auto edge = [&](const char* name, double height) {
    return test::plane(fmt::format("{}", name), "ground", "sleeve", 0, "edge",
                       fmt::format("at = [[{:.17g}, 0], [{:.17g}, {:.17g}]]\naxis = [0, -1]\n",
                                   number(toy.r_O), number(toy.r_M), height));
  };
  return "gravity = [0, -9.81]\n" +
         test::body("sleeve", number(toy.sleeve), number(toy.J_M),
                    fmt::format("angle = {:.17g}\nvelocity = [0, -0.3411]\n", a)) +
         test::body(
             "bird", number(toy.bird), number(toy.J_S),
             fmt::format("position = [{:.17g}, {:.17g}]\nangle = {:.17g}\nvelocity = [{:.17g}, {:.17g}]\n"
                         "angular_velocity = {:.17g}\n",
                         L * std::cos(a) + G * std::cos(b), L * std::sin(a) + G * std::sin(b), b,
                         -G * std::sin(b) * rate, -0.3411 + G * std::cos(b) * rate, rate)) +
         R"([joints.pole]
type = "slot"
between = ["ground", "sleeve"]
axis = [0, 1]
)" + test::pin("hinge", "sleeve", "bird", {L, 0}, {-G, 0}) +
         test::torsion("spring", "sleeve", "bird", number(toy.spring)) +
         test::plane("beak", "ground", "bird", 0, "beak",
                     fmt::format("at = [[{:.17g}, 0], [{:.17g}, {:.17g}]]\naxis = [0, -1]\n",
                                 number(toy.r_beak), -number(toy.l_S), number(toy.h_S))) +
         test::surface("beak", 0.5, 0.3) + test::surface("edge", 0, 0.3) + edge("lower", -number(toy.h_M)) +
         edge("upper", number(toy.h_M)) + test::run_for(1) + event_driven;
}

}  // namespace freeplay::verification::scenes
