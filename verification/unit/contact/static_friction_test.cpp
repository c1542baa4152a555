// Friction of surfaces with a static value: refusals of the reader and of penalty laws, closed forms, and
// references that integrate the equations between located events. All blocks touch the floor in their centre,
// so that they do not tilt and N = m g.
#include "dynamics/system.hpp"
#include "formulations/contact/friction_law.hpp"
#include "formulations/time_stepping/lane_functions.hpp"
#include "io/scene/write_scene.hpp"
#include "verification/property/comparison/snapshot_check.hpp"
#include "verification/references/dry_coordinate.hpp"
#include "verification/support/rig.hpp"
#include "verification/unit/variation/varied_scenes.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

constexpr double stiffness = 1e8;  // N/m, of penalty contacts
const test::Way by_penalty{
    "penalty, andersson",
    Family::penalty,
    {},
    0,
    {"penalty.integrator=\"rosenbrock4\"", "penalty.tolerance=1e-10", "penalty.contact=\"kelvin-voigt\"",
     "penalty.kelvin_stiffness=1e8", "penalty.kelvin_damping=1e5", "penalty.friction=\"andersson\"",
     "penalty.friction_v0=1e-7"}};
const test::Way ways[] = {by_penalty, test::event_driven, test::fixed_steps(1e-4), test::chosen_steps,
                          test::automatic};

/// A block on a plane of `on`, in equilibrium with gravity of 10 m/s² by the penalty formulation.
std::string block(const test::Way& way, double mass, double speed, const std::string& on = "ground",
                  const std::string& name = "b") {
  return test::body(name, mass, 1,
                    fmt::format("position = [0, {}]\nvelocity = [{}, 0]\n",
                                way.penalty() ? -10 * mass / stiffness : 0, speed)) +
         test::plane(name + "_floor", on, name, 0, "s");
}
std::string scene_of(const std::string& parts, const std::string& surface, double duration) {
  return "gravity = [0, -10]\n" + parts + "[surfaces.s]\nrestitution = 0.5\n" + surface +
         test::run_for(duration, "start = \"given\"\n");
}

const std::string steep = "friction = 0.2\nstatic_friction = 0.5\nstribeck_speed = 0.1\n";

/// 2 kg under a force of 10 N/s t: it slips at 1 s.
std::string ramped(const test::Way& way, double duration) {
  return scene_of(block(way, 2, 0) + test::table("ramp", "[[0, 0], [2, 20]]") +
                      test::force("push", "b", {1, 0}, "factor = \"ramp\"\n"),
                  steep, duration);
}

/// With exponent 1, m v̇ = −(F + R e^{−v/w}) with F = 4 N, R = 6 N: the time from u to v is
/// m w/F [ln(F e^{u/w} + R) − ln(F e^{v/w} + R)].
double slowing_time(double u, double v) {
  const double m = 2, w = 0.1, F = 4, R = 6;
  const auto at = [&](double x) { return m * w / F * std::log(F * std::exp(x / w) + R); };
  return at(u) - at(v);
}
const std::string exponential = steep + "stribeck_exponent = 1\n";

/// A block of 1 kg on a belt with 0.1 m/s, held by a spring of 100 N/m, with 10 N of static and 5 N of kinetic
/// friction (the scene of fixed_friction_test.cpp).
std::string belt(const test::Way& way, double duration, const std::string& more = "") {
  return scene_of(test::body("belt", 1, 1, "velocity = [0.1, 0]\n") + block(way, 1, 0.1, "belt") +
                      test::guide("rail", "ground", "belt") + test::table("pace", "[[0, 0.1], [1, 0.1]]") +
                      test::drive("motor", "rail", "velocity = \"pace\"\n") +
                      test::spring("spring", "ground", "b", {-1, 0}, {}, 100, 1) + more,
                  "friction = 0.5\nstatic_friction = 1\nstribeck_speed = 0.05\n", duration);
}

