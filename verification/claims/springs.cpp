// Nonlinear springs, one-way springs (cables) and bushings: by every scheme against closed forms.
#include "verification/references/springs.hpp"
#include "io/scene/read_scene.hpp"
#include "verification/claims/claim.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

using test::Way;
constexpr double step = 1e-4;
const Way ways[] = {test::penalty, test::event_driven, test::automatic, test::chosen_steps,
                    test::fixed_steps(step, "Moreau–Jean, h = 1e-4 s")};

/// Final state. Throws when the run does not finish.
State end_of(Scene scene, const Way& way) {
  way.choose(scene);
  scene.nonsmooth.step_tolerance = 1e-9;
  return test::finished(scene, way.family).final_state;
}
State end_of(const std::string& text, const Way& way) { return end_of(parse_scene(text, "spring"), way); }

/// Bounds: for integrators with error control, for adaptive time steps, for fixed steps of 1e-4 s.
struct Bounds {
  double adaptive, chosen, fixed;
  const char* reason;
  double of(const Way& way) const { return way.fixed() ? fixed : way.chosen() ? chosen : adaptive; }
};
constexpr const char* usual =
    "tolerance 1e-9 per step over some thousand steps; fixed steps: phase lag (ωh)²/24 of ωt, margin of two";

/// One mass at (x, 0), velocity (v, 0), on a spring from the origin.
std::string on_spring(double mass, double x, double v, double duration, const std::string& spring) {
  return test::body("mass", mass, 1.0, fmt::format("position = [{}, 0.0]\nvelocity = [{}, 0.0]\n", x, v)) +
         fmt::format(
             "[loads.spring]\ntype = \"spring-damper\"\nbetween = [\"ground\", \"mass\"]\n"
             "{}\n",
             spring) +
         test::run_for(duration, "start = \"given\"\n");
}

void nonlinear(Findings& f) {
  // ω = 28 rad/s at the greatest: (ωh)²/24 ωt A = 9e-8 m.
  const double A = 0.1, k = 200, c = 4e4, m = 0.5, t = 1.3;
  const Bounds bounds{1e-6, 1e-6, 1e-6, usual};
  const auto cubic = on_spring(m, 0.5 + A, 0, t, "stiffness = 200\nfree_length = 0.5\ncubic = 4e4");
  const auto torsional = test::body("rotor", 1.0, m, fmt::format("angle = {}\n", A)) +
                         test::torsion("spring", "ground", "rotor", k, fmt::format("cubic = {}\n", c)) +
                         test::run_for(t, "start = \"given\"\n");
  for (const auto& way : ways) {
    f.within(claim_name("hardening spring (Duffing)", "extension after 1.3 s", way.name), "m",
             end_of(cubic, way).q[0] - 0.5, reference::duffing(m, k, c, A, t), bounds.of(way),
             "A cn(Ωt): references/springs", bounds.reason);
    f.within(claim_name("hardening torsional spring", "angle after 1.3 s", way.name), "rad",
             end_of(torsional, way).q[2], reference::duffing(m, k, c, A, t), bounds.of(way),
             "A cn(Ωt): references/springs", bounds.reason);
    const auto preloaded = on_spring(1, 0.5, 0, 1, "stiffness = 100\nfree_length = 0.5\npreload = 5");
    f.within(claim_name("spring of 100 N/m with a preload of 5 N", "distance after 1 s", way.name), "m",
             end_of(preloaded, way).q[0], 0.45 + 0.05 * std::cos(10.0), bounds.of(way),
             "oscillation about free_length − preload/stiffness", bounds.reason);
    const auto table = on_spring(1, 0.55, 0, 1, "force_table = [[0.4, -10], [0.5, 0], [0.52, 2], [0.6, 10]]");
    f.within(claim_name("spring with a linear force table", "distance after 1 s", way.name), "m",
             end_of(table, way).q[0], 0.5 + 0.05 * std::cos(10.0), bounds.of(way), "linear spring of 100 N/m",
             bounds.reason);
    const auto damper = on_spring(
        1, 0.55, 0, 1,
        "stiffness = 100\nfree_length = 0.5\ndamping_table = [[-1, -2], [0, 0], [0.3, 0.6], [1, 2]]");
    f.within(claim_name("spring and damper with a linear damping table", "distance after 1 s", way.name), "m",
             end_of(damper, way).q[0], 0.5 + reference::damped(1, 100, 2, 0.05, 1), bounds.of(way),
             "linear damper of 2 N s/m: references/springs", bounds.reason);
  }
}

