// The map of the extremes has no defect: `freeplay extremes` in the suite.
#include <unistd.h>
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "verification/extremes/extremes.hpp"
#include "verification/support.hpp"

using namespace freeplay;
using namespace freeplay::verification;

TEST_CASE("no extreme is silently wrong, hangs or crashes", "[extremes][program]") {
  test::TemporaryFolder folder;
  const auto place = folder.path().string();
  const auto o = test::freeplay("extremes -o " + place + "/out --document " + place + "/doc");
  CAPTURE(o.out, o.err);
  CHECK(o.status == 0);
  std::ifstream in(folder.path() / "out/extremes.json");
  REQUIRE(in);
  int right = 0, cells = 0;
  const auto document = nlohmann::json::parse(in);
  for (const auto& cell : document["cells"]) {
    CAPTURE(cell.dump());
    const auto outcome = cell["outcome"].get<std::string>();
    CHECK((outcome == "right" || outcome == "degraded" || outcome == "refused"));
    right += outcome == "right";
    ++cells;
  }
  CHECK(cells >= 148);
  // The middle of every axis is no extreme: most cells must be right, not merely excused.
  CHECK(right > 110);
  CHECK(std::filesystem::exists(folder.path() / "doc/figures/extremes.png"));
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
