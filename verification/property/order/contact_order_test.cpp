// Two-sided tests of the order across contact events. (The claims of "orders" contain rk4 across
// undamped contacts.)
#include "verification/support/rig.hpp"

using namespace freeplay;

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
