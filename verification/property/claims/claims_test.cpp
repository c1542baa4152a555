// The list of claims of `freeplay verify` is itself a test; docs/verification/verification.md shows
// that list. Also the form of names, the verdict of a claim, and the tables of
// docs/verification/verification.md.
#include <deque>

#include "verification/claims/claim.hpp"
#include "verification/claims/report_tables.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay::verification;

namespace {

/// A row of docs/verification/verification.csv.
struct Requested {
  std::string set, assessed, name;  ///< name: unit and quantity
  double expected, bound;
};

/// The rows of a set.
std::vector<Requested> rows_of(const std::string& table, const std::string& set) {
  std::vector<Requested> rows;
  std::istringstream in(table);
  for (std::string line; std::getline(in, line);) {
    std::istringstream fields(line);
    Requested row;
    std::string expected, bound;
    std::getline(fields, row.set, ',');
    if (row.set != set) continue;
    std::getline(fields, row.assessed, ',');
    std::getline(fields, expected, ',');
    std::getline(fields, bound, ',');
    std::getline(fields, row.name);
    row.expected = std::stod(expected);
    row.bound = std::stod(bound);
    rows.push_back(row);
  }
  return rows;
}

/// The claims of a set, or of its part that begins at the row `first` of the set, agree with the page
/// within a hundredth.
void check_page(const std::string& page, const Verdict& verdict, std::size_t first, bool last) {
  INFO(
      "docs/verification/verification.md is older than what it shows; "
      "make it anew: scripts/pages --make verification");
  CAPTURE(verdict.set->name, first);
  const auto old = rows_of(page, verdict.set->name), now = rows_of(requested(verdict), verdict.set->name);
  REQUIRE(now.size() == verdict.findings.claims.size());
  REQUIRE((last ? old.size() == first + now.size() : old.size() > first + now.size()));
  for (std::size_t i = 0; i < now.size(); ++i) {
    const auto& row = old[first + i];
    CHECK(row.assessed == now[i].assessed);
    CHECK(row.name == now[i].name);
    CHECK(row.expected == Approx(now[i].expected).epsilon(0.01));
    CHECK(row.bound == Approx(now[i].bound).epsilon(0.01));
  }
}

std::string asked_page() {
  return freeplay::test::file_text(freeplay::test::source_folder() / "docs/verification/verification.csv");
}

/// Names are unique in a set and complete by themselves: subject and quantity are present, and no
/// bracket is open.
void check_names(const std::vector<Claim>& claims) {
  std::set<std::string> names;
  for (const auto& c : claims) {
    CAPTURE(c.quantity);
    const auto name = parts_of(c);
    CHECK(names.insert(c.quantity).second);
    CHECK_FALSE(name.subject.empty());
    CHECK_FALSE(name.quantity.empty());
    CHECK(claim_name(name.subject, name.quantity, name.scheme) == c.quantity);
    CHECK(c.quantity.find('"') == std::string::npos);
  }
}

/// The test of a set of claims, or of one of its parts.
class SetTest final : public Catch::ITestInvoker {
 public:
  SetTest(const ClaimSet& set, Parts parts, std::size_t first, bool last)
      : set_(set), parts_(std::move(parts)), first_(first), last_(last) {}
  void invoke() const override {
    const auto verdict = assess(set_, parts_);
    INFO(table(verdict));
    CHECK(verdict.failure.empty());
    CHECK_FALSE(verdict.findings.claims.empty());
    if (!last_) CHECK(verdict.findings.claims.size() == parts_.front().claims);
    check_page(asked_page(), verdict, first_, last_);
    check_names(verdict.findings.claims);
    for (const auto& c : verdict.findings.claims) {
      CAPTURE(c.quantity, c.measured, c.expected, c.bound);
      CHECK(c.holds());
    }
  }

