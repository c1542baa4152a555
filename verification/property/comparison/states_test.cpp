// First-order states of elements in every integrator: a rotor driven by a lagging torque, in closed
// form:
//     T ż = u − z,   J ω̇ = z,   z(0) = 0:
//     z = u (1 − e^(−t/T)),   ω = (u/J) [t − T (1 − e^(−t/T))]
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

constexpr double J = 0.2, T = 0.05, u = 3, until = 0.2;

Scene rotor(const std::string& more = "") {
  auto scene =
      parse_scene(test::body("rotor", 1, 0.2) + test::pin("shaft", "ground", "rotor") +
                      test::drive("motor", "shaft", "torque = 3\nlag = 0.05\n") + more + test::run_for(0.2),
                  "rotor");
  scene.penalty.step = 1e-3;  // read by rk4 alone
  return scene;
}

double speed(double t) { return u / J * (t - T * (1 - std::exp(-t / T))); }
double torque(double t) { return u * (1 - std::exp(-t / T)); }

}  // namespace

TEST_CASE("a lagging torque: all integrators carry its state", "[states]") {
  auto scene = rotor();
  for (const auto integrator : {Integrator::rk4, Integrator::dopri5, Integrator::bulirsch_stoer,
                                Integrator::adams_bashforth_moulton, Integrator::rosenbrock4}) {
    CAPTURE(static_cast<int>(integrator));
    scene.penalty.integrator = integrator;
    Simulation simulation(scene, "penalty");
    const auto run = test::finished(simulation);
    const auto state = simulation.state();
    REQUIRE(state.z.size() == 1);
    // rk4: (h/T)⁴/120 a step, 2e-9, over a few time constants; the others their tolerance of 1e-9 a
    // step.
    CHECK(state.z[0] == Approx(torque(until)).margin(3e-8 * u).epsilon(0));
    CHECK(state.v[2] == Approx(speed(until)).epsilon(1e-7));
    CHECK(std::abs(run.ledger.closure()) < 1e-6 * run.ledger.scale());
  }
}

TEST_CASE("a lagging torque: both nonsmooth schemes carry its state", "[states]") {
  auto scene = rotor();
  scene.nonsmooth.scheme = Scheme::event_driven;
  Simulation events(scene, "nonsmooth");
  events.run();
  CHECK(events.state().z.at(0) == Approx(torque(until)).epsilon(1e-8));
  CHECK(events.state().v[2] == Approx(speed(until)).epsilon(1e-8));
  // The midpoint rule: second order, (h/T)²/12 t/T e^(−t/T) of u. Two-sided.
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  const auto end_at = [&](double h) {
    scene.nonsmooth.step = h;
    return test::finished(scene, Family::nonsmooth).final_state;
  };
  const auto of_torque = [&](double h) { return std::abs(end_at(h).z.at(0) - torque(until)); };
  const auto of_speed = [&](double h) { return std::abs(end_at(h).v[2] - speed(until)); };
  CHECK(of_torque(1e-3) ==
        Approx(u * std::pow(1e-3 / T, 2) / 12 * until / T * std::exp(-until / T)).epsilon(0.05));
  test::check_order({4e-3, 2e-3, 1e-3}, of_torque, 1.95, 2.05);
  test::check_order({4e-3, 2e-3, 1e-3}, of_speed, 1.95, 2.05);
}

TEST_CASE("a step too long for the lag is refused with its reason", "[states]") {
  auto scene = rotor();
  scene.set("drives.motor.lag", "1e-4");
  scene.nonsmooth.step = 1e-2;
  const auto run = test::simulate(scene, Family::nonsmooth);
  CHECK(run.ending.status == Ending::Status::failed);
  CHECK_THAT(run.ending.reason, Catch::Matchers::Contains("lagged torques does not converge"));
}

TEST_CASE("a torque sensor shows the lagging torque", "[states]") {
  // Its filter lags by about √2/ω_c = 2.3e-6 s of 0.05 s: 5e-5 of u at most, where the torque rises
  // fastest.
  for (const char* formulation : {"penalty", "nonsmooth"}) {
    CAPTURE(formulation);
    double worst = 0, last = 0;
    test::Listener listener;
    listener.on_sample = [&](std::size_t, double t, double value) {
      if (t > 1e-4) worst = std::max(worst, std::abs(value - torque(t)));
      last = t;
    };
    auto scene =
        rotor("[instruments.gauge]\ntype = \"torque\"\ndrive = \"motor\"\nbandwidth = 1e5\nsampling = 1e6\n");
    scene.run.duration = 0.02;
    Simulation(scene, formulation).run({.observers = {&listener}});
    CHECK(last > 0.0199);
    CHECK(worst < 1e-4 * u);
  }
}
