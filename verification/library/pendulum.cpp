// A mechanism built in code: a pendulum with clearance in its pivot. Each part checks its results;
// the exit status is the number of failed checks.
#include <freeplay.hpp>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace {

int failures = 0;
void expect(bool holds, const char* what) {
  std::printf("%s: %s\n", holds ? "ok" : "FAILED", what);
  failures += !holds;
}

freeplay::Scene pendulum(double clearance) {
  freeplay::Scene scene;
  auto& m = scene.mechanism;
  m.gravity = {0, -9.81};
  m.surfaces.push_back(
      {.name = "steel", .young = 207e9, .poisson = 0.3, .restitution = 0.8, .friction = 0.05});
  m.bodies.push_back({.name = "arm", .mass = 1.2, .inertia = 0.03, .position = {0.25, 0}});
  m.joints.push_back(freeplay::RevoluteJoint{
      .name = "pivot",
      .between = {freeplay::ground, 0},  // bearing on the ground, journal on the arm
      .at = {{{0, 0}, {-0.25, 0}}},      // each in its body's frame
      .clearance = freeplay::Clearance{.radial = clearance, .bearing_radius = 0.01, .surface = 0}});
  scene.run.duration = 0.5;
  return scene;
}

/// The pivot's load: greatest force, impulse of the whole run, impacts, lowest position of the arm.
class PivotLoad final : public freeplay::Observer {
 public:
  double greatest = 0, lowest = 0;      // N, m
  double impulse_x = 0, impulse_y = 0;  // N s
  int impacts = 0;

  freeplay::Wants wants() const override { return {.forces = true}; }
  void begin(const freeplay::Layout& layout, const freeplay::State& state) override {
    for (std::size_t i = 0; i < layout.forces.size(); ++i)
      if (layout.forces[i].name == "pivot") pivot_ = i;
    q_.resize(state.q.size());
    v_.resize(state.v.size());
  }
  void step(const freeplay::Step& step) override {
    step.forces(step.t1, now_);
    const auto& f = now_.elements[pivot_];
    greatest = std::fmax(greatest, std::hypot(f.fx, f.fy));

    sum_.clear();
    sum_.add(1, step.before());  // impacts at the beginning of the step
    sum_.add(1, step.within());  // and those that belong to no instant of it
    step.add_impulse(step.t0, step.t1, sum_);
    impulse_x += sum_.elements[pivot_].fx;
    impulse_y += sum_.elements[pivot_].fy;

    step.state(0.5 * (step.t0 + step.t1), q_, v_);
    lowest = std::fmin(lowest, q_[1]);
  }
  void event(const freeplay::Event& e) override { impacts += e.kind == freeplay::EventKind::impact; }

 private:
  std::size_t pivot_ = 0;
  freeplay::Forces now_, sum_;
  std::vector<double> q_, v_;
};

/// Requests a stop of the run at the third impact.
class Third final : public freeplay::Observer {
 public:
  std::atomic<bool> reached = false;
  void event(const freeplay::Event& e) override {
    if (e.kind == freeplay::EventKind::impact && ++count_ == 3) reached = true;
  }

 private:
  int count_ = 0;
};

bool same(const freeplay::State& a, const freeplay::State& b) {
  return a.t == b.t && a.q == b.q && a.v == b.v;
}

void forces(const char* formulation) {
  const auto scene = pendulum(0.5e-3);
  freeplay::Simulation simulation(scene, formulation);
  const auto before = simulation.state();
  PivotLoad load;
  const auto result = simulation.run({.observers = {&load}});
  const auto after = simulation.state();
  std::printf("%s: %d impacts, greatest force %.4g N, lowest %.4g m\n", formulation, load.impacts,
              load.greatest, load.lowest);
  expect(result.ending.status == freeplay::Ending::Status::finished, "the run finished");
  expect(load.impacts > 0 && load.lowest < -0.2, "it fell and had impacts");
  // Momentum: only the pivot's impulse and gravity's act.
  const double m = scene.mechanism.bodies[0].mass, g = -9.81;
  const double error = std::hypot(load.impulse_x - m * (after.v[0] - before.v[0]),
                                  load.impulse_y + m * g * after.t - m * (after.v[1] - before.v[1]));
  std::printf("momentum is kept to %.2g N s\n", error);
  expect(error < 1e-6, "impulses are the change of momentum");
}

void stopping() {
  freeplay::Simulation simulation(pendulum(0.5e-3), "nonsmooth");
  Third third;
  const auto result = simulation.run({.observers = {&third}, .stop = freeplay::StopToken(third.reached)});
  expect(result.ending.status == freeplay::Ending::Status::interrupted, "the flag stopped the run");
  expect(simulation.t() < 0.5, "before its end");

  const auto rest = simulation.run();  // without the stop request it continues
  expect(rest.ending.status == freeplay::Ending::Status::finished && simulation.t() == 0.5, "and it went on");
}

