// The map of the extremes has no defect: `freeplay extremes` in the suite.
#include <unistd.h>
#include <catch2/catch.hpp>

#include "verification/extremes/extremes.hpp"

using namespace freeplay::verification;

TEST_CASE("no extreme is silently wrong, hangs or crashes", "[extremes]") {
  auto cells = rig_cells();
  for (auto& c : special_cells()) cells.push_back(std::move(c));
  int right = 0;
  for (const auto& cell : cells) {
    const auto verdict = judge_apart(cell, 200);
    CAPTURE(cell.axis, cell.label, cell.formulation, verdict.detail);
    CHECK_FALSE(is_defect(verdict.outcome));
    right += verdict.outcome == Outcome::right;
  }
  // The middle of every axis is no extreme: most cells must be right, not merely excused.
  CHECK(right > 110);
}

TEST_CASE("a cell that crashes, hangs or lies is told apart", "[extremes]") {
  const auto outcome = [](auto judge, double seconds) {
    return judge_apart({"", "", 0, "", judge, {}}, seconds).outcome;
  };
  CHECK(outcome([]() -> Judged { std::abort(); }, 10) == Outcome::crashed);
  CHECK(outcome(
            []() -> Judged {
              for (int i = 0; i < 1000; ++i) pause();
              return {};
            },
            0.2) == Outcome::hung);
  CHECK(outcome([]() -> Judged { return {Outcome::wrong, "x"}; }, 10) == Outcome::wrong);
}
