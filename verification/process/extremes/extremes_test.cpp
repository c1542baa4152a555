// The map of extreme parameters has no defect: `freeplay extremes` as a test.
#include <unistd.h>

#include "verification/random_scenes/extremes/extremes.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using namespace freeplay::verification::random_scenes;

namespace {

/// The cells that may have another outcome than right, by name, each with the reason.
bool may_not_be_right(const std::string& axis, const std::string& label, const std::string& formulation) {
  struct Edge {
    const char* axis;
    const char* formulation;
    std::vector<std::string> labels;
  };
  static const Edge edges[] = {
      // A step is not short compared with the first flight.
      {"clearance (m)", "moreau-jean", {"1e-07", "1e-06"}},
      {"step (s)", "moreau-jean", {"0.001", "0.01"}},
      {"speed (rpm)", "moreau-jean", {"5e+03", "2e+04"}},
      {"restitution", "penalty", {"0"}},  // its damping factor would be infinite
      // Steps as long as a contact, or longer.
      {"rk4 step (s)", "penalty", {"3e-05", "0.0001", "0.001", "0.01"}},
      {"slider mass, relative", "penalty", {"1e+04"}},      // penetration exceeds the clearance
      {"slider mass, relative", "moreau-jean", {"1e+06"}},  // Painlevé's configuration
      {"slider mass, relative", "event-driven", {"1e+06"}},
      // hα = 2 and more: at the stability limit of rk4.
      {"alpha = beta, rk4 at 1e-5 s (1/s)", "penalty", {"2e+05", "2.5e+05", "3e+05", "4e+05", "1e+06"}},
      // Where |R| > 1, see the test below.
      {"h alpha at h beta = 0, rk4", "penalty", {"2", "3"}},
      {"h alpha at h beta = 0.3, rk4", "penalty", {"2", "3"}},
      {"h alpha at h beta = 1, rk4", "penalty", {"2", "3"}},
      {"h alpha at h beta = 2, rk4", "penalty", {"3"}},
      {"h alpha at h beta = 3, rk4", "penalty", {"0", "0.3", "1", "2", "3"}},
      {"scene", "penalty", {"parallelogram four-bar", "the same from a change point"}},
      {"scene", "moreau-jean", {"the same from a change point", "Painlevé's rod"}},
      {"scene", "event-driven", {"the same from a change point", "Painlevé's rod"}},
  };
  return std::ranges::any_of(edges, [&](const Edge& e) {
    return axis == e.axis && formulation == e.formulation &&
           std::ranges::find(e.labels, label) != e.labels.end();
  });
}

}  // namespace

TEST_CASE("no extreme case is silently wrong, hangs or crashes", "[extremes][long]") {
  test::TemporaryFolder folder;
  const auto place = folder.path().string();
  test::succeeded("extremes -o " + place + "/out --document " + place + "/doc");
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
  CHECK(cells >= 180);
  CHECK(std::filesystem::exists(folder.path() / "doc/figures/extremes.png"));
}

TEST_CASE("Baumgarte stabilisation keeps or loses Φ as the stability region of rk4 predicts", "[extremes]") {
  // The stability region itself: its ends on the negative real and the imaginary axis; R(−4) = 5 by
  // hand.
  CHECK(rk4_growth(2.785293563405282, 2.785293563405282) == Approx(1).epsilon(1e-9));
  CHECK(rk4_growth(0, 2 * std::sqrt(2.0)) == Approx(1).epsilon(1e-12));
  CHECK(rk4_growth(2, 0) == Approx(5).epsilon(1e-12));
  const auto cells = baumgarte_cells();
  std::size_t i = 0;
  int stable = 0, unstable = 0;
  for (const double hb : baumgarte_grid)
    for (const double ha : baumgarte_grid) {
      const double growth = rk4_growth(ha, hb);
      const auto verdict = judge_apart(cells.at(i++), 60);
      CAPTURE(ha, hb, growth, verdict.detail);
      // In 900 steps a factor of 0.97 removes an error and 1.03 multiplies it by 1e11; between them
      // Φ changes slowly.
      if (growth < 0.97) CHECK(verdict.outcome == Outcome::right);
      if (growth > 1.03) CHECK((verdict.outcome == Outcome::refused || verdict.outcome == Outcome::doubted));
      stable += growth < 0.97;
      unstable += growth > 1.03;
    }
  CHECK(stable >= 8);
  CHECK(unstable >= 10);
}

TEST_CASE("a cell that crashes, hangs or is wrong is classified as such", "[extremes]") {
  const auto outcome = [](auto assess, double seconds) {
    return judge_apart({"", "", 0, "", assess}, seconds).outcome;
  };
  CHECK(outcome([]() -> Verdict { std::abort(); }, 10) == Outcome::crashed);
  CHECK(outcome(
            []() -> Verdict {
              for (int i = 0; i < 1000; ++i) pause();
              return {};
            },
            0.2) == Outcome::hung);
  CHECK(outcome([]() -> Verdict { return {Outcome::silent, "x"}; }, 10) == Outcome::silent);
}
