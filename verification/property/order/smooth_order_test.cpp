// Integrators on smooth motion: time-dependent, stiff and with many bodies. (The claims of "orders"
// contain their orders on a pendulum.)
#include "numerics/rosenbrock4.hpp"
#include "verification/references/seven_body.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

constexpr double mass = 0.8, arm = 0.25, gravity = 9.81, amplitude = 1.0471975511965976;

Scene pendulum() {
  // θ is the angle of the body, which hangs along −y, so its angle from the vertical is θ + 90°.
  return read_scene(test::scene_file("swinging_bar"));
}

}  // namespace

TEST_CASE("rosenbrock4 is of fourth order with a time-dependent right-hand side", "[order]") {
  // dx/dt = −2 t x², x(0) = 1: x = 1/(1 + t²).
  const Rosenbrock4::Problem problem{
      nullptr, [](void*, const double* x, double* dxdt, double t) { dxdt[0] = -2 * t * x[0] * x[0]; },
      [](void*, const double* x, double t, double* J, double* dfdt) {
        J[0] = -4 * t * x[0];
        dfdt[0] = -2 * x[0] * x[0];
      }};
  const auto error_at = [&](double h) {
    Rosenbrock4 method(1);
    double x = 1, next, error;
    for (int i = 0; i < std::lround(1 / h); ++i, x = next) method.step(problem, &x, i * h, h, &next, &error);
    return std::abs(x - 0.5);
  };
  test::check_order({1.0 / 10, 1.0 / 20, 1.0 / 40, 1.0 / 80}, error_at, 3.8, 4.2);
}

TEST_CASE("rosenbrock4 integrates a stiff damper with large steps", "[order][stiff]") {
  // A damper of 50 N m s/rad on an inertia of 0.06 kg m² has a rate of 830 1/s, compared with 0.2
  // 1/s of the fall. The bar creeps as c θ̇ = m g l cos θ after the initial transient: with θ from
  // the vertical, tan(θ/2) decays
  // with the rate m g l/c, up to (m g l J/c²) of itself, 5e-5.
  auto scene = pendulum();
  scene.mechanism.loads.push_back(TorsionalSpringDamper{"damper", {ground, 0}, 0, 50, 0});
  scene.run.duration = 20;
  scene.penalty.tolerance = 1e-6;
  const auto run = [&](Integrator integrator) {
    scene.penalty.integrator = integrator;
    return test::simulate(scene, Family::penalty);
  };
  const auto implicit = run(Integrator::rosenbrock4), explicit_pair = run(Integrator::dopri5);
  REQUIRE(implicit.ending.status == Ending::Status::finished);
  const double exact =
      2 * std::atan(std::tan(amplitude / 2) * std::exp(-mass * gravity * arm / 50 * scene.run.duration));
  CHECK(implicit.final_state.q[2] + 1.5707963267948966 == Approx(exact).epsilon(2e-4));
  // An explicit method alone is limited to steps of about 3.3/830 s: 5,000 steps; the implicit one
  // needs a few dozen.
  CAPTURE(implicit.work.rhs, explicit_pair.work.rhs);
  // It is replaced after 2000 of them.
  CHECK(implicit.work.steps < 100);
  CHECK(explicit_pair.work.steps < 3000);
}

TEST_CASE("every integrator carries the seven-body mechanism to its published end state",
          "[order][seven-body]") {
  // Its first trial steps violate the loops: a step that cannot be factorised has to be refused,
  // not kept.
  struct Row {
    Integrator integrator;
    double fineness;
  };
  for (const auto& row :
       {Row{Integrator::rk4, 1e-6}, Row{Integrator::dopri5, 1e-9}, Row{Integrator::bulirsch_stoer, 1e-9},
        Row{Integrator::adams_bashforth_moulton, 1e-9}, Row{Integrator::rosenbrock4, 1e-7}}) {
    auto scene = read_scene(test::scene_file("seven_body"));
    scene.penalty.integrator = row.integrator;
    scene.penalty.step = scene.penalty.tolerance = row.fineness;
    const auto run = test::simulate(scene, Family::penalty);
    CAPTURE(static_cast<int>(row.integrator), run.ending.reason);
    REQUIRE(run.ending.status == Ending::Status::finished);
    // Some thousand steps at the tolerance, over 15.9 rad: a bound of 1e-6 rad is a hundred times
    // larger.
    CHECK(run.final_state.q[2] == Approx(reference::seven_body_end[0]).margin(1e-6).epsilon(0));
  }
}