/// A block of 1 kg without weight that meets the floor at 0.1 s.
std::string thrown(double along, double down) {
  return test::body("b", 1, 1,
                    fmt::format("position = [0, {}]\nvelocity = [{}, {}]\n", 0.1 * down, along, -down)) +
         test::plane("floor", "ground", "b", 0, "s") + "[surfaces.s]\nrestitution = 0.5\n" + steep +
         test::run_for(0.15, "start = \"given\"\n");
}

}  // namespace

TEST_CASE("invalid keys of a surface's static friction are refused", "[friction]") {
  const auto with = [](const std::string& surface) {
    return scene_of(block(test::event_driven, 1, 0), surface, 1);
  };
  test::check_messages(
      [](const std::string& text) { return test::refusal(text); },
      {{with("static_friction = 0.3\nstribeck_speed = 0.1\n"),
        "surfaces.s.static_friction: goes with friction, which is missing"},
       {with("friction = 0.2\nstatic_friction = 0.3\n"), "static_friction and stribeck_speed go together"},
       {with("friction = 0.2\nstribeck_speed = 0.3\n"), "static_friction and stribeck_speed go together"},
       {with("friction = 0.2\nstatic_friction = 0.1\nstribeck_speed = 0.1\n"),
        "surfaces.s.static_friction: must be at least friction, 0.2"},
       {with("friction = 0.2\nstatic_friction = 0.3\nstribeck_speed = 0\n"),
        "surfaces.s.stribeck_speed: must be greater than 0"},
       {with("friction = 0.2\nstribeck_exponent = 2\n"),
        "surfaces.s.stribeck_exponent: goes with stribeck_speed"},
       {with(steep + "stribeck_exponent = 0.5\n"),
        "surfaces.s.stribeck_exponent: must be between 1 and 100"}});
  for (const auto& good : {with(steep), with(exponential)}) {
    const auto scene = parse_scene(good, "s.toml");
    CHECK(to_toml(parse_scene(to_toml(scene), "again")) == to_toml(scene));
  }
}

TEST_CASE("penalty laws take the static value of a surface, or refuse it", "[friction]") {
  const auto refused = [](const std::string& surface, const std::string& law) {
    auto options = by_penalty.options;
    std::erase(options, "penalty.friction=\"andersson\"");
    options.push_back(fmt::format("penalty.friction=\"{}\"", law));
    const auto text = scene_of(block(by_penalty, 1, 0), surface, 1);
    return test::refusal_of<std::exception>(
        [&] { Simulation(parse_scene(text, "s.toml", options), "penalty"); });
  };
  for (const char* law : {"andersson", "lugre"}) {
    CHECK(refused(steep, law) == "accepted");
    CHECK_THAT(refused(exponential, law), Contains("surfaces.s.stribeck_exponent: must be 2 with"));
  }
  CHECK_THAT(refused(steep, "brown-mcphee"),
             Contains("surfaces.s.static_friction: needs penalty.friction = \"lugre\" or \"andersson\""));
  CHECK(refused("friction = 0.2\n", "brown-mcphee") == "accepted");
  CHECK_THAT(
      refused("friction = 0.2\nstatic_friction = 0.5\nstribeck_speed = 1e-8\n", "andersson"),
      Contains("surfaces.s.stribeck_speed: must be greater than penalty.friction_v0 = 1e-07, is 1e-08"));

  Surface surface;
  surface.friction = 0.2;
  surface.peak = {.static_friction = 0.5, .stribeck_speed = 0.1};
  PenaltyOptions o;
  o.friction_v0 = 1e-6;
  for (const double v : {1e-3, 0.05, 0.1, 0.4}) {  // far above v₀, where the regularisation has no effect
    const double mu = 0.2 + 0.3 * std::exp(-v * v / 0.01);
    for (const auto law : {FrictionLaw::andersson, FrictionLaw::lugre}) {
      o.friction = law;
      CHECK(make_friction(o, surface).steady(v) == Approx(mu).epsilon(1e-12));
    }
    CHECK(surface.friction_at(v) == Approx(mu).epsilon(1e-15));
    CHECK(surface.friction_at(-v) == surface.friction_at(v));
    // Central differences: h²/6 of the third derivative of 0.3/w³, and rounding.
    const double h = 1e-6;
    CHECK(surface.friction_slope(v) ==
          Approx((surface.friction_at(v + h) - surface.friction_at(v - h)) / (2 * h)).margin(1e-8));
    CHECK(surface.friction_slope(-v) == -surface.friction_slope(v));
  }
}

