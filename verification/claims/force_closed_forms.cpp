// Forces with closed forms: ideal slider-crank, rotor, weld, inclined guide.
#include "verification/claims/force_claims.hpp"
#include "verification/references/bearing_load.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::force_claims {
namespace {

/// Greatest error of forces (over the greatest force) and of moments (over the greatest torque)
/// during a turn.
std::array<double, 2> off_reference(const reference::LoadedSliderCrank<double>& s, const Scene& scene,
                                    Family family) {
  double force = 0, moment = 0, force_off = 0, moment_off = 0;
  Simulation simulation(scene, test::name_of(family));
  const auto& layout = simulation.layout();
  const auto main = find(layout, "main"), big_end = find(layout, "big_end"),
             gudgeon = find(layout, "gudgeon"), guide = find(layout, "guide"), motor = find(layout, "motor");
  Forces now{std::vector<ElementForce>(layout.forces.size()), std::vector<double>(9)};
  const bool stepping = family == Family::nonsmooth && scene.nonsmooth.scheme == Scheme::moreau_jean;
  test::watch_steps(simulation, [&](const Step& step) {
    // The velocities of time steps differ by O(h²) from those of the constraints, alike from step
    // to step. In the first step, and in a shorter last one, this is an error O(h) of the force.
    if (stepping && (step.t0 == 0 || step.t1 >= scene.run.duration)) return;
    for (const double share : {0.5, 1.0}) {
      if (stepping && share != 0.5) continue;
      const double t = share < 1 ? step.t0 + share * (step.t1 - step.t0) : step.t1;
      step.forces(t, now);
      const auto exact = reference::slider_crank_forces(s, s.speed * t);
      const auto compare = [&](std::size_t element, const Point& expected) {
        const auto& e = now.elements[element];
        force = std::max(force, std::hypot(expected.x, expected.y));
        force_off = greatest(force_off, std::hypot(e.fx - expected.x, e.fy - expected.y));
      };
      compare(main, exact.ground_on_crank);
      compare(big_end, exact.crank_on_rod);
      compare(gudgeon, exact.rod_on_slider);
      compare(guide, exact.guide.force);
      moment = std::max({moment, std::abs(exact.torque), std::abs(exact.guide.moment)});
      for (const auto& [element, expected] : {std::pair{motor, exact.torque},
                                              {guide, exact.guide.moment},
                                              {main, 0.0},
                                              {big_end, 0.0},
                                              {gudgeon, 0.0}})
        moment_off = greatest(moment_off, std::abs(now.elements[element].m - expected));
    }
  });
  return {force_off / force, moment_off / moment};
}

}  // namespace

void slider_cranks(Findings& f) {
  const char* const source = "references/slider_crank";
  for (const auto& [name, s] :
       {std::pair{"paper's ideal slider-crank", rig()},
        {"ideal slider-crank with weight, eccentric crank, offset slider and load", loaded()}}) {
    auto scene = slider_crank(s);
    const auto claim = [&, &name = name](const std::string& way, const std::array<double, 2>& off,
                                         double bound, const char* why) {
      f.at_most(claim_name(name, "reactions, greatest error over greatest force", way), "", off[0], bound,
                source, why);
      f.at_most(claim_name(name, "driving torque and moments, greatest error over greatest torque", way), "",
                off[1], bound, source, why);
    };
    claim("penalty", off_reference(s, scene, Family::penalty), 1e-8,
          "tolerance 1e-10 per step, margin of 100");
    scene.nonsmooth.scheme = Scheme::event_driven;
    claim("event-driven", off_reference(s, scene, Family::nonsmooth), 1e-8,
          "tolerance 1e-10 per step, margin of 100");
    scene.nonsmooth.scheme = Scheme::moreau_jean;
    std::vector<double> steps, errors;
    std::array<double, 2> last{};
    for (const double h : {4e-5, 2e-5, 1e-5}) {
      scene.nonsmooth.step = h;
      last = off_reference(s, scene, Family::nonsmooth);
      steps.push_back(h);
      errors.push_back(last[0]);
    }
    claim("Moreau–Jean, h = 1e-5 s", last, 1e-6, "(ω h)² = 4e-8, margin of 20");
    f.between(claim_name(name, "order of the reactions in h, 1e-5 to 4e-5 s", "Moreau–Jean, h = 1e-5 s"), "",
              test::observed_order(steps, errors), 1.9, 2.1, "2, for θ = ½", "the next order at h = 4e-5 s");
  }
  // Interval means of the two formulations.
  auto scene = slider_crank(rig());
  scene.run.output_step = 1e-3;
  scene.nonsmooth.step = 1e-5;
  const auto penalty = files(scene, Family::penalty), steps = files(scene, Family::nonsmooth);
  double apart = 0, most = 0;
  for (std::size_t i = 1; i < penalty.forces.rows(); ++i) {
    const double x = penalty.forces.at(i, "gudgeon.fx_mean"), y = penalty.forces.at(i, "gudgeon.fy_mean");
    most = std::max(most, std::hypot(x, y));
    apart = greatest(apart, std::hypot(x - steps.forces.at(i, "gudgeon.fx_mean"),
                                       y - steps.forces.at(i, "gudgeon.fy_mean")));
  }
  f.at_most(claim_name("paper's ideal slider-crank",
                       "difference of mean gudgeon forces over 1 ms, over the greatest",
                       "penalty against Moreau–Jean, h = 1e-5 s"),
            "", apart / most, 1e-6, "0", "(ω h)² = 4e-8, margin of 20");
}