void snapshots(const char* formulation) {
  freeplay::Simulation simulation(pendulum(0.5e-3), formulation);
  simulation.run({.until = 0.2});
  const auto here = simulation.snapshot();
  simulation.run();
  const auto first = simulation.state();

  simulation.restore(here);
  simulation.run();
  expect(same(simulation.state(), first), "the restored simulation repeats the run bit for bit");

  here.write("here.snapshot");
  freeplay::Simulation another(pendulum(0.5e-3), formulation);
  another.restore(freeplay::Snapshot::read("here.snapshot"));
  another.run();
  expect(same(another.state(), first), "another simulation repeats it from the file");
}

void threads() {
  const std::vector<double> clearances{0.1e-3, 0.2e-3, 0.5e-3, 1e-3};
  std::vector<freeplay::State> ends(clearances.size());
  std::vector<std::thread> workers;
  for (std::size_t i = 0; i < clearances.size(); ++i)
    workers.emplace_back([&, i] {
      freeplay::Simulation simulation(pendulum(clearances[i]), i % 2 ? "penalty" : "nonsmooth");
      simulation.run();
      ends[i] = simulation.state();
    });
  for (auto& worker : workers) worker.join();

  bool equal = true;
  for (std::size_t i = 0; i < clearances.size(); ++i) {
    freeplay::Simulation simulation(pendulum(clearances[i]), i % 2 ? "penalty" : "nonsmooth");
    simulation.run();
    equal &= same(simulation.state(), ends[i]);
  }
  expect(equal, "threads yield the same bits as sequential runs");
}

template <class Error>
std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    std::printf("refused: %s\n", e.what());
    return e.what();
  }
  return "";
}

void errors() {
  auto unknown = [] { pendulum(0.5e-3).set("joints.pivot.colour", "red"); };
  expect(refusal<freeplay::SceneError>(unknown).find("joints.pivot.colour") != std::string::npos,
         "an unknown key");

  auto scene = pendulum(0.5e-3);
  scene.mechanism.surfaces[0].restitution.reset();
  auto lacking = [&] { freeplay::Simulation(scene, "nonsmooth"); };
  expect(refusal<freeplay::ModelError>(lacking).find("surfaces.steel.restitution") == 0,
         "a missing value that the formulation requires");

  auto pointless = pendulum(0.5e-3);
  std::get<freeplay::RevoluteJoint>(pointless.mechanism.joints[0]).between = {freeplay::ground, 7};
  auto nothing = [&] { freeplay::Simulation(pointless, "penalty"); };
  expect(refusal<freeplay::ModelError>(nothing).find("joints.pivot") == 0, "an index that names nothing");

  auto weightless = pendulum(0.5e-3);
  weightless.mechanism.bodies[0].mass = 0;
  auto light = [&] { freeplay::Simulation(weightless, "penalty"); };
  expect(refusal<freeplay::ModelError>(light).find("bodies.arm.mass") == 0, "a value out of range");

  freeplay::Simulation penalty(pendulum(0.5e-3), "penalty"), nonsmooth(pendulum(0.5e-3), "nonsmooth");
  const auto other = penalty.snapshot();
  auto foreign = [&] { nonsmooth.restore(other); };
  expect(!refusal<freeplay::SnapshotError>(foreign).empty(), "a snapshot of another formulation");
}

}  // namespace

void own_forces() {
  auto scene = pendulum(0.5e-3);
  const auto stiff = freeplay::Simulation(scene, "penalty").run();
  auto law = std::make_shared<freeplay::OwnLaw>();
  law->name = "soft", law->digest = "1";  // distinguishes it from others in the identity of its runs
  law->force = [](const void*, const char*, double delta, double rate, double v0) {
    return 1e8 * delta * (1 + 0.4 * rate / v0);  // N, at δ > 0 (m), its rate and v₀ > 0 (m/s)
  };
  scene.penalty.own = law;
  const auto soft = freeplay::Simulation(scene, "penalty").run();
  expect(soft.ending.status == freeplay::Ending::Status::finished, "a run with a law of its own");
  expect(soft.contacts[0].penetration > stiff.contacts[0].penetration, "a softer law, a deeper contact");

  scene.mechanism.loads.push_back(freeplay::ForceLoad{.name = "breeze", .body = 0});
  auto wind = std::make_shared<freeplay::OwnForce>();
  wind->name = "wind", wind->digest = "1";
  wind->force = [](const void*, const char*, double t, const freeplay::Vec2&, const freeplay::Vec2& v) {
    const double speed = 3 * t - v.x();
    return freeplay::Vec2{0.4 * speed * std::abs(speed), 0};
  };
  freeplay::put(scene, {.law = law, .forces = {{"breeze", wind}}});
  const auto blown = freeplay::Simulation(scene, "penalty").run();
  expect(blown.ending.status == freeplay::Ending::Status::finished, "a run in a wind of its own");
  expect(blown.ledger.load != 0, "the wind does work");
}

int main() {
  own_forces();
  for (const char* formulation : {"nonsmooth", "penalty"}) {
    forces(formulation);
    snapshots(formulation);
  }
  stopping();
  threads();
  errors();
  return failures;
}