TEST_CASE("a block under a ramped force slips at its static friction and then follows the equation",
          "[friction]") {
  reference::DryCoordinate one;
  one.acceleration = [](int side, double t, double, double v) {
    return (10 * t - side * (4 + 6 * std::exp(-v * v / 0.01))) / 2;
  };
  one.step = 1e-4;  // RK4: (h/τ)⁴ with τ = m w/(6 N) = 0.03 s, 1e-10
  const auto exact = one.at({1.2, 1.5});
  for (const auto& way : ways) {
    CAPTURE(way.name);
    const auto held = test::finished(way, ramped(way, 0.99));
    // Penalty: v₀ artanh(F/F_s) of creep, 3e-7 m/s at most.
    CHECK(std::abs(held.final_state.q[0]) < (way.penalty() ? 3e-7 : 1e-12));
    // Penalty: 1e-6 m/s of creep where slip begins, which grows until friction has fallen. Fixed steps: (h/τ)².
    // Adaptive steps: tolerance 1e-6 over some hundred steps, and that growth.
    const double error = way.penalty() || way.fixed() ? 1e-4 : way.chosen() ? 1e-3 : 1e-6;
    for (const int i : {0, 1}) {
      const auto run = test::finished(way, ramped(way, i == 0 ? 1.2 : 1.5));
      CHECK(run.final_state.q[0] == Approx(exact.x[static_cast<std::size_t>(i)]).epsilon(error));
      CHECK(run.final_state.v[0] == Approx(exact.v[static_cast<std::size_t>(i)]).epsilon(error));
    }
  }
}

TEST_CASE("a block with a static value of friction slows down in closed form", "[friction]") {
  const double time = slowing_time(1, 0.1);
  const auto error_of = [&](const test::Way& way) {
    const auto run = test::finished(way, scene_of(block(way, 2, 1), exponential, time));
    CHECK(std::abs(run.ledger.closure()) < 1e-4 * run.ledger.friction);
    return std::abs(run.final_state.v[0] - 0.1);
  };
  CHECK(error_of(test::event_driven) < 1e-7);
  CHECK(error_of(test::automatic) < 1e-7);
  CHECK(error_of(test::chosen_steps) < 1e-4);  // tolerance 1e-6 over some hundred steps
  // The midpoint rule with the coefficient of the mean speed: order 2. (h/τ)² with τ = 0.03 s is at most 4e-3.
  test::check_order(
      {2e-3, 1e-3, 5e-4, 2.5e-4}, [&](double h) { return error_of(test::fixed_steps(h)); }, 1.8, 2.2);
}

