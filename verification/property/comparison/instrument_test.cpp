// Instruments record the same motion in both formulations and at any step size; their filters agree
// with closed forms.
#include "simulation/instrument.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "simulation/trajectory.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// The accelerometer's samples until `duration`.
std::vector<double> signal(Scene scene, Family family, double duration) {
  scene.run.duration = duration;
  scene.run.discard = 0;
  Simulation simulation(scene, test::name_of(family));
  std::vector<double> samples;
  test::Listener listener;
  listener.on_sample = [&](std::size_t, double, double value) { samples.push_back(value); };
  REQUIRE(simulation.run({.observers = {&listener}}).ending.status == Ending::Status::finished);
  return samples;
}

double apart(const std::vector<double>& a, const std::vector<double>& b) {
  REQUIRE(a.size() == b.size());
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

Scene rig() {
  auto scene = read_scene(test::flores());
  scene.penalty.contact = ContactLaw::exact;
  scene.penalty.tolerance = 1e-11;
  return scene;
}

constexpr double until = 0.0105;  // s: three impacts, before they accumulate

}  // namespace

TEST_CASE("the recorded signal of a time-stepping run converges with the step size", "[instruments]") {
  auto scene = rig();
  scene.nonsmooth.scheme = Scheme::event_driven;
  const auto exact = signal(scene, Family::nonsmooth, until);
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  const auto error_at = [&](double h) {
    scene.nonsmooth.step = h;
    return apart(signal(scene, Family::nonsmooth, until), exact);
  };
  // Impacts act at some instant in their step: first order. The error scatters with that instant;
  // five steps average it.
  test::check_order({4e-5, 2e-5, 1e-5, 5e-6, 2.5e-6}, error_at, 0.7, 1.3);
}

TEST_CASE("the recorded signals of both formulations agree as contacts stiffen", "[instruments]") {
  auto scene = rig();
  scene.nonsmooth.scheme = Scheme::event_driven;
  const auto exact = signal(scene, Family::nonsmooth, until);
  double greatest = 0;
  for (double x : exact) greatest = std::max(greatest, std::abs(x));
  REQUIRE(greatest > 100);  // the impacts are visible
  std::vector<double> stiffness, errors;
  for (const double factor : {1.0, 1e2, 1e4}) {
    scene.mechanism.surfaces[0].young = 207e9 * factor;
    stiffness.push_back(factor);
    errors.push_back(apart(signal(scene, Family::penalty, until), exact));
  }
  CAPTURE(errors, greatest);
  // The exponent of the contact time, as for times and impulses; samples fall anywhere in a pulse,
  // hence the wide bound.
  const double exponent = test::observed_order(stiffness, errors);
  CHECK(exponent > -0.5);
  CHECK(exponent < -0.3);
  CHECK(errors.back() < 0.01 * greatest);
}

TEST_CASE("Butterworth low-pass filters of every order: gain, cut-off, impulse", "[instruments]") {
  const double cut = 100;
  for (int order = 1; order <= 8; ++order) {
    CAPTURE(order);
    // The gain is 1/√2 for a sine at the cut-off, 1/√(1 + 4ⁿ) at twice it:
    // |H|² = 1/(1 + (f/f_c)²ⁿ).
    for (const double ratio : {0.5, 1.0, 2.0}) {
      LowPass filter(cut, order);
      filter.reset(0);
      const double w = 2 * std::numbers::pi * cut * ratio, h = 1e-6;
      double greatest = 0;
      for (int i = 0; i < 200000; ++i) {
        const double t = i * h;
        // mean of sin over the piece
        filter.advance(h, (std::cos(w * t) - std::cos(w * (t + h))) / (w * h));
        if (t > 0.15) greatest = std::max(greatest, std::abs(filter.output()));
      }
      CHECK(greatest == Approx(1 / std::sqrt(1 + std::pow(ratio, 2 * order))).epsilon(1e-3));
    }
    LowPass constant(cut, order), impulse(cut, order);
    constant.reset(3);
    constant.advance(0.01, 3);
    CHECK(constant.output() == Approx(3).epsilon(1e-12));
    // The integral of the response to a unit impulse is the static gain, 1.
    impulse.reset(0);
    impulse.add_jump(1);
    double sum = 0, last = impulse.output();
    for (int i = 0; i < 100000; ++i) {
      impulse.advance(1e-6, 0);
      sum += 0.5e-6 * (last + impulse.output());
      last = impulse.output();
    }
    CHECK(sum == Approx(1).epsilon(1e-4));
  }
}

TEST_CASE("an encoder counts, an LVDT follows, and noise has its standard deviation", "[instruments]") {
  test::Listener listener;
  double squares = 0;
  int count[3] = {0, 0, 0};
  const double step = 2 * std::numbers::pi / 100;
  listener.on_sample = [&](std::size_t i, double t, double value) {
    ++count[i];
    if (i == 0) {
      CHECK(std::abs(value / step - std::round(value / step)) < 1e-9);
      CHECK(value <= 2 * t + 1e-9);
      CHECK(value > 2 * t - step - 1e-9);
    } else if (i == 1) {
      CHECK(value == Approx(0.1 * std::sin(2 * t)).margin(1e-8));
    } else {
      squares += std::pow(value - 0.1 * std::cos(2 * t), 2);
    }
  };
  Simulation(read_scene(test::scene_file("tests/measured_wheel")), "nonsmooth")
      .run({.until = 1, .observers = {&listener}});
  CHECK(count[0] == 50);
  CHECK(count[1] == 50);
  // A standard deviation from n samples scatters by 1/√(2n).
  CHECK(std::sqrt(squares / count[2]) == Approx(0.5).epsilon(4 / std::sqrt(2.0 * count[2])));
}

// Recorded forces, in addition to the claims of the set "forces": the force that an instrument
// measures at a joint, and the independence of forces from their observation.

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
