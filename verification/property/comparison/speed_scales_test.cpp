// The speed scales of tolerances where neither a drive nor gravity sets the pace: slow and small
// motions, and starts with negligible velocity.
#include <atomic>

#include "verification/support/rig.hpp"

using namespace freeplay;
using std::numbers::pi;

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