TEST_CASE("sliding that a static friction stops within a step of sliding", "[friction]") {
  // 2 kg slide with −v under 5 N; friction falls from 7 N to 4 N. The block decelerates with (9 + 3 e^(−(v/w)²))/2
  // and stays at x = −w²/9 [Y + ln((9 + 3 e^(−Y))/12)], Y = (v/w)². Away from the peak the deceleration is constant,
  // so that the steps are as long as the method allows.
  const auto scene = [](const test::Way& way, const std::string& friction, double w, double v) {
    const auto peak = fmt::format("stribeck_speed = {}\n", w);
    const bool surface = friction == "surface";
    const auto body = surface
                          ? block(way, 2, -v)
                          : test::body("b", 2, 1, fmt::format("velocity = [{}, 0]\n", -v)) +
                                test::guide("j", "ground", "b") +
                                test::joint_friction("rub", "j", friction + peak + "regularisation = 1e-6\n");
    return scene_of(body + test::force("push", "b", {5, 0}, ""),
                    "friction = 0.2\n" + (surface ? "static_friction = 0.35\n" + peak : ""), 1);
  };
  for (const auto& way : {by_penalty, test::event_driven, test::chosen_steps, test::automatic})
    for (const std::string friction :
         {"surface", "friction = 0.2\nstatic_friction = 0.35\n", "force = 4\nstatic_force = 7\n"})
      for (const double w : {2e-3, 5e-3, 2e-2, 0.1})
        for (const double v : {0.3, 1.0, 3.0}) {
          CAPTURE(way.name, friction, w, v);
          const double Y = v * v / (w * w), x = -w * w / 9 * (Y + std::log((9 + 3 * std::exp(-Y)) / 12));
          const auto run = test::finished(way, scene(way, friction, w, v));
          // Penalty: creep of 1e-6 m/s. Adaptive steps: as above.
          CHECK(run.final_state.q[0] == Approx(x).epsilon(way.penalty() || way.chosen() ? 1e-4 : 1e-6));
          CHECK(std::abs(run.final_state.v[0]) < (way.penalty() ? 1e-6 : 1e-12));
        }
}

TEST_CASE("a block on a belt sticks and slips by the static friction of its surface", "[friction]") {
  // As in fixed_friction_test.cpp: slip begins at x = 0.1 m, t = 1 s, and ends 0.404293443543 s later.
  const double slip = 0.404293443543, period = 1.46032830388, end = -0.00560348603414;
  for (const auto& way : ways) {
    CAPTURE(way.name);
    const double error = way.penalty() || way.fixed() ? 1e-4 : way.chosen() ? 5e-3 : 1e-6;
    const auto run = test::finished(way, belt(way, 3));
    CHECK(run.final_state.q[3] == Approx(end + 0.1 * (3 - 1 - period - slip)).margin(0.1 * error));
    CHECK(run.final_state.v[3] == Approx(0.1).margin(way.penalty() ? 1e-6 : 1e-9));
    const auto third = test::finished(way, belt(way, 1 + 2 * period));  // where slip begins again
    CHECK(third.final_state.q[3] == Approx(0.1).margin(0.1 * error));
  }
}

TEST_CASE("static friction of a surface together with joint friction from a reaction", "[friction]") {
  // Friction in the rail of the driven belt changes no motion, beyond the tolerances of the steps.
  const auto rub = test::joint_friction("rub", "rail", "friction = 0.1\n");
  for (const auto& way : {test::event_driven, test::fixed_steps(1e-3), test::chosen_steps}) {
    CAPTURE(way.name);
    const auto alone = test::finished(way, belt(way, 1.6)), both = test::finished(way, belt(way, 1.6, rub));
    CHECK(both.final_state.q[3] == Approx(alone.final_state.q[3]).margin(way.chosen() ? 5e-4 : 1e-7));
    CHECK(both.ledger.friction > alone.ledger.friction);
  }
}

TEST_CASE("an impact has the friction of the sliding speed before it", "[friction][impact]") {
  // Sliding lasts: P_T = −μ(0.1 m/s) P_N, P_N = (1 + e) m v_N = 0.15 N s.
  const double mu = 0.2 + 0.3 * std::exp(-1), after = 0.1 - mu * 1.5 * 0.1;
  REQUIRE(after > 0);
  for (const auto& way : {test::event_driven, test::fixed_steps(1e-3), test::chosen_steps, test::automatic}) {
    CAPTURE(way.name);
    for (const std::string law : {"newton", "poisson", "energetic", "compliant"}) {
      if (law != "newton" && way.scheme != Scheme::event_driven) continue;
      const auto run =
          test::finished(way, thrown(0.1, 0.1),
                         {fmt::format("nonsmooth.impact_law=\"{}\"", law), "surfaces.s.stiffness_ratio=0.8"});
      CHECK(run.final_state.v[0] == Approx(after).epsilon(1e-10));
      CHECK(run.final_state.v[1] == Approx(0.05).epsilon(1e-10));
    }
    // A slow sliding is stopped: 0.01 m/s < μ(0.01 m/s) 0.15 m/s.
    CHECK(std::abs(test::finished(way, thrown(0.01, 0.1)).final_state.v[0]) < 1e-12);
  }
}