// Two-sided tests of the order across contact events. (The claims of "orders" contain rk4 across
// undamped contacts.)

namespace {

double third_impact(const Scene& scene) { return test::touch(test::simulate(scene, Family::penalty), 2).t; }

}  // namespace

TEST_CASE("rk4 is of fourth order across damped linear contacts, which jump at their onset",
          "[order][events]") {
  // A mass against a spring and a damper in parallel moves freely from where their force is zero,
  // δ̈ = 0: with a = D/2m, ω² = K/m − a² and tan ωt = 2aω/(a² − ω²), at the depth v e^(−at) sin
  // ωt/ω with v e^(−at) (a sin ωt/ω − cos ωt). The duration until zero depth is a phase, as above.
  const double m = 2, K = 3e6, D = GENERATE(60.0, 1200.0, 2400.0);
  const double a = D / (2 * m), w = std::sqrt(K / m - a * a), t = std::atan2(2 * a * w, a * a - w * w) / w;
  const double exact = t + std::sin(w * t) / (a * std::sin(w * t) - w * std::cos(w * t));
  auto scene = parse_scene(test::body("ball", m, 1e-3, "position = [0, 0.0123]\nvelocity = [0, -0.7]\n") +
                               test::plane("floor", "ground", "ball", 0.01) +
                               test::surface("s", 0.5, "young = 2e11\npoisson = 0.3\n") +
                               test::run_for(0.02, "start = \"given\"\n"),
                           "s.toml");
  scene.penalty.contact = ContactLaw::kelvin_voigt;
  scene.penalty.kelvin_stiffness = K;
  scene.penalty.kelvin_damping = D;
  scene.penalty.integrator = Integrator::rk4;
  // The error depends on the length of the last step of a contact, so that many steps are compared.
  std::vector<double> steps;
  for (int i = 0; i <= 24; ++i) steps.push_back(2e-4 * std::pow(2, -i / 8.0));
  const auto error_at = [&](double h) {
    scene.penalty.step = h;
    return std::abs(test::touch(test::simulate(scene, Family::penalty), 0).duration - exact);
  };
  CAPTURE(D);
  test::check_order(steps, error_at, 3.7, 4.3);
}

TEST_CASE("adaptive integrators: errors across impacts decrease in proportion to the tolerance",
          "[order][events]") {
  const auto integrator = GENERATE(Integrator::dopri5, Integrator::bulirsch_stoer,
                                   Integrator::adams_bashforth_moulton, Integrator::rosenbrock4);
  // A free ring and journal without friction. The reference is dopri5 at a tolerance of 1e-13, which
  // bulirsch_stoer and adams confirm to 1e-12 s.
  auto scene = read_scene(test::scene_file("ring"));
  scene.mechanism.surfaces[0].friction.reset();
  scene.run.duration = 0.02;
  scene.penalty.contact = ContactLaw::kelvin_voigt;
  scene.penalty.kelvin_stiffness = 1e7;
  scene.penalty.kelvin_damping = 0;
  scene.penalty.integrator = Integrator::dopri5;
  scene.penalty.tolerance = 1e-13;
  const double exact = third_impact(scene);
  scene.penalty.integrator = integrator;
  CAPTURE(static_cast<int>(integrator));
  // Error control per step gives a global error of tolerance^(p/(p+1)) to tolerance^1; changes of
  // order cause scatter.
  const auto error_at = [&](double tolerance) {
    scene.penalty.tolerance = tolerance;
    return std::abs(third_impact(scene) - exact);
  };
  test::check_order({1e-4, 1e-5, 1e-6, 1e-7, 1e-8}, error_at, 0.6, 1.4);
}
