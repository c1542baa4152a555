// Recorded forces, in addition to the claims of the set "forces": the force that an instrument
// measures at a joint, and the independence of forces from their observation.
#include "dynamics/assembly/assembly.hpp"
#include "simulation/trajectory.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

Scene everything() {
  auto scene = read_scene(test::scene_file("forces"));
  scene.nonsmooth.scheme = Scheme::event_driven;
  scene.run.duration = 6e-3;
  return scene;
}

/// All forces at the ends of the steps after `from`.
struct Record final : Observer {
  explicit Record(double from) : from(from) {}
  Wants wants() const override { return {.forces = true}; }
  void begin(const Layout& layout, const State& state) override {
    now.elements.resize(layout.forces.size());
    now.acceleration.resize(state.v.size());
  }
  void step(const Step& step) override {
    if (step.t1 <= from) return;
    now.clear();
    step.forces(step.t1, now);
    step.add_impulse(step.t0, step.t1, now);
    now.add(1, step.before());
    now.add(1, step.within());
    for (const auto& e : now.elements)
      values.insert(values.end(), {e.fx, e.fy, e.m, e.m_first, e.m_second, e.power});
    values.insert(values.end(), now.acceleration.begin(), now.acceleration.end());
  }
  double from;
  Forces now;
  std::vector<double> values;
};

}  // namespace

TEST_CASE("forces do not depend on when their observation begins", "[forces]") {
  for (const auto family : {Family::penalty, Family::nonsmooth})
    for (const auto scheme : {Scheme::event_driven, Scheme::moreau_jean}) {
      if (family == Family::penalty && scheme == Scheme::moreau_jean) continue;
      auto scene = everything();
      scene.nonsmooth.scheme = scheme;
      const auto start = assemble(scene.mechanism, scene.run.start);
      const auto watched = [&](bool from_the_start) {
        Simulation simulation(scene, test::name_of(family), {.start = start});
        Record early(0), late(3e-3);
        std::vector<Observer*> first{&early};
        if (!from_the_start) first.clear();
        REQUIRE(simulation.run({.until = 3e-3, .observers = first}).ending.status ==
                Ending::Status::finished);
        REQUIRE(simulation.run({.observers = {&late}}).ending.status == Ending::Status::finished);
        return late.values;
      };
      const auto a = watched(true), b = watched(false);
      CAPTURE(test::name_of(family), scheme == Scheme::moreau_jean);
      REQUIRE(a.size() > 1000);
      CHECK(a == b);
    }
}

TEST_CASE("the step before a knot of a torque table has nonzero length, and its rows hold finite numbers",
          "[forces]") {
  auto scene = everything();  // a knot at 4 ms
  scene.run.output_step = 1e-5;
  Simulation simulation(scene, "nonsmooth");
  Trajectory path;
  test::Listener listener;
  double reached = 0;
  listener.on_step = [&](const Step& step) {
    CHECK(step.t0 == reached);
    reached = step.t1;
  };
  simulation.run({.observers = {&path, &listener}});
  CHECK(reached == 6e-3);
  REQUIRE(path.size() == 601);
  for (std::size_t i = 0; i < path.size(); ++i)
    for (const double v : path.v(i)) REQUIRE(std::isfinite(v));
}

TEST_CASE("a load cell in a guide includes the friction of the guide", "[forces]") {
  // 3 N are not enough against 5 N of friction, 8 N are.
  for (const double pull : {3.0, 8.0})
    for (const auto family : {Family::penalty, Family::nonsmooth}) {
      const auto scene = read_scene(test::scene_file("tests/pulled_slider"),
                                    {fmt::format("loads.pull.force=[{}, 0]", pull)});
      Simulation simulation(scene, test::name_of(family));
      double last[2] = {NAN, NAN};
      test::Listener listener;
      listener.on_sample = [&](std::size_t channel, double, double value) { last[channel] = value; };
      simulation.run({.observers = {&listener}});
      CAPTURE(pull, test::name_of(family));
      CHECK(last[0] == Approx(-std::min(pull, 5.0)).epsilon(1e-6));
      CHECK(last[1] == Approx(2 * 9.81).epsilon(1e-9));
    }
}

TEST_CASE("forces of a time step exclude its impacts and include its lasting contacts", "[forces]") {
  auto scene = read_scene(test::scene_file("bouncing_ball"));
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  scene.nonsmooth.step = 1e-4;
  scene.run.duration = 1.5;  // at rest from 0.96 s
  Simulation simulation(scene, "nonsmooth");
  Forces now{std::vector<ElementForce>(1), std::vector<double>(3)};
  double last = 0, impulses = 0;
  int impacts = 0;
  test::Listener listener;
  listener.want.forces = true;
  listener.on_step = [&](const Step& step) {
    step.forces(step.t1, now);
    last = now.elements[0].fn;
    const double in_impact = step.within().elements[0].fn;
    impulses += in_impact;
    if (step.t1 < 0.9) CHECK(last == 0);
    impacts += in_impact > 0.01;
  };
  simulation.run({.observers = {&listener}});
  CHECK(last == Approx(0.3 * 9.81).epsilon(1e-9));
  CHECK(impacts >= 5);
  CHECK(impulses > 0.3 * 1.5 * 3.1);  // the first impact alone: m (1 + e) √(2 g h)
}
