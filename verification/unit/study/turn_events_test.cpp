// Statistics of turns from events and samples made by hand.
#include "measure/turns.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// A revolution lasts 1 s.
TurnRules rules_of(int joint) {
  TurnRules rules;
  rules.speed = 2 * std::numbers::pi;
  rules.sampling = 1000;
  rules.joint = joint;
  rules.thresholds.impact_speed = 0.1;
  return rules;
}

ContactEvent event(double t, int contact, EventKind kind, double approach = 0, double impulse = 0) {
  ContactEvent e;
  e.t = t;
  e.contact = contact;
  e.kind = kind;
  e.v_n_minus = -approach;
  e.impulse_n = impulse;
  return e;
}

}  // namespace

TEST_CASE("metrics per revolution of a signal and of one joint's events derived by hand", "[study]") {
  // a = 3 cos φ + 1 cos 5φ; the third revolution has one spike of 20.
  auto rules = rules_of(1);
  rules.ideal_maximum = 4;
  rules.discard = 1;
  TurnMeter meter(rules);
  for (int i = 1; i < 5000; ++i) {
    const double t = i / 1000.0, phi = rules.speed * t;
    meter.acceleration(t, i == 3300 ? 20 : 3 * std::cos(phi) + std::cos(5 * phi));
    meter.position(t, -2.0 * t * t + 8 * t);  // speed 8 − 4t: slows by 4 m/s², then gains
  }
  // In each revolution from 1 s on: flight from 90° to 180°; two impacts, one too slow to count.
  // Joints 0 and 2 bounce in between.
  for (int turn = 0; turn < 5; ++turn) {
    meter.event(event(turn + 0.25, 1, EventKind::separation));
    for (const int other : {0, 2}) {
      meter.event(event(turn + 0.3, other, EventKind::separation));
      meter.event(event(turn + 0.4, other, EventKind::impact, 3, 7));
    }
    meter.event(event(turn + 0.5, 1, EventKind::impact, 0.5, 2));
    meter.event(event(turn + 0.502, 1, EventKind::contact, 0.05, 2));
  }
  const auto m = meter.finish(5, 8);
  REQUIRE(m.peaks.size() == 4);  // samples from 1.000 to 4.999 s
  CHECK(m.value[TurnMetrics::peak_median] == Approx(4));
  CHECK(m.value[TurnMetrics::peak_max] == 20);
  CHECK(m.value[TurnMetrics::ratio_max] == 5);
  CHECK(m.spectrum[0] == Approx(3).epsilon(0.02));  // the spike adds white noise to its revolution
  CHECK(m.spectrum[4] == Approx(1).epsilon(0.02));
  CHECK(m.value[TurnMetrics::lines] == 2);
  CHECK(m.value[TurnMetrics::loss_angle] == Approx(90));
  CHECK(m.value[TurnMetrics::return_angle] == Approx(180));
  CHECK(m.value[TurnMetrics::flight_duration] == Approx(0.25));
  CHECK(m.flights.size() == 4);
  CHECK(m.flights[0].deceleration == Approx(4).epsilon(1e-6));
  CHECK(m.flights[2].deceleration == Approx(-4).epsilon(1e-6));
  CHECK(m.value[TurnMetrics::energy_per_turn] == Approx(2));
}

TEST_CASE("flights and impacts of several contacts are counted together", "[study]") {
  // Two contacts in anti-phase, each in flight for half the time: the sum of their impacts, and the
  // mean share.
  auto rules = rules_of(2);
  rules.others = {5};
  TurnMeter meter(rules);
  for (int k = 0; k < 4; ++k) {
    meter.event(event(k, 2, EventKind::contact, 1));
    meter.event(event(k + 0.25, 5, EventKind::separation));
    meter.event(event(k + 0.5, 2, EventKind::separation));
    meter.event(event(k + 0.6, 7, EventKind::contact, 1));  // of a joint that is not counted
    meter.event(event(k + 0.75, 5, EventKind::contact, 1));
  }
  const auto m = meter.finish(4, 0);
  CHECK(m.value[TurnMetrics::impacts_per_turn] == 2);
  // The first flight of contact 5 began at its separation, that of contact 2 before.
  CHECK(m.flights.size() == 7);
  CHECK(m.value[TurnMetrics::flight_share] == Approx(0.5));
  CHECK(std::ranges::count(m.flights, 5, &Flight::contact) == 4);
}
