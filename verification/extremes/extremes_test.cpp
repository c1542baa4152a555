// The map of the extremes has no defect: `freeplay extremes` in the suite.
#include <unistd.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "verification/extremes/extremes.hpp"
#include "verification/support.hpp"

using namespace freeplay;
using namespace freeplay::verification;

namespace {

/// The cells that may be other than right, by name, each with why.
bool may_not_be_right(const std::string& axis, const std::string& label, const std::string& formulation) {
  struct Edge {
    const char* axis;
    const char* formulation;
    std::vector<std::string> labels;
  };
  static const Edge edges[] = {
      // A step is no short part of the first flight.
      {"clearance (m)", "moreau-jean", {"1e-07", "1e-06"}},
      {"step (s)", "moreau-jean", {"0.001", "0.01"}},
      {"speed (rpm)", "moreau-jean", {"5e+03", "2e+04"}},
      {"restitution", "penalty", {"0"}},  // its damping factor would be infinite
      // Steps as long as a contact, or longer.
      {"rk4 step (s)", "penalty", {"3e-05", "0.0001", "0.001", "0.01"}},
      {"slider mass, relative", "penalty", {"1e+04"}},      // the wall yields by more than the clearance
      {"slider mass, relative", "moreau-jean", {"1e+06"}},  // Painlevé's
      {"slider mass, relative", "event-driven", {"1e+06"}},
      // 2 and more over the step: at rk4's limit.
      {"alpha = beta, rk4 at 1e-5 s (1/s)", "penalty", {"2e+05", "2.5e+05", "3e+05", "4e+05", "1e+06"}},
      {"scene", "penalty", {"parallelogram four-bar", "the same from a change point"}},
      {"scene", "moreau-jean", {"the same from a change point", "Painlevé's rod"}},
      {"scene", "event-driven", {"Painlevé's rod"}},
  };
  return std::ranges::any_of(edges, [&](const Edge& e) {
    return axis == e.axis && formulation == e.formulation &&
           std::ranges::find(e.labels, label) != e.labels.end();
  });
}

}  // namespace

TEST_CASE("no extreme is silently wrong, hangs or crashes", "[extremes][program]") {
  test::TemporaryFolder folder;
  const auto place = folder.path().string();
  const auto o = test::freeplay("extremes -o " + place + "/out --document " + place + "/doc");
  CAPTURE(o.out, o.err);
  CHECK(o.status == 0);
  std::ifstream in(folder.path() / "out/extremes.json");
  REQUIRE(in);
  int cells = 0;
  const auto document = nlohmann::json::parse(in);
  for (const auto& cell : document["cells"]) {
    CAPTURE(cell.dump());
    const auto outcome = cell["outcome"].get<std::string>();
    const bool excused = may_not_be_right(cell["axis"], cell["label"], cell["formulation"]);
    CHECK((outcome == "right" || (excused && (outcome == "degraded" || outcome == "refused"))));
    ++cells;
  }
  CHECK(cells >= 148);
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
