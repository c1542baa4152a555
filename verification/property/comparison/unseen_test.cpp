// Events between the instants at which an integrator evaluates the motion. The set of claims
// "missed-contacts" contains further cases.
#include <atomic>

#include "dynamics/system.hpp"
#include "verification/support/named.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using std::numbers::pi;

namespace {

Scene thrown(double off, double speed) {
  auto scene = parse_scene(
      test::body("ball", 0.2, 1e-5) + test::surface("s", 0.6, "young = 2e11\npoisson = 0.3\n") +
          test::discs("peg", "ground", "ball", 0.02, 0.03) + test::run_for(1, "start = \"given\"\n"),
      "throw");
  auto& ball = scene.mechanism.bodies[0];
  ball.position = {-0.5, off};
  ball.velocity = {speed, 0};
  scene.run.duration = 1 / speed;
  return scene;
}

bool reports_missed(const Result& run) { return test::notes_of(run).find("missed") != std::string::npos; }

}  // namespace

TEST_CASE("time stepping reports exactly when bodies may have passed through each other", "[unseen]") {
  auto scene = thrown(0.01, 100);
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  // 100 m/s in 1e-3 s is the width of 0.1 m itself; in 1e-5 s a hundredth of it.
  scene.nonsmooth.step = 1e-3;
  CHECK(reports_missed(test::simulate(scene, Family::nonsmooth)));
  scene.nonsmooth.step = 1e-5;
  const auto fine = test::simulate(scene, Family::nonsmooth);
  CHECK_FALSE(reports_missed(fine));
  CHECK(fine.events_seen == 1);
  // A journal in its bearing does not penetrate the wall after contact.
  CHECK_FALSE(reports_missed(test::simulate(read_scene(test::scene_file("gudgeon")), Family::nonsmooth)));
}

TEST_CASE("a table over an angle has a kink at each knot and a piece between two knots", "[unseen]") {
  const auto scene =
      parse_scene(test::body("rotor", 1, 0.5) + test::pin("pin", "ground", "rotor") +
                      test::drive("motor", "pin",
                                  "against = \"angle\"\ntorque_table = [[-1, 0], [0, 1], [1, 2], [2, 0]]\n") +
                      test::run_for(1),
                  "table");
  const System system(scene.mechanism);
  REQUIRE(system.phases() == 1);
  // The slope changes at −1 (from the return), 1 and 2, but not at 0.
  const double turn = 2 * M_PI;
  const auto is = [&](double angle, bool above, double low, double high) {
    const auto p = system.phase(0).piece(angle, above);
    CAPTURE(angle, above);
    CHECK(p.low == Approx(low).margin(1e-12));
    CHECK(p.high == Approx(high).margin(1e-12));
  };
  is(0, true, -1, 1);
  is(1, true, 1, 2);
  is(1, false, -1, 1);
  is(3, true, 2, turn - 1);
  is(-1, false, 2 - turn, -1);
  is(100 * turn + 1.5, true, 100 * turn + 1, 100 * turn + 2);
}

TEST_CASE("a contact of a spinning body with a peg is found at any spin", "[unseen]") {
  // A disc of 5 mm on an arm of 1 m touches a fixed one of 5 mm at the top of the circle when the
  // arm is close to vertical: |d| = 2 sin(φ/2) = 0.01, φ short of a right angle.
  for (const double spin : {1.0, 1e3, 1e5}) {
    auto scene =
        parse_scene(test::body("arm", 1, 0.5) + test::pin("pin", "ground", "arm") +
                        test::surface("s", 0.5, "young = 2e11\npoisson = 0.3\n") +
                        test::discs("peg", "ground", "arm", 0.005, 0.005, "s", "at = [[0, 1], [1, 0]]\n") +
                        test::run_for(1, "start = \"given\"\n"),
                    "spin");
    scene.mechanism.bodies[0].angular_velocity = spin;
    scene.run.duration = 3 / spin;
    const double exact = (M_PI / 2 - 2 * std::asin(0.005)) / spin;
    scene.nonsmooth.scheme = Scheme::event_driven;
    for (const auto family : {Family::penalty, Family::nonsmooth}) {
      const auto touches = test::touches(test::simulate(scene, family));
      CAPTURE(spin, name_of(family));
      REQUIRE_FALSE(touches.empty());
      CHECK(touches[0].t == Approx(exact).epsilon(1e-9));
    }
  }
}

