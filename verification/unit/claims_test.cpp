// The list of claims that `freeplay verify` prints is a test as it stands; docs/verification.md shows that list.
#include <fmt/format.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <deque>
#include <fstream>
#include <regex>
#include <string>

#include "verification/claims/claim.hpp"
#include "verification/support.hpp"

using namespace freeplay::verification;

namespace {

/// What a claim asks; a name may carry a number in parentheses that was measured.
std::string asks(const nlohmann::json& claim) {
  return std::regex_replace(claim["quantity"].get<std::string>(), std::regex(R"( \(-?[0-9.]+(e[-+]?\d+)?\))"),
                            "") +
         ", " + claim["unit"].get<std::string>() + ", " + claim["judged"].get<std::string>();
}

/// The set as the page has it asks the same within a hundredth.
void check_page(const nlohmann::json& page, const nlohmann::json& set) {
  INFO("docs/verification.md is older than what it shows; make it anew: scripts/pages --make verification");
  CAPTURE(set["name"].get<std::string>());
  const auto shown = std::ranges::find(page, set["name"], [](const auto& s) { return s["name"]; });
  REQUIRE(shown != page.end());
  const auto &old = (*shown)["claims"], &now = set["claims"];
  REQUIRE(old.size() == now.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    CHECK(asks(old[i]) == asks(now[i]));
    for (const auto* number : {"expected", "bound"})
      CHECK(old[i][number].get<double>() == Approx(now[i][number].get<double>()).epsilon(0.01));
  }
}

nlohmann::json page_sets() {
  std::ifstream file(freeplay::test::source_folder() / "docs/verification.json");
  return nlohmann::json::parse(file)["sets"];
}

/// The test of one set of claims.
class SetTest final : public Catch::ITestInvoker {
 public:
  explicit SetTest(const ClaimSet& set) : set_(set) {}
  void invoke() const override {
    const auto verdict = judge(set_);
    INFO(table(verdict));
    CHECK(verdict.failure.empty());
    CHECK_FALSE(verdict.findings.claims.empty());
    check_page(page_sets(), to_json({verdict})[0]);
    for (const auto& c : verdict.findings.claims) {
      CAPTURE(c.quantity, c.measured, c.expected, c.bound);
      CHECK(c.holds());
    }
  }

 private:
  const ClaimSet& set_;
};

/// Registers a test for each set, in a file of its own name, so that sets run in parts of their own (scripts/check).
struct SetTests {
  SetTests() {
    for (const auto& set : claim_sets()) {
      const auto& file = files.emplace_back(fmt::format("verification/claims/claims-{}.cpp", set.name));
      const auto name =
          fmt::format("every claim of the set {} holds, and the page of claims shows it", set.name);
      Catch::AutoReg(new SetTest(set), {file.c_str(), 1}, {}, {name, "[claims]"});
    }
  }
  std::deque<std::string> files;
};
const SetTests set_tests;

}  // namespace

TEST_CASE("the page of claims has every set", "[claims]") {
  CHECK(page_sets().size() == claim_sets().size());
}

TEST_CASE("a claim fails outside its bound, on either side, and for a NaN", "[claims]") {
  Claim c;
  c.expected = 2;
  c.bound = 0.5;
  for (const auto judged :
       {Claim::Judged::within, Claim::Judged::relative, Claim::Judged::at_most, Claim::Judged::between}) {
    c.judged = judged;
    c.measured = NAN;
    CHECK_FALSE(c.holds());
    c.measured = 4;
    CHECK_FALSE(c.holds());
  }
  c.judged = Claim::Judged::within;
  c.measured = 1.4;
  CHECK_FALSE(c.holds());
  c.measured = 1.6;
  CHECK(c.holds());
}
