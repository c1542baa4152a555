// The list of claims that `freeplay verify` prints is a test as it stands.
#include <catch2/catch.hpp>

#include "verification/claims/claim.hpp"

using namespace freeplay::verification;

TEST_CASE("every claim holds", "[claims]") {
  for (const auto& set : claim_sets()) {
    const auto verdict = judge(set);
    INFO(table(verdict));
    CHECK(verdict.failure.empty());
    CHECK(verdict.findings.claims.size() > 0);
    for (const auto& c : verdict.findings.claims) {
      CAPTURE(c.quantity, c.measured, c.expected, c.bound);
      CHECK(c.holds());
    }
  }
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