/// A rotor under a torque with a welded body, and a slider moved by its weight and a load.
void bearings(Findings& f) {
  Scene scene;
  auto& m = scene.mechanism;
  m.gravity = {0.7, -9.81};
  const reference::Rotor<double> rotor{2.0, 0.03, 0.02};
  const reference::WeldedBody<double> tool{0.4, 1e-3, {0.1, 0.04}, {0.02, -0.03}};
  const reference::GuidedBody<double> slider{0.8, 0.4, {0.02, 0.01}, {3, -2}, {-0.03, 0.02}};
  m.bodies.push_back({"rotor", rotor.mass, rotor.inertia, {0.03, 0}, 0, {}, 5});
  m.bodies.push_back({"tool", tool.mass, tool.inertia, {0.12, 0.01}, 0.3, {}, 5});
  m.bodies.push_back({"slider", slider.mass, 1e-3, {1.02, 0.01}, 0});
  m.joints.push_back(RevoluteJoint{"bearing", {ground, 0}, {Vec2{0, 0}, Vec2{-0.03, 0}}, {}});
  const Vec2 d{std::cos(0.3) * 0.02 + std::sin(0.3) * -0.03, -std::sin(0.3) * 0.02 + std::cos(0.3) * -0.03};
  m.joints.push_back(RigidJoint{"weld", {0, 1}, {Vec2{0.07, 0.04}, -d}, 0.3});
  m.joints.push_back(TranslationalJoint{
      "guide", {ground, 2}, {Vec2{1, 0}, Vec2{-0.02, -0.01}}, {std::cos(0.4), std::sin(0.4)}, 0, {}});
  m.drives.push_back(TorqueDrive{"motor", 0, TorqueDrive::Against::time, {{0.0, 1.5}}});
  m.loads.push_back(ForceLoad{"pull", 2, {-0.05, 0.01}, {3, -2}});
  scene.run.duration = 0.2;
  scene.penalty.integrator = Integrator::dopri5;
  scene.penalty.stabilisation = Stabilisation::projection;
  scene.nonsmooth.scheme = Scheme::event_driven;
  scene.nonsmooth.tolerance = scene.penalty.tolerance = 1e-10;
  const Point g{0.7, -9.81};
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    Simulation simulation(scene, test::name_of(family));
    Forces now{std::vector<ElementForce>(simulation.layout().forces.size()), std::vector<double>(9)};
    double off[3] = {0, 0, 0};
    std::vector<double> q(9), v(9);
    test::watch_steps(simulation, [&](const Step& step) {
      step.state(step.t1, q, v);
      step.forces(step.t1, now);
      const reference::Turning<double> at{q[2], v[2], now.acceleration[2]};
      const auto own = reference::rotor_load(rotor, at, g);
      const auto weld = reference::weld_load(tool, at, g);
      const auto sliding = reference::guide_load(slider, reference::guided_acceleration(slider, g), g);
      const auto e = reference::direction(q[2]);
      const Point joint = tool.joint.x * e + tool.joint.y * reference::quarter_turn(e);
      const auto& f_bearing = now.elements[0];
      const auto& f_weld = now.elements[1];
      const auto& f_guide = now.elements[2];
      const auto& motor = now.elements[3];
      const auto apart = [](const ElementForce& f, const Point& force, double moment) {
        return std::max({std::abs(f.fx - force.x), std::abs(f.fy - force.y), std::abs(f.m - moment)});
      };
      off[0] = greatest(off[0], apart(f_bearing, own.reaction + weld.force, 0));
      off[0] = greatest(off[0], std::abs(motor.m - own.torque - weld.moment - cross(joint, weld.force)));
      off[1] = greatest(off[1], apart(f_weld, weld.force, weld.moment));
      off[2] = greatest(off[2], apart(f_guide, sliding.joint.force, sliding.joint.moment));
    });
    const std::pair<const char*, const char*> names[] = {
        {"rotor under a torque with a welded body", "bearing force and driving torque, greatest error"},
        {"rotor under a torque with a welded body", "force and moment of the weld, greatest error"},
        {"slider on an inclined guide with a load", "force and moment of the guide, greatest error"}};
    for (int i = 0; i < 3; ++i)
      f.at_most(
          claim_name(names[i].first, names[i].second, family == Family::penalty ? "penalty" : "event-driven"),
          "N, N m", off[i], 1e-11, "references/bearing_load at the state and its α", "rounding of some 50 N");
  }
}

}  // namespace freeplay::verification::force_claims