TEST_CASE("many contacts with a static value of friction are solved in islands", "[friction]") {
  // 13 blocks have 26 rows, more than one dense problem takes.
  std::string parts;
  for (int i = 0; i < 13; ++i) parts += block(test::event_driven, 2, 1, "ground", fmt::format("b{}", i));
  const auto way = test::fixed_steps(1e-4);
  const double time = slowing_time(1, 0.1);
  const auto many = test::finished(way, scene_of(parts, exponential, time)),
             one = test::finished(way, scene_of(block(way, 2, 1), exponential, time));
  for (std::size_t i = 0; i < 13; ++i)  // coefficients agree to 1e-9 or better
    CHECK(many.final_state.v[3 * i] == Approx(one.final_state.v[0]).epsilon(1e-8));
}

TEST_CASE("steps with a static value of friction take no lanes", "[friction]") {
  for (const auto& [surface, lanes] : {std::pair{std::string("friction = 0.2\n"), true}, {steep, false}}) {
    const auto scene = parse_scene(scene_of(block(test::event_driven, 2, 1), surface, 1), "s.toml");
    CHECK(has_ordinary_steps(System(scene.mechanism)) == lanes);
  }
}

TEST_CASE("snapshots with a static value of friction", "[friction][snapshot]") {
  const auto text = belt(test::event_driven, 1.6);
  for (const char* option :
       {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.step=1e-3", "nonsmooth.scheme=\"moreau-jean\""})
    snapshots::check({text, "nonsmooth", {option}});
}

TEST_CASE(
    "derivatives by the keys of static friction: exact in penalty, refused in the nonsmooth formulation",
    "[friction][sensitivity]") {
  const double time = 0.45;  // from 1 m/s to 0.07 m/s, still sliding
  const std::vector<std::string> keys = {"surfaces.s.friction", "surfaces.s.static_friction",
                                         "surfaces.s.stribeck_speed"};
  const auto speed = [&](std::array<double, 3> p) {
    reference::DryCoordinate one;
    one.acceleration = [=](int, double, double, double v) {
      return -10 * (p[0] + (p[1] - p[0]) * std::exp(-v * v / (p[2] * p[2])));
    };
    one.v = 1, one.step = 1e-4;
    return one.at({time}).v[0];
  };
  const std::array<double, 3> given{0.2, 0.5, 0.1};
  REQUIRE(speed(given) == Approx(0.0722).epsilon(1e-3));
  std::vector<double> expected;
  for (std::size_t i = 0; i < 3; ++i) {
    auto low = given, high = given;
    low[i] -= 1e-5, high[i] += 1e-5;
    expected.push_back((speed(high) - speed(low)) / 2e-5);
  }
  const auto by = [&](const char* formulation, const std::vector<std::string>& options) {
    const auto scene = parse_scene(scene_of(block(test::event_driven, 2, 1), steep, time), "s.toml", options);
    return sensitivities(scene, {.of = {"end.b.vx"}, .to = keys, .formulation = formulation}).quantities[0];
  };
  // The block falls onto a soft floor with critical damping; friction has its constant value meanwhile, and the
  // normal impulse is that of the weight. Differences of the reference: 1e-10/6 of third derivatives.
  test::varied::check_derivatives(
      by("penalty",
         {"penalty.tolerance=1e-10", "penalty.contact=\"kelvin-voigt\"", "penalty.kelvin_stiffness=1e6",
          "penalty.kelvin_damping=3e3", "penalty.friction=\"andersson\"", "penalty.friction_v0=1e-7"}),
      expected, 1e-5);
  CHECK_THAT(by("nonsmooth", {"nonsmooth.scheme=\"event-driven\""}).reasons[0],
             Contains("friction of b_floor depends on the sliding speed (surfaces.s.static_friction)"));
}
