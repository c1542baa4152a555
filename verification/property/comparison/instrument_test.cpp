// Instruments record the same motion in both formulations and at any step size; their filters agree
// with closed forms.
#include "simulation/instrument.hpp"
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
