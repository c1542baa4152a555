// The claim set "forces": forces of a run satisfy the Newton–Euler equations, agree with closed
// forms, and their time integrals are the impulses and the work. Here its scenes and the functions
// that run them (force_claims.hpp); its parts are in force_*.cpp.
#include "dynamics/assembly/assembly.hpp"
#include "io/files/csv.hpp"
#include "verification/claims/force_claims.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::force_claims {

Scene everything() { return read_scene(test::scene_file("forces")); }
State start_of_everything() { return assemble(everything().mechanism, RunOptions::Start::assembled); }

Scene nonsmooth(Scheme scheme) {
  auto scene = everything();
  scene.nonsmooth.scheme = scheme;
  scene.nonsmooth.step = 1e-5;
  return scene;
}

Scene penalty(const Way& way) {
  auto scene = everything();
  scene.penalty.integrator = way.integrator;
  scene.penalty.stabilisation = way.stabilisation;
  scene.penalty.friction = way.friction;
  scene.penalty.contact = way.contact;
  scene.penalty.step = 1e-6;
  scene.run.duration = way.duration;
  return scene;
}

Scene slider_crank(const reference::LoadedSliderCrank<double>& s) {
  Scene scene;
  auto& m = scene.mechanism;
  const Vec2 c{s.slider_centre.x, s.slider_centre.y};
  m.gravity = {s.gravity.x, s.gravity.y};
  const double a = s.crank_centre, b = s.rod_centre, x = s.crank_length + s.rod_length;
  m.bodies.push_back({"crank", s.crank_mass, s.crank_inertia, {a, 0}, 0, {}, s.speed});
  m.bodies.push_back({"rod", s.rod_mass, s.rod_inertia, {s.crank_length + b, 0}, 0});
  m.bodies.push_back({"slider", s.slider_mass, 1e-3, Vec2{x, 0} + c, 0});
  m.joints.push_back(RevoluteJoint{"main", {ground, 0}, {Vec2{0, 0}, Vec2{-a, 0}}, {}});
  m.joints.push_back(RevoluteJoint{"big_end", {0, 1}, {Vec2{s.crank_length - a, 0}, Vec2{-b, 0}}, {}});
  m.joints.push_back(RevoluteJoint{"gudgeon", {1, 2}, {Vec2{s.rod_length - b, 0}, -c}, {}});
  m.joints.push_back(TranslationalJoint{"guide", {ground, 2}, {Vec2{0, 0}, -c}, {1, 0}, 0, {}});
  m.drives.push_back(SpeedDrive{"motor", 0, s.speed, 0});
  m.loads.push_back(ForceLoad{"push", 2, {0, 0}, {s.load.x, s.load.y}});
  scene.run.duration = 2 * std::numbers::pi / std::abs(s.speed);
  scene.run.start = RunOptions::Start::ideal;
  scene.penalty.integrator = Integrator::dopri5;
  scene.penalty.stabilisation = Stabilisation::projection;
  scene.penalty.tolerance = 1e-10;
  return scene;
}

reference::LoadedSliderCrank<double> rig() {
  reference::LoadedSliderCrank<double> s;
  s.crank_length = 0.05;
  s.rod_length = 0.3;
  s.crank_mass = 17.9;
  s.crank_inertia = 0.460327;
  s.rod_mass = 1.13;
  s.rod_centre = 0.15;
  s.rod_inertia = 0.0153;
  s.slider_mass = 1.013;
  s.speed = reference::from_rpm(200.0);
  return s;
}

reference::LoadedSliderCrank<double> loaded() {
  auto s = rig();
  s.crank_centre = 0.02;
  s.rod_centre = 0.11;
  s.slider_centre = {0.03, -0.012};
  s.gravity = {0, -9.81};
  s.load = {-60, 25};
  return s;
}

Result run(const Scene& scene, Family family, std::vector<Observer*> observers,
           const std::optional<State>& start) {
  Simulation simulation(scene, test::name_of(family), {.start = start});
  return test::finished(simulation, std::move(observers));
}

Files files(const Scene& scene, Family family, const std::optional<State>& start) {
  test::TemporaryFolder folder;
  TrajectoryCsv trajectory(folder.path() / "trajectory.csv");
  ForcesCsv forces(folder.path() / "forces.csv");
  Simulation simulation(scene, test::name_of(family), {.start = start});
  auto result = test::finished(simulation, {&trajectory, &forces});
  trajectory.commit();
  forces.commit();
  return {test::Columns(folder.path() / "trajectory.csv"), test::Columns(folder.path() / "forces.csv"),
          std::move(result), simulation.layout()};
}

std::size_t find(const Layout& layout, const std::string& name) {
  for (std::size_t i = 0; i < layout.forces.size(); ++i)
    if (layout.forces[i].name == name) return i;
  throw std::runtime_error("no force element " + name);
}

}  // namespace freeplay::verification::force_claims

namespace freeplay::verification {

Parts forces() {
  using namespace force_claims;
  return {balance, tolerances, csv, slider_cranks, bearings, load_cell, torque_sensor, watching, redundant};
}

}  // namespace freeplay::verification
