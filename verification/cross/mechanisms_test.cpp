// Both formulations on nine mechanisms (four slider-cranks, a loose big end, four-bars with one and two loose
// pins, pendulums, a free ring and journal) against the event-driven solutions of
// verification/references/impact_tables.hpp.
#include <catch2/catch.hpp>

#include "mechanism/scene.hpp"
#include "verification/references/impact_tables.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;

namespace {

void compare_with(const reference::ImpactRow (&rows)[3], const Scene& scene, Family family,
                  double (*time_bound)(int), double (*relative_bound)(int, double)) {
  const auto run = test::simulate(scene, family);
  REQUIRE(run.ending.status == Ending::Status::finished);
  const auto found = test::touches(run);
  double before = 0;
  for (int i = 0; i < 3; ++i) {
    const auto& expected = rows[i];
    CAPTURE(i, expected.t);
    REQUIRE(static_cast<int>(found.size()) > i);
    const auto& e = found[i];
    REQUIRE(run.contacts.at(static_cast<std::size_t>(e.contact)).name == expected.joint);
    const double relative = relative_bound(i, expected.t - before), speed = -expected.v_n_minus;
    CHECK(e.t == Approx(expected.t).margin(time_bound(i)).epsilon(0));
    CHECK(e.v_n_minus == Approx(expected.v_n_minus).margin(relative * speed).epsilon(0));
    CHECK(e.v_n_plus == Approx(expected.v_n_plus).margin(relative * speed).epsilon(0));
    CHECK(e.v_t_minus ==
          Approx(expected.v_t_minus).margin(relative * (speed + std::abs(expected.v_t_minus))).epsilon(0));
    CHECK(e.impulse_n == Approx(expected.impulse_n).margin(relative * expected.impulse_n).epsilon(0));
    CHECK(e.impulse_t == Approx(expected.impulse_t).margin(relative * expected.impulse_n).epsilon(0));
    before = expected.t;
  }
}

Scene load(const char* name) {
  auto scene = read_scene(test::scene_file(name));
  scene.run.duration = 0.035;
  scene.run.discard = 0;
  scene.instruments.clear();
  return scene;
}

}  // namespace

TEST_CASE("penalty meets the event-driven tables", "[cross][penalty]") {
  for (const auto& table : reference::impact_tables) {
    CAPTURE(table.scene);
    // Tolerance 1e-9 of the clearance and speed per step, some hundred steps a flight, and an amplification
    // of up to ten per impact: 1e-7, 1e-6, 1e-5 of a speed. A time is a position error over a speed: 1e-9 s
    // after one impact.
    compare_with(
        table.penalty, load(table.scene), Family::penalty,
        [](int i) { return i == 0   ? 1e-9
                           : i == 1 ? 3e-9
                                    : 1e-8; },
        [](int i, double) { return i == 0   ? 2e-7
                                   : i == 1 ? 2e-6
                                            : 2e-5; });
  }
}

TEST_CASE("nonsmooth meets the event-driven tables to first order in the step", "[cross][nonsmooth]") {
  for (const auto& table : reference::impact_tables) {
    CAPTURE(table.scene);
    auto scene = load(table.scene);
    scene.nonsmooth.step = 1e-6;
    // An impact is misplaced by up to a step, and each later one inherits that: 2h per impact. Rates change
    // over a step by about their size times h over the flight, at either end of it: 4h/flight per impact so
    // far.
    compare_with(
        table.nonsmooth, scene, Family::nonsmooth, [](int i) { return 2e-6 * (i + 1); },
        [](int i, double flight) { return 4e-6 * (i + 1) / flight; });
  }
}

TEST_CASE("first touch of the reference scene", "[cross][flores]") {
  // Flores et al. 2011, c = 0.25 mm at 200 rpm from the ideal configuration at top dead centre: free flight,
  // recomputed in two coordinates. Printed digits: 4.42296 ms, 0.112919 m/s; impulse 0.16700 N s at e = 0.46,
  // μ = 0.01.
  auto scene = read_scene(test::flores());
  scene.run.duration = 0.006;
  scene.run.discard = 0;
  const auto penalty = test::touch(test::simulate(scene, Family::penalty), 0);
  REQUIRE(penalty.t == Approx(4.422960035e-3).margin(1e-8).epsilon(0));
  REQUIRE(-penalty.v_n_minus == Approx(0.112919).margin(5e-7).epsilon(0));
  for (double h : {1e-5, 1e-6}) {
    scene.nonsmooth.step = h;
    const auto nonsmooth = test::touch(test::simulate(scene, Family::nonsmooth), 0);
    // Within a step; the gap's acceleration there is 26 m/s², so rates are off by up to 26 h each way.
    REQUIRE(nonsmooth.t == Approx(4.42296e-3).margin(h).epsilon(0));
    REQUIRE(-nonsmooth.v_n_minus == Approx(0.112919).margin(26 * h).epsilon(0));
    REQUIRE(nonsmooth.impulse_n == Approx(0.16700).epsilon(26 * h / 0.1129));
  }
}

TEST_CASE("the stiff limit: penalty tends to the impact law like K^(-2/5)", "[cross][limit]") {
  // The contact time shrinks as K^(-2/5), and with it what the second impact differs by from the event-driven
  // impact law. At K × 1 a contact takes 5 % of a flight, so the next order bends the observed exponent by up
  // to 0.02.
  const auto& exact = reference::impact_tables[0].nonsmooth[1];
  std::vector<double> K, time, speed;
  for (double factor : {1.0, 10.0, 100.0, 1000.0}) {
    auto scene = load("gudgeon");
    scene.run.duration = 0.009;
    scene.mechanism.surfaces[0].young = 207e9 * factor;
    scene.penalty.tolerance = 1e-11;
    const auto e = test::touch(test::simulate(scene, Family::penalty), 1);
    K.push_back(factor);
    time.push_back(std::abs(e.t - exact.t));
    speed.push_back(std::abs(e.v_n_minus - exact.v_n_minus));
  }
  const double p_time = test::observed_order(K, time), p_speed = test::observed_order(K, speed);
  CAPTURE(time, speed);
  REQUIRE(p_time > -0.43);
  REQUIRE(p_time < -0.37);
  REQUIRE(p_speed > -0.43);
  REQUIRE(p_speed < -0.37);
}
