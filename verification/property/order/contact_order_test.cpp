// Two-sided tests of the order across contact events: a free ring and journal without friction,
// three impacts. The reference is the same formulation with dopri5 at a tolerance of 1e-13, which
// bulirsch_stoer and adams confirm to 1e-12 s.
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

Scene ring() {
  auto scene = read_scene(test::scene_file("ring"));
  scene.mechanism.surfaces[0].friction.reset();
  scene.run.duration = 0.02;
  return scene;
}

double third_impact(const Scene& scene) { return test::touch(test::simulate(scene, Family::penalty), 2).t; }
double first_duration(const Scene& scene) {
  return test::touch(test::simulate(scene, Family::penalty), 0).duration;
}

double reference(double (*quantity)(const Scene&), Scene scene) {
  scene.penalty.integrator = Integrator::dopri5;
  scene.penalty.tolerance = 1e-13;
  return quantity(scene);
}

Scene with_linear_contact(Scene scene) {
  scene.penalty.contact = ContactLaw::kelvin_voigt;
  scene.penalty.kelvin_stiffness = 1e7;
  scene.penalty.kelvin_damping = 0;
  return scene;
}

}  // namespace

TEST_CASE("rk4 keeps its fourth order across events of a linear contact", "[order][events]") {
  // Within a contact mode a linear spring is smooth; only badly located events could reduce the
  // order. The duration of a contact (0.6 ms) is a phase, which rk4 integrates to fourth order; its
  // amplitude would be one order better.
  auto scene = with_linear_contact(ring());
  const double exact = reference(first_duration, scene);
  scene.penalty.integrator = Integrator::rk4;
  const auto error_at = [&](double h) {
    scene.penalty.step = h;
    return std::abs(first_duration(scene) - exact);
  };
  test::check_order({4e-5, 2e-5, 1e-5, 5e-6}, error_at, 3.8, 4.2);
}

TEST_CASE("rk4 is of fourth order across damped linear contacts, which jump at their onset",
          "[order][events]") {
  // A mass against a spring and a damper in parallel moves freely from where their force is zero,
  // δ̈ = 0: with a = D/2m, ω² = K/m − a² and tan ωt = 2aω/(a² − ω²), at the depth v e^(−at) sin
  // ωt/ω with v e^(−at) (a sin ωt/ω − cos ωt). The duration until zero depth is a phase, as above.
  const double m = 2, K = 3e6, D = GENERATE(60.0, 1200.0, 2400.0);
  const double a = D / (2 * m), w = std::sqrt(K / m - a * a), t = std::atan2(2 * a * w, a * a - w * w) / w;
  const double exact = t + std::sin(w * t) / (a * std::sin(w * t) - w * std::cos(w * t));
  auto scene =
      parse_scene(test::body("ball", m, 1e-3, "position = [0, 0.0123]\nvelocity = [0, -0.7]\n") +
                      "[contacts.floor]\ntype = \"plane\"\nbetween = [\"ground\", \"ball\"]\nradius = 0.01\n"
                      "surface = \"s\"\n[surfaces.s]\nrestitution = 0.5\nyoung = 2e11\npoisson = 0.3\n" +
                      test::run_for(0.02, "start = \"given\"\n"),
                  "s.toml");
  scene.penalty.contact = ContactLaw::kelvin_voigt;
  scene.penalty.kelvin_stiffness = K;
  scene.penalty.kelvin_damping = D;
  scene.penalty.integrator = Integrator::rk4;
  // The error depends on the length of the last step of a contact, so that many steps are compared.
  std::vector<double> steps, errors;
  for (int i = 0; i <= 24; ++i) {
    steps.push_back(2e-4 * std::pow(2, -i / 8.0));
    scene.penalty.step = steps.back();
    errors.push_back(std::abs(first_duration(scene) - exact));
  }
  CAPTURE(D, errors);
  const double p = test::observed_order(steps, errors);
  CHECK(p > 3.7);
  CHECK(p < 4.3);
}

TEST_CASE("rk4 across Hertzian contacts is limited to order 5/2 by the onset of the force",
          "[order][events]") {
  // F ~ δ^(3/2) has an unbounded second derivative at the onset of contact: the error of the first
  // step in contact is h^(5/2) for any method.
  auto scene = ring();
  const double exact = reference(third_impact, scene);
  scene.penalty.integrator = Integrator::rk4;
  const auto error_at = [&](double h) {
    scene.penalty.step = h;
    return std::abs(third_impact(scene) - exact);
  };
  test::check_order({5e-6, 2.5e-6, 1.25e-6, 6.25e-7}, error_at, 2.2, 2.8);
}

TEST_CASE("adaptive integrators: errors across impacts decrease in proportion to the tolerance",
          "[order][events]") {
  const auto integrator = GENERATE(Integrator::dopri5, Integrator::bulirsch_stoer,
                                   Integrator::adams_bashforth_moulton, Integrator::rosenbrock4);
  auto scene = with_linear_contact(ring());
  const double exact = reference(third_impact, scene);
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
