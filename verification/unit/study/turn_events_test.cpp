// Flights and impacts per revolution are those of one joint, independent of the others.
#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>

#include "measure/turns.hpp"

using namespace freeplay;

TEST_CASE("metrics per revolution count only events of their joint", "[study]") {
  // One revolution a second; in each, joint 1 separates at 90° and returns to contact at 180° by an
  // impact of 2 N s at 0.5 m/s. Joints 0 and 2 bounce in between.
  TurnRules rules;
  rules.speed = 2 * std::numbers::pi;
  rules.sampling = 1000;
  rules.ideal_maximum = 1;
  rules.joint = 1;
  rules.thresholds.impact_speed = 0.1;
  const auto metrics = [&](bool others) {
    TurnMeter meter(rules);
    const auto add_notes = [&](int joint, EventKind kind, double t) {
      ContactEvent e;
      e.contact = joint;
      e.kind = kind;
      e.t = t;
      e.v_n_minus = joint == 1 ? -0.5 : -3;
      e.impulse_n = joint == 1 ? 2 : 7;
      meter.event(e);
    };
    for (int turn = 0; turn < 4; ++turn) {
      add_notes(1, EventKind::separation, turn + 0.25);
      if (others)
        for (const int joint : {0, 2}) {
          add_notes(joint, EventKind::separation, turn + 0.3);
          add_notes(joint, EventKind::impact, turn + 0.4);
        }
      add_notes(1, EventKind::contact, turn + 0.5);
    }
    for (int i = 0; i <= 4000; ++i) meter.acceleration(i / 1000.0, std::cos(rules.speed * i / 1000.0));
    return meter.finish(4, 8);
  };
  const auto alone = metrics(false), among = metrics(true);
  for (const auto* m : {&alone, &among}) {
    CHECK(m->value[TurnMetrics::loss_angle] == Approx(90));
    CHECK(m->value[TurnMetrics::return_angle] == Approx(180));
    CHECK(m->value[TurnMetrics::flight_duration] == Approx(0.25));
    CHECK(m->flights.size() == 4);
  }
}
