// Event-driven integration stops where events follow each other faster than it resolves: each of
// its three counts.
#include <catch2/catch.hpp>

#include <cmath>

#include "formulations/event_driven/event_findings.hpp"

using namespace freeplay;

namespace {

/// Number of the calls next(k), k = 1, 2, …, that pass before the limit; at most `most`.
template <class F>
int passed(F next, int most) {
  for (int k = 1; k <= most; ++k)
    if (!next(k).empty()) return k;
  return most;
}

}  // namespace

TEST_CASE("event pace: 1000 events within a thousandth of the time scale are too many", "[event-driven]") {
  EventPace fast(1), slow(1);
  CHECK(passed([&](int k) { return fast.event(0.9e-6 * k); }, 5000) ==
        2000);  // the first thousand has no beginning
  CHECK(fast.exceeded());
  CHECK(passed([&](int k) { return slow.event(1.1e-6 * k); }, 5000) == 5000);
  CHECK_FALSE(slow.exceeded());
  CHECK(slow.events() == 5000);
}

TEST_CASE("event pace: 10,000 events within a fifth of the time scale, three times in a row, are too many",
          "[event-driven]") {
  EventPace fast(1), slow(1);
  CHECK(passed([&](int k) { return fast.event(1.9e-5 * k); }, 60'000) == 40'000);
  CHECK(passed([&](int k) { return slow.event(2.1e-5 * k); }, 60'000) == 60'000);
}

TEST_CASE("event pace: sixteen changes of mode at one instant are too many", "[event-driven]") {
  EventPace pace(1);
  CHECK(passed([&](int) { return pace.mode_change(0.5); }, 50) == 16);
  // The count starts again at another instant.
  EventPace two(1);
  for (int k = 0; k < 15; ++k) CHECK(two.mode_change(0.5).empty());
  CHECK(passed([&](int) { return two.mode_change(0.5 + 2e-6); }, 50) == 16);
}

TEST_CASE("event pace: 100 impacts of several contacts at shrinking intervals are too many",
          "[event-driven]") {
  // Intervals in a ratio r: the last 50 impacts take r⁵⁰ of the time of the first, 0.005 for r = 0.9.
  const auto shrinking = [](int k) { return 1e-3 * (1 - std::pow(0.9, k)); };
  EventPace alone(1), several(1), even(1), apart(1);
  CHECK(passed([&](int k) { return alone.impact(shrinking(k), {3}); }, 1000) == 1000);
  CHECK(passed([&](int k) { return several.impact(shrinking(k), {k % 2}); }, 1000) == 100);
  CHECK(passed([&](int k) { return even.impact(1e-5 * k, {k % 2}); }, 1000) == 1000);
  CHECK(passed([&](int k) { return apart.impact(2e-3 * k, {k % 2}); }, 1000) == 1000);
  EventPace still(1);
  CHECK(passed([&](int k) { return still.impact(0.5, {k % 2}); }, 1000) == 100);
  several.restart();
  CHECK_FALSE(several.exceeded());
  CHECK(several.impact(0, {1}).empty());
}

TEST_CASE("event pace: a shorter time scale replaces a longer one and is kept", "[event-driven]") {
  EventPace pace(1);
  pace.quicken(0.1);
  pace.quicken(0.5);
  CHECK(pace.time_scale() == 0.1);
  CHECK(passed([&](int k) { return pace.impact(2e-3 * k, {k % 2}); }, 1000) == 1000);
  CHECK(pace.instant() == Approx(1e-8));
}