// Tables over time: the effect of a pulse is its area, however short the pulse, in every integrator
// and scheme.

namespace {

using Table = std::vector<std::pair<double, double>>;

/// A wheel of 0.1 kg m² on its axle, driven by a table over time alone.
std::string wheel(const Table& table) {
  std::string text;
  for (const auto& [t, torque] : table)
    text += fmt::format("{}[{}, {}]", text.empty() ? "" : ", ", t, torque);
  return test::body("wheel", 1.0, 0.1) + test::pin("axle", "ground", "wheel") +
         test::drive("motor", "axle", fmt::format("torque_table = [{}]\n", text)) + test::run_for(1.0);
}

/// ∫ M dt and ∫∫ M dt² from 0 to 1 s: the table is linear between knots and constant beyond them.
std::pair<long double, long double> moments(const Table& table) {
  const auto value = [&](long double t) -> long double {
    if (t <= table.front().first) return table.front().second;
    for (std::size_t i = 1; i < table.size(); ++i)
      if (t <= table[i].first)
        return table[i - 1].second + (table[i].second - static_cast<long double>(table[i - 1].second)) *
                                         (t - table[i - 1].first) /
                                         (table[i].first - static_cast<long double>(table[i - 1].first));
    return table.back().second;
  };
  std::vector<long double> at{0};
  for (const auto& knot : table)
    if (knot.first > 0 && knot.first < 1) at.push_back(knot.first);
  at.push_back(1);
  long double speed = 0, angle = 0;
  for (std::size_t i = 1; i < at.size(); ++i) {
    const long double h = at[i] - at[i - 1], a = value(at[i - 1]), b = value(at[i]);
    angle += h * speed + h * h * (2 * a + b) / 6;
    speed += h * (a + b) / 2;
  }
  return {speed, angle};
}

const auto methods = test::with_integrators({test::penalty_by("rk4"), test::event_driven, test::automatic,
                                             test::chosen_steps, test::fixed_steps(3e-3)});

}  // namespace

TEST_CASE("pulses shorter than any step turn a wheel by their area", "[knots]") {
  const auto way = GENERATE(from_range(methods));
  CAPTURE(way.name);
  std::mt19937 engine(18);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 12; ++trial) {
    // Up to four pulses of 1e-9 to 1e-2 s and of at most 1 N m s, on a slowly varying torque.
    Table table{{0, 0.5}};
    double t = 0, least = 1;
    for (int pulse = 0; pulse < 1 + trial % 4; ++pulse) {
      t += 0.01 + 0.2 * uniform(engine);
      const double width = std::pow(10, -2 - 7 * uniform(engine)), height = (2 * uniform(engine) - 1) / width;
      for (const auto& [share, level] : {std::pair{0.0, 0.0}, {0.1, height}, {0.9, height}, {1.0, 0.0}})
        table.emplace_back(t + share * width, level + 0.5 - t);
      least = std::min(least, width);
      t += width;
    }
    CAPTURE(trial, least);
    std::vector<std::string> step;
    if (std::string(way.name) == "rk4") step = {"penalty.step=3e-3"};
    const auto run = test::finished(way, wheel(table), step);
    const auto [speed, angle] = moments(table);
    // Torques are linear between knots: quadratures of second order and above are exact there. The
    // remaining error is rounding of the knots themselves (1e-16 of 1 s, in a width of 1e-9: 1e-7
    // of the pulse) and each method's tolerance.
    CHECK(run.final_state.v[2] == Approx(double(speed / 0.1L)).margin(1e-5));
    // A fixed step applies the mean of a pulse over the step: the error of the angle is the effect
    // of the pulse over half a step.
    CHECK(run.final_state.q[2] == Approx(double(angle / 0.1L)).margin(way.fixed() ? 4 * 10 * 1.5e-3 : 1e-5));
    CHECK(run.work.rejected < 400);
    CHECK(run.work.steps < 5000);
  }
}

// The speed scales of tolerances where neither a drive nor gravity sets the pace: slow and small
// motions, and starts with negligible velocity.