void kinked(Findings& f) {
  // Two rates: after two periods and a quarter of the stiffer oscillation it passes the knee at
  // full speed.
  const double t = 2 * (M_PI / 10 + M_PI / 30) + 0.5 * M_PI / 30;
  const auto knee = on_spring(1, 0.55, 0, t, "force_table = [[0.0, -50], [0.5, 0], [1.0, 450]]");
  for (const auto& way : ways) {
    // A fixed step evaluates the force at its middle: at each of five knees the momentum errs by up
    // to k v h².
    const Bounds bounds{1e-7, 1e-6, 5e-6,
                        "tolerance 1e-9 per step; fixed steps: (ωh)²/2 of the amplitude at each of 5 knees"};
    f.within(claim_name("spring of two rates (100 and 900 N/m)", "position after two periods, at the knee",
                        way.name),
             "m", end_of(knee, way).q[0], 0.5, bounds.of(way), "period π/ω₁ + π/ω₂", bounds.reason);
  }
  // A cable of 1e8 N/m at 1 kg is taut for 0.31 ms, once a second.
  const double k = 1e8;
  const auto cable = on_spring(1, 0, 2, 5, "stiffness = 1e8\nfree_length = 1\none_way = \"pull\"");
  // A throw of 0.8 m under gravity that a cable ends just below its apex.
  const double u = 0.05, g = 9.81, up = std::sqrt(u * u + 2 * g * 0.8), rate = 1e4;
  const double T = 2 * (up - u) / g + reference::taut_in_throw(u, rate, g);
  const auto thrown =
      "gravity = [0.0, -9.81]\n" +
      test::body("mass", 1.0, 1.0, fmt::format("position = [0.0, 0.2]\nvelocity = [0.0, {:.17g}]\n", up)) +
      test::spring("cable", "ground", "mass", {}, {}, 1e8, 1.0, "one_way = \"pull\"\n") +
      test::run_for(T, "start = \"given\"\n");
  const Bounds bounds{
      1e-6, 1e-5, 0,
      "tolerance 1e-9 of a speed of 2 m/s, a hundred steps; an undetected cable causes an error of 1 m"};
  for (const auto& way : ways) {
    if (way.step > 0) continue;  // ωh = 1: too long a step for this cable
    f.within(
        claim_name("mass on a stiff cable, taut for 0.31 ms once a second", "position after 5 s", way.name),
        "m", end_of(cable, way).q[0], reference::on_a_cable(1, k, 1, 2, 5), bounds.of(way),
        "half a period taut, else free flight: references/springs", bounds.reason);
    const auto end = end_of(thrown, way);
    f.within(
        claim_name("throw ended by a cable at its apex", "height on return", way.name), "m", end.q[1], 0.2,
        bounds.of(way), "ẍ = −g − ω² x while taut: references/springs",
        "tolerance 1e-9 of a speed, a hundred steps; without the cable it returns 10 ms later, 4 cm off");
  }
  const auto soft = on_spring(1, 0, 2, 5, "stiffness = 1e4\nfree_length = 1\none_way = \"pull\"");
  const auto torsional =
      test::body("rotor", 1.0, 1.0, "angle = 0.0\nangular_velocity = 2.0\n") +
      test::torsion("upper", "ground", "rotor", 1e4, "free_angle = 1.0\none_way = \"pull\"\n") +
      test::torsion("lower", "ground", "rotor", 1e4, "free_angle = -1.0\none_way = \"push\"\n") +
      test::run_for(5.0, "start = \"given\"\n");
  for (const auto& way : ways) {
    const Bounds softer{1e-6, 1e-5, 5e-4,
                        "tolerance 1e-9 of a speed, a hundred steps; "
                        "fixed steps: (ωh)²/2 = 5e-5 of the speed at each of 10 kinks"};
    f.within(claim_name("mass on a cable of 1e4 N/m", "position after 5 s", way.name), "m",
             end_of(soft, way).q[0], reference::on_a_cable(1, 1e4, 1, 2, 5), softer.of(way),
             "half a period taut, else free flight: references/springs", softer.reason);
    f.within(claim_name("rotor between two one-way torsional springs", "angle after 5 s", way.name), "rad",
             end_of(torsional, way).q[2], reference::on_a_cable(1, 1e4, 1, 2, 5), softer.of(way),
             "half a period in contact, else free rotation: references/springs", softer.reason);
  }
}

