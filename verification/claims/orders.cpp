// Orders of convergence, each bounded from both sides.
#include "verification/claims/claim.hpp"
#include "verification/references/hertz_impact.hpp"
#include "verification/references/pendulum.hpp"
#include "verification/references/slider_crank_oracle.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

Scene pendulum(double duration) {
  Scene scene;
  scene.mechanism.gravity = {0, -9.81};
  const double lean = -M_PI / 6;
  scene.mechanism.bodies.push_back(
      {"bar", 0.8, 0.01, 0.25 * Vec2{std::cos(lean), std::sin(lean)}, lean, {0, 0}, 0});
  scene.mechanism.joints.push_back(RevoluteJoint{"pivot", {ground, 0}, {Vec2{0, 0}, Vec2{-0.25, 0}}, {}});
  scene.run.duration = duration;
  return scene;
}

/// Adds the claim and the curve of errors over steps.
void order(Findings& f, const char* subject, const char* quantity, const char* scheme,
           const std::vector<double>& steps, const std::vector<double>& errors, double low, double high,
           const std::string& source, const std::string& reason) {
  f.between(claim_name(subject, std::string("order of convergence in h, ") + quantity, scheme), "",
            test::observed_order(steps, errors), low, high, source, reason);
  f.curves.push_back({"orders", std::string(subject) + ", " + quantity + " [" + scheme + "]", "step (s)",
                      "error (s, m/s, N s or rad)", steps, errors});
}

void smooth(Findings& f) {
  const double exact = reference::pendulum_state({0.8, 0.01, 0.25, 9.81, M_PI / 3}, 0.9).angle;
  const auto errors = [&](Family family, const std::vector<double>& steps) {
    std::vector<double> found;
    for (const double h : steps) {
      auto scene = pendulum(0.9);
      scene.penalty.integrator = Integrator::rk4;
      scene.penalty.step = h;
      scene.nonsmooth.step = h;
      found.push_back(std::abs(test::simulate(scene, family).final_state.q[2] + M_PI / 2 - exact));
    }
    return found;
  };
  const std::vector<double> coarse{2e-2, 1e-2, 5e-3, 2.5e-3}, fine{2e-3, 1e-3, 5e-4, 2.5e-4};
  order(f, "pendulum", "angle after 0.9 s", "penalty, rk4", coarse, errors(Family::penalty, coarse), 3.85,
        4.15, "theory: 4", "asymptotic regime");
  order(f, "pendulum", "angle after 0.9 s", "Moreau–Jean", fine, errors(Family::nonsmooth, fine), 1.9, 2.1,
        "theory: 2 (θ = ½)", "asymptotic regime");
}

/// Integrators with error control: the exponent of the tolerance in the error.
void adaptive(Findings& f) {
  const double exact = reference::pendulum_state({0.8, 0.01, 0.25, 9.81, M_PI / 3}, 0.9).angle;
  auto scene = pendulum(0.9);
  scene.nonsmooth.scheme = Scheme::event_driven;
  const auto claim = [&](const std::string& name, Family family, Integrator integrator) {
    scene.penalty.integrator = integrator;
    std::vector<double> tolerances, errors;
    for (int half_decades = 8; half_decades <= 20; ++half_decades) {
      const double tolerance = std::pow(10, -0.5 * half_decades);
      scene.penalty.tolerance = scene.nonsmooth.tolerance = tolerance;
      tolerances.push_back(tolerance);
      errors.push_back(std::abs(test::simulate(scene, family).final_state.q[2] + M_PI / 2 - exact));
    }
    f.between(
        claim_name("pendulum", "exponent of the tolerance in the error of the angle, 1e-4 to 1e-10", name),
        "", test::observed_order(tolerances, errors), 0.6, 1.4, "theory: p/(p + 1) to 1 for error per step",
        "scatter by changes of step and order");
    f.curves.push_back({"tolerances", name, "tolerance", "error (rad)", tolerances, errors});
  };
  claim("penalty, dopri5", Family::penalty, Integrator::dopri5);
  claim("penalty, Bulirsch–Stoer", Family::penalty, Integrator::bulirsch_stoer);
  claim("penalty, Adams–Bashforth–Moulton", Family::penalty, Integrator::adams_bashforth_moulton);
  claim("penalty, rosenbrock4", Family::penalty, Integrator::rosenbrock4);
  claim("event-driven", Family::nonsmooth, scene.penalty.integrator);
}