TEST_CASE("a negligible start velocity does not change the response to a pulse", "[penalty][event-driven]") {
  // A triangle of 20 us and 1000 N about 0.30001 s on 1 kg: v = 0.01 m/s, x = 0.01 (1 - 0.30001) m.
  // A speed scale of 1e-12 m/s once made the tolerance finer than rounding, and one step passed
  // over the pulse. The tolerance is 1e-8 of 1 m and of 1e-3 m/s.
  for (const char* speed : {"0", "1e-300", "1e-12"})
    for (const Family family : {Family::penalty, Family::nonsmooth}) {
      CAPTURE(speed, name_of(family));
      const auto run = test::finished(read_scene(test::scene_file("tests/pulse_on_body"),
                                                 {fmt::format("bodies.body.velocity=[{}, 0]", speed)}),
                                      family);
      CHECK(run.final_state.v[0] == Approx(0.01).epsilon(1e-6));
      CHECK(run.final_state.q[0] == Approx(0.01 * (1 - 0.30001)).epsilon(1e-6));
    }
}

TEST_CASE("work of a drive far above the energy within the clearance does not shorten the steps",
          "[penalty][curves]") {
  // The work of the drive was once controlled relative to the kinetic energy at 5e-8 m/s, below its
  // own rounding: 3.4 million steps.
  auto scene = read_scene(test::scene_file("tests/block_between_stops"));
  for (const auto integrator : {Integrator::adams_bashforth_moulton, Integrator::rosenbrock4}) {
    CAPTURE(static_cast<int>(integrator));
    scene.penalty.integrator = integrator;
    test::Listener look;
    long steps = 0;
    std::atomic<bool> stop = false;
    look.on_step = [&](const Step&) { stop = ++steps > 10000; };
    Simulation simulation(scene, "penalty");
    const auto run = simulation.run({.observers = {&look}, .stop = StopToken(stop)});
    CHECK(run.ending.status == Ending::Status::finished);
  }
}

TEST_CASE("a motion much slower and smaller than its lever arms conserves its energy",
          "[integrators][curves][event-driven]") {
  // M = A sin(2πθ/p) on a rotor at 2.5e-7 rad/s,
  // 25 hills of 1.5e-4 rad in four hours;
  // E = ½ J ω² + A p/(2π) cos(2πθ/p). Some 50 steps a hill have an error of 1e-8 of ω each, with
  // random signs √1250 · 2e-8 = 7e-7 of E. The bound, set after the first runs, is seven times
  // that. With a scale of 1e-3 rad/s the error was 4.8e-5 (bulirsch_stoer) to 5e-4 (dopri5).
  constexpr double J = 0.0130480311483, A = -6.99899223804e-11, p = 0.000147342645013;
  auto scene = read_scene(test::scene_file("tests/rotor_over_hills"));
  const auto energy = [&](double theta, double omega) {
    return 0.5 * J * omega * omega + A * p / (2 * pi) * std::cos(2 * pi * theta / p);
  };
  const double first = energy(-0.00249239488328, 2.45967683912e-07);
  const auto check = [&](Family family) {
    const auto run = test::finished(scene, family);
    CHECK(energy(run.final_state.q[2], run.final_state.v[2]) == Approx(first).epsilon(5e-6));
  };
  check(Family::nonsmooth);
  for (const auto integrator :
       {Integrator::dopri5, Integrator::bulirsch_stoer, Integrator::adams_bashforth_moulton}) {
    CAPTURE(static_cast<int>(integrator));
    scene.penalty.integrator = integrator;
    check(Family::penalty);
  }
}

TEST_CASE("the stiffness of a system does not depend on the length of the run", "[penalty]") {
  // 3e8 s at 3,700 steps a revolution: progress is measured by the time scale of the motion, not by
  // the end of the run.
  auto scene = read_scene(test::flores());
  scene.instruments.clear();
  scene.run.duration = 3e8;
  Simulation simulation(scene, "penalty");
  std::atomic<bool> stop{false};
  test::Listener listener;
  long steps = 0;
  listener.on_step = [&](const Step&) { stop = ++steps > 400000; };
  const auto run = simulation.run({.observers = {&listener}, .keep_events = false, .stop = StopToken(stop)});
  CAPTURE(run.ending.reason, run.t_end);
  CHECK(run.ending.status == Ending::Status::interrupted);
}