 private:
  const ClaimSet& set_;
  Parts parts_;
  std::size_t first_;  ///< the claims of the set before these
  bool last_;          ///< none follow
};

/// Registers a test for each set, in a file of its name, so that sets run in separate parts
/// (scripts/check), and for each part of a set whose parts have numbers of claims.
struct SetTests {
  SetTests() {
    for (const auto& set : claim_sets()) {
      const auto parts = set.parts();
      if (parts.front().claims == 0) {
        add(set, set.name, set.name, parts, 0, true);
        continue;
      }
      std::size_t first = 0;
      for (std::size_t i = 0; i < parts.size(); first += parts[i++].claims)
        add(set, fmt::format("{}-{}", set.name, i + 1), fmt::format("{} (part {})", set.name, i + 1),
            {parts[i]}, first, i + 1 == parts.size());
    }
  }
  void add(const ClaimSet& set, const std::string& file, const std::string& what, const Parts& parts,
           std::size_t first, bool last) {
    // This set starts the C compiler.
    const bool program = set.parts == compiled_mechanisms;
    const auto& path = files.emplace_back(
        fmt::format("verification/{}/claims/claims-{}.cpp", program ? "process" : "property", file));
    const auto name = fmt::format(
        "every claim of the set {} holds and is listed in docs/verification/verification.csv", what);
    Catch::AutoReg(new SetTest(set, parts, first, last), {path.c_str(), 1}, {}, {name, "[claims]"});
  }
  std::deque<std::string> files;
};
const SetTests set_tests;

}  // namespace

TEST_CASE("the claims page lists its columns and only the claim sets of the program", "[claims]") {
  std::istringstream page(asked_page());
  CHECK(asked_page().starts_with(asked_columns));
  std::string line;
  for (std::getline(page, line); std::getline(page, line);) {
    CAPTURE(line);
    CHECK(std::ranges::any_of(
        claim_sets(), [&](const auto& set) { return line.starts_with(std::string(set.name) + ","); }));
  }
}

TEST_CASE("a claim fails outside its bound on either side, and for a NaN", "[claims]") {
  Claim c;
  c.expected = 2;
  c.bound = 0.5;
  for (const auto assessed : {Claim::Assessed::within, Claim::Assessed::relative, Claim::Assessed::at_most,
                              Claim::Assessed::between}) {
    c.assessed = assessed;
    c.measured = NAN;
    CHECK_FALSE(c.holds());
    c.measured = 4;
    CHECK_FALSE(c.holds());
  }
  c.assessed = Claim::Assessed::within;
  c.measured = 1.4;
  CHECK_FALSE(c.holds());
  c.measured = 1.6;
  CHECK(c.holds());
}

TEST_CASE("the page of claims has a table for each subject and a column for each scheme", "[claims]") {
  Findings f;
  f.within(claim_name("pendulum", "angle", "penalty"), "rad", 1.25, 1, 0.5, "theory", "tolerance");
  f.at_most("ball: penetration", "m", 0.25, 0.5, "0", "rounding");
  f.within(claim_name("pendulum", "angle", "event-driven"), "rad", 1.75, 1, 0.5, "theory", "rounding");
  f.relative(claim_name("pendulum", "rate", "event-driven"), "rad/s", 2.5, 2, 0.25, "|theory|", "rounding");
  f.between(claim_name("pendulum", "order", "penalty"), "", 4, 3.5, 4.5, "4", "");
  CHECK(tables_by_subject(f.claims) == R"(
### pendulum

| quantity | expected | source | penalty | event-driven |
| --- | --- | --- | --- | --- |
| angle, rad | 1 | theory | 0.25 ≤ 0.5 [1] | **FAILS: 0.75, bound 0.5** [2] |
| rate, rad/s | 2 | \|theory\| |  | rel. 0.25 ≤ 0.25 [2] |
| order |  | 4 | 3.5 ≤ 4 ≤ 4.5 |  |

Reasons of the bounds:

- [1] tolerance
- [2] rounding

### ball

| quantity | expected | source | deviation ≤ bound |
| --- | --- | --- | --- |
| penetration, m |  | 0 | 0.25 ≤ 0.5 |

Reason of the bounds: rounding.
)");
}

TEST_CASE("a subject with many schemes has a row for each claim", "[claims]") {
  Findings f;
  for (const char* scheme : {"a", "b", "c", "d", "e", "f", "g"})
    f.at_most(claim_name("scene", "residual", scheme), "", 0, 1, "0", "rounding");
  const auto text = tables_by_subject(f.claims);
  CHECK(text.find("| residual [a] |  | 0 | 0 ≤ 1 |") != std::string::npos);
  CHECK(text.find("| residual [g] |  | 0 | 0 ≤ 1 |") != std::string::npos);
}