void across_impacts(Findings& f) {
  auto scene = test::read_short(test::flores(), 0.0107);
  scene.instruments.clear();
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  reference::LooseSliderCrank<long double> mechanism;
  mechanism.friction = 0.01L;
  const auto exact = reference::SliderCrankOracle<long double>(mechanism).nonsmooth(0.46L, 0.0107L).impacts;
  std::vector<double> steps, errors[3];
  for (const double h : {4e-6, 2e-6, 1e-6, 5e-7}) {
    double worst[3] = {0, 0, 0};
    for (int part = 0; part < 20; ++part) {
      scene.nonsmooth.step = h * (1 + 0.5 * part / 20);
      const auto found = test::touches(test::simulate(scene, Family::nonsmooth));
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& e = exact.at(i);
        worst[0] = greatest(worst[0], std::abs(found.at(i).t - double(e.t)));
        worst[1] = greatest(worst[1], std::abs(found[i].v_n_minus - double(e.v_n_minus)));
        worst[2] = greatest(worst[2], std::abs(found[i].impulse_n - double(e.impulse_n)));
      }
    }
    steps.push_back(h);
    for (int i = 0; i < 3; ++i) errors[i].push_back(worst[i]);
  }
  const char* names[] = {"times of 3 impacts", "approach speeds of 3 impacts", "impulses of 3 impacts"};
  for (int i = 0; i < 3; ++i)
    order(
        f, "paper's slider-crank with clearance", names[i], "Moreau–Jean", steps, errors[i], 0.9, 1.1,
        "theory: 1; errors against the independent derivation in long double",
        "required accuracy; greatest error of twenty steps between h and 1.5 h, since it is a sawtooth in h");
}

/// A head-on impact of a journal in its ring: the duration of the contact is half a period of the
/// linear spring, or Hertz's by the Gamma function.
void contacts(Findings& f) {
  auto scene = read_scene(test::scene_file("ring"));
  auto& m = scene.mechanism;
  m.surfaces[0].friction.reset();
  m.bodies[0].angular_velocity = m.bodies[1].angular_velocity = 0;
  m.bodies[1].position = {0, 0};
  m.bodies[1].velocity = {0.3, 0};
  scene.run.duration = 0.0045;  // s: 1 mm at 0.3 m/s, and the contact
  scene.penalty.integrator = Integrator::rk4;
  const double mass = 2.0 * 0.5 / 2.5;
  const auto errors = [&](const std::vector<double>& steps, double exact) {
    std::vector<double> found;
    for (const double h : steps) {
      scene.penalty.step = h;
      found.push_back(std::abs(test::touch(test::simulate(scene, Family::penalty), 0).duration - exact));
    }
    return found;
  };
  scene.penalty.contact = ContactLaw::kelvin_voigt;
  scene.penalty.kelvin_stiffness = 1e7;
  scene.penalty.kelvin_damping = 0;
  const std::vector<double> coarse{4e-5, 2e-5, 1e-5, 5e-6};
  order(f, "impact of ring and journal, linear contact", "contact duration", "penalty, rk4", coarse,
        errors(coarse, std::numbers::pi * std::sqrt(mass / 1e7)), 3.8, 4.2, "theory: 4; duration π√(m/k)",
        "only an inaccurate location of contact events would reduce the order");
  scene.penalty.contact = ContactLaw::hertz;
  const double K = 4.0 / 3 * 207e9 / (2 * (1 - 0.09)) * std::sqrt(20e-3 * 19e-3 / 1e-3);
  const std::vector<double> fine{1e-6, 5e-7, 2.5e-7, 1.25e-7};
  order(
      f, "impact of ring and journal, Hertz contact", "contact duration", "penalty, rk4", fine,
      errors(fine, reference::elastic_impact(K, mass, 0.3).duration), 2.2, 2.8,
      "theory: 5/2; duration 2.9432755… δ/v",
      "δ^(3/2) has an unbounded second derivative at contact onset; the interior of the contact adds O(h⁴)");
}

}  // namespace

Parts orders() { return {smooth, adaptive, across_impacts, contacts}; }

}  // namespace freeplay::verification
