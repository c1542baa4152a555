// The rules of the automatic scheme for hand-overs, on numbers alone: no scheme runs.
#include "formulations/automatic/handover.hpp"

#include <catch2/catch.hpp>

using namespace freeplay;

TEST_CASE("time stepping ends after a calm interval, twice as long after an unsuccessful return",
          "[automatic]") {
  HandoverTimes times(1);
  CHECK_FALSE(times.calm(0.09, 0));
  CHECK(times.calm(0.11, 0));
  CHECK_FALSE(times.calm(0.11, 0.05));  // an impact since
  times.take_over(1, "t = 1 s: too fast", 1);
  CHECK(times.calm(1.11, 0));  // the first return needs the usual calm interval
  times.give_back(1.2);
  times.take_over(1.25, "t = 1.25 s: too fast", 1);  // sooner than the interval of 0.1 s
  CHECK_FALSE(times.calm(1.4, 0));
  CHECK(times.calm(1.46, 0));
  times.give_back(1.5);
  times.take_over(3, "another", 1);  // the return lasted: the usual interval again
  CHECK(times.calm(3.11, 0));
  CHECK(times.count() == 3);
  CHECK(times.reasons() == "too fast; another");  // each once, without its time
  CHECK(times.longest() == Approx(0.25));
  CHECK(times.longest(7) == 7);
}

TEST_CASE("a waiting interval never exceeds a thousand time scales", "[automatic]") {
  HandoverTimes times(1);
  double t = 0;
  for (int i = 0; i < 40; ++i) {
    times.take_over(t, "again", 1);
    times.give_back(t);
  }
  CHECK(times.calm(t + 1001, 0));
  CHECK_FALSE(times.calm(t + 999, 0));
}

TEST_CASE("shrunk steps are distinguished from short ones by contacts, events and the longest steps",
          "[automatic]") {
  const auto thousand = [](StepShrinkage& s, double t, long events, bool crowded) {
    int requested = 0;
    for (int i = 0; i < 1000; ++i) requested += s.due();
    CHECK(requested == 1);
    return s.shrunk(t, events, crowded, 1);
  };
  StepShrinkage s;
  s.begin(0, 0);
  CHECK_FALSE(thousand(s, 0.5, 0, true));     // as usual
  CHECK_FALSE(thousand(s, 0.501, 0, false));  // short, but nothing touches
  CHECK(thousand(s, 0.502, 0, true));
  CHECK(thousand(s, 0.503, 100, false));  // a hundred events
  CHECK_FALSE(thousand(s, 0.6, 100, true));
}

TEST_CASE("a trial that saves time halves the work until the next, one that does not doubles it",
          "[automatic]") {
  constexpr long N = SchemeCosts::first_patience;
  SchemeCosts costs;
  costs.begin({0, 0});
  costs.end_events({1, 100});  // 0.01 s a factorisation
  costs.begin({1, 100});
  CHECK_FALSE(costs.stepping_costs_more({2, 100 + N - 1}));  // not yet compared
  CHECK(costs.stepping_costs_more({2, 100 + N}));            // 2e-5 s a factorisation
  costs.begin({2, 100 + N});
  costs.begin_trial();
  CHECK_FALSE(costs.trial_failed({2, 100 + N + N / 10 - 1}));
  CHECK(costs.trial_failed({2.05, 100 + N + N / 10}));  // 1e-5 s a factorisation
  costs.end_events({2.05, 100 + N + N / 10});
  CHECK(costs.patience() == 2 * N);
  CHECK_FALSE(costs.on_trial());
  costs.begin({2.05, 0});
  CHECK(costs.stepping_costs_more({3, 2 * N}));
  costs.begin({3, 0});
  costs.begin_trial();
  CHECK_FALSE(costs.trial_failed({10, 2 * N / 10}));  // it saves time, and ends
  CHECK_FALSE(costs.on_trial());
  CHECK(costs.patience() == N);
  CHECK(costs.trials() == 2);
  CHECK(costs.won() == 1);
}

TEST_CASE("if time stepping is faster, it keeps the state", "[automatic]") {
  SchemeCosts costs;
  costs.end_events({1, 1'000'000});
  costs.begin({1, 0});
  CHECK_FALSE(costs.stepping_costs_more({2, SchemeCosts::first_patience}));
  CHECK_FALSE(costs.on_trial());
}