void bushings(Findings& f) {
  const double c = 0.8, s = 0.6, t = 1;  // of the axis
  const auto text = test::body("block", 2.0, 0.1,
                               fmt::format("position = [{:.17g}, {:.17g}]\nangle = 0.3\n",
                                           c * 0.02 - s * 0.01, s * 0.02 + c * 0.01)) +
                    R"([loads.bushing]
type = "bushing"
between = ["ground", "block"]
axis = [0.8, 0.6]
stiffness = [200.0, 1800.0]
damping = [4.0, 0.0]
torsional_stiffness = 14.4
free_angle = 0.1
)" + test::run_for(1.0, "start = \"given\"\n");
  const double along = reference::damped(2, 200, 4, 0.02, t), across = 0.01 * std::cos(30 * t),
               angle = 0.1 + 0.2 * std::cos(12 * t);
  for (const auto& way : ways) {
    const Bounds bounds{1e-7, 1e-6, 1e-6, usual};
    const auto q = end_of(text, way).q;
    f.within(claim_name("bushing", "displacement along its axis after 1 s, √(k/m) = 10/s, damped", way.name),
             "m", c * q[0] + s * q[1], along, bounds.of(way), "damped oscillator: references/springs",
             bounds.reason);
    f.within(claim_name("bushing", "displacement across its axis after 1 s, √(k/m) = 30/s", way.name), "m",
             c * q[1] - s * q[0], across, bounds.of(way), "A cos ωt", bounds.reason);
    f.within(claim_name("bushing", "angle after 1 s, √(k/J) = 12/s", way.name), "rad", q[2], angle,
             bounds.of(way), "φ₀ + A cos ωt", bounds.reason);
  }
  // Two free bodies: the forces of the bushing on both act at one point, so that the angular
  // momentum is constant.
  const auto pair = read_scene(test::scene_file("bodies_on_bushing"));
  const auto momentum = [](const std::vector<double>& q, const std::vector<double>& v) {
    return (q[0] * v[1] - q[1] * v[0]) + 0.02 * v[2] + 2 * (q[3] * v[4] - q[4] * v[3]) + 0.05 * v[5];
  };
  const double before = momentum({0, 0, 0, 0.5, 0.03, 0}, {0.3, -0.1, 3, 0.1, 0.4, -2});
  for (const auto& way : ways) {
    const auto end = end_of(pair, way);
    f.within(
        claim_name("two free bodies on a bushing", "angular momentum after 2 s", way.name), "kg m²/s",
        momentum(end.q, end.v), before, way.step > 0 ? 1e-4 : 1e-6, "conservation",
        "tolerance 1e-9 per step; a fixed step evaluates forces at its middle, momenta at its ends: (ωh)²");
  }
}

/// The compression x of a press's bushing on its die (m): k x + m g = K δ^(3/2), x + δ = s, with
/// Hertz's K of a ball on a plane.
double pressed(double k, double weight, double K, double s) {
  double x = s;
  for (int i = 0; i < 50; ++i) x = s - std::pow((k * x + weight) / K, 2.0 / 3);
  return x;
}

/// cases/press, ten times slower: the ram rests on its die, and the bushing is compressed by the
/// height of the die above the punch's lowest position.
void press(Findings& f) {
  auto scene = read_scene(test::source_folder() / "cases/press/scene.toml",
                          {"drives.motor.speed_rpm=6", "run.revolutions=0.5"});
  for (auto& b : scene.mechanism.bodies) {
    if (b.velocity) b.velocity = 0.1 * *b.velocity;
    if (b.angular_velocity) *b.angular_velocity *= 0.1;
  }
  for (const auto& way : ways) {
    if (way.chosen()) continue;  // covered by the automatic scheme
    scene.nonsmooth.scheme = way.scheme;
    if (way.step > 0) scene.nonsmooth.step = 0.2 * way.step;
    const auto run = test::finished(scene, way.family);
    const auto& q = run.final_state.q;
    // Two surfaces of one steel: 1/E* = 2 (1 − ν²)/E.
    const double K = 2.0 / 3 * 2.07e11 / (1 - 0.3 * 0.3) * std::sqrt(0.02);
    const bool soft = way.family == Family::penalty;
    f.within(claim_name("press at 6 rpm", "compression of its bushing at the lower dead centre",
                        way.fixed() ? "Moreau–Jean, h = 2e-5 s" : way.name),
             "m", q[7] - (q[4] + 0.125 * std::sin(q[5])), soft ? pressed(5e6, 20 * 9.81, K, 3e-4) : 3e-4,
             1e-7,
             soft ? "overlap of 0.3 mm less Hertz's penetration under bushing force and weight"
                  : "the die is 0.3 mm above the punch's lowest position",
             "bounces of 1e-5 m have decayed by e^−16: the ram oscillates at 500/s");
  }
}

}  // namespace

Parts springs() { return {nonlinear, kinked, bushings, press}; }

}  // namespace freeplay::verification
