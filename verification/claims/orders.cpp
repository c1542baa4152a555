// Orders of convergence, bracketed from both sides.
#include "formulations/make.hpp"
#include "numerics/rosenbrock4.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/pendulum.hpp"
#include "verification/support.hpp"

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
void order(Findings& f, const std::string& what, const std::vector<double>& steps,
           const std::vector<double>& errors, double low, double high, const std::string& source,
           const std::string& reason) {
  f.between("order of " + what, "", test::observed_order(steps, errors), low, high, source, reason);
  f.curves.push_back({"orders", what, "step (s)", "error (s, m/s, N s or rad)", steps, errors});
}

void smooth(Findings& f) {
  const double exact = reference::pendulum_state({0.8, 0.01, 0.25, 9.81, M_PI / 3}, 0.9).angle;
  const auto errors = [&](Family family, const std::vector<double>& steps) {
    std::vector<double> found;
    for (const double h : steps) {
      auto scene = pendulum(0.9);
      scene.penalty.integrator = Integrator::rk4;
      scene.penalty.step = scene.nonsmooth.step = h;
      found.push_back(std::abs(test::simulate(scene, family).final_state.q[2] + M_PI / 2 - exact));
    }
    return found;
  };
  const std::vector<double> coarse{2e-2, 1e-2, 5e-3, 2.5e-3}, fine{2e-3, 1e-3, 5e-4, 2.5e-4};
  order(f, "rk4, pendulum", coarse, errors(Family::penalty, coarse), 3.85, 4.15, "theory: 4",
        "asymptotic regime");
  order(f, "Moreau–Jean, pendulum", fine, errors(Family::nonsmooth, fine), 1.9, 2.1, "theory: 2 (θ = ½)",
        "asymptotic regime");
}

void across_impacts(Findings& f) {
  auto scene = read_scene(test::flores());
  scene.run.duration = 0.0107;
  scene.run.discard = 0;
  scene.instruments.clear();
  scene.nonsmooth.scheme = Scheme::event_driven;
  const auto exact = test::touches(test::simulate(scene, Family::nonsmooth));
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  std::vector<double> steps, errors[3];
  for (const double h : {4e-6, 2e-6, 1e-6, 5e-7}) {
    double worst[3] = {0, 0, 0};
    for (int part = 0; part < 20; ++part) {
      scene.nonsmooth.step = h * (1 + 0.5 * part / 20);
      const auto found = test::touches(test::simulate(scene, Family::nonsmooth));
      for (std::size_t i = 0; i < 3; ++i) {
        worst[0] = std::max(worst[0], std::abs(found.at(i).t - exact.at(i).t));
        worst[1] = std::max(worst[1], std::abs(found[i].v_n_minus - exact[i].v_n_minus));
        worst[2] = std::max(worst[2], std::abs(found[i].impulse_n - exact[i].impulse_n));
      }
    }
    steps.push_back(h);
    for (int i = 0; i < 3; ++i) errors[i].push_back(worst[i]);
  }
  const char* names[] = {"times", "approach speeds", "impulses"};
  for (int i = 0; i < 3; ++i)
    order(f, std::string("Moreau–Jean across three impacts, ") + names[i], steps, errors[i], 0.9, 1.1,
          "theory: 1, against the event-driven solution",
          "asked for; the greatest error over twenty steps between h and 1.5 h, since it is a sawtooth in h");
}

void contacts(Findings& f) {
  auto scene = read_scene(test::scene_file("ring"));
  scene.mechanism.surfaces[0].friction.reset();
  scene.run.duration = 0.02;
  const auto third = [&] { return test::touch(test::simulate(scene, Family::penalty), 2).t; };
  const auto first = [&] { return test::touch(test::simulate(scene, Family::penalty), 0).duration; };
  scene.penalty.integrator = Integrator::dopri5;
  scene.penalty.tolerance = 1e-13;
  const double hertz = third();
  scene.penalty.contact = ContactLaw::kelvin_voigt;
  scene.penalty.kelvin_stiffness = 1e7;
  scene.penalty.kelvin_damping = 0;
  const double linear = first();
  scene.penalty.integrator = Integrator::rk4;
  std::vector<double> steps{4e-5, 2e-5, 1e-5, 5e-6}, errors;
  for (const double h : steps) {
    scene.penalty.step = h;
    errors.push_back(std::abs(first() - linear));
  }
  order(f, "rk4 across a linear contact", steps, errors, 3.8, 4.2, "theory: 4 with located events",
        "the duration of the first contact, a phase");
  scene.penalty.contact = ContactLaw::exact;
  steps = {5e-6, 2.5e-6, 1.25e-6, 6.25e-7};
  errors.clear();
  for (const double h : steps) {
    scene.penalty.step = h;
    errors.push_back(std::abs(third() - hertz));
  }
  order(f, "rk4 across Hertz contacts", steps, errors, 2.2, 2.8, "theory: 5/2",
        "δ^(3/2) has an unbounded second derivative at touch");
}

}  // namespace

Findings orders() {
  Findings f;
  smooth(f);
  across_impacts(f);
  contacts(f);
  return f;
}

}  // namespace freeplay::verification
