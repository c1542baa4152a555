// Sets of claims, and their reports: terminal, verification.json, docs/verification/verification.md
// and docs/verification/verification.csv.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "verification/claims/claim.hpp"
#include "verification/claims/report_tables.hpp"

namespace freeplay::verification {
namespace {

#define CLAIM_SET(function, name, title) {name, title, function},
constexpr ClaimSet sets[] = {
#include "verification/claims/sets.def"
};
#undef CLAIM_SET

std::string expected(const Claim& c) {
  switch (c.assessed) {
    case Claim::Assessed::within:
      return fmt::format("{:.{}g} ± {:.2g}", c.expected, c.digits(), c.bound);
    case Claim::Assessed::relative:
      return fmt::format("{:.{}g} (1 ± {:.2g})", c.expected, c.digits(), c.bound);
    case Claim::Assessed::at_most:
      return fmt::format("≤ {:.2g}", c.bound);
    default:
      return fmt::format("{:.4g} to {:.4g}", c.expected, c.bound);
  }
}

/// The difference to the expected value; empty for a claim without one.
std::string off(const Claim& c) {
  return c.compared() ? fmt::format("{:.1e}", std::abs(c.measured - c.expected)) : "";
}

const char* name_of(Claim::Assessed assessed) {
  constexpr const char* names[] = {"within", "relative", "at most", "between"};
  return names[static_cast<int>(assessed)];
}

}  // namespace

int Claim::digits() const {
  if (!compared() || bound == 0 || expected == 0) return 8;
  const double share = assessed == Assessed::relative ? bound : bound / std::abs(expected);
  return static_cast<int>(std::clamp(2 + std::ceil(-std::log10(share)), 8.0, 15.0));
}

std::span<const ClaimSet> claim_sets() { return sets; }

bool Verdict::holds() const { return failure.empty() && std::ranges::all_of(findings.claims, &Claim::holds); }

Verdict assess(const ClaimSet& set, const Parts& parts) {
  Verdict v;
  v.set = &set;
  const auto start = std::chrono::steady_clock::now();
  try {
    for (const auto& part : parts) part.add(v.findings);
  } catch (const std::exception& e) {
    v.failure = e.what();
  }
  v.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return v;
}

std::string table(const Verdict& v) {
  std::string out = fmt::format("\n{} ({}, {:.1f} s)\n", v.set->title, v.set->name, v.seconds);
  for (const auto& c : v.findings.claims) {
    const auto numbers = fmt::format("{:.{}g}, expected {}{}", c.measured, c.digits(), expected(c),
                                     c.compared() ? ", off by " + off(c) : "");
    const auto verdict = c.holds() ? "holds" : "FAILS";
    const auto unit = c.unit.empty() ? "" : ", " + c.unit;
    out += fmt::format("  {} {}{}\n        {}\n", verdict, c.quantity, unit, numbers);
    if (!c.holds()) out += fmt::format("        expected from: {}; bound: {}\n", c.source, c.reason);
  }
  if (!v.failure.empty()) out += fmt::format("  FAILS the set did not run to its end: {}\n", v.failure);
  return out;
}

nlohmann::json to_json(const std::vector<Verdict>& verdicts) {
  auto document = nlohmann::json::array();
  for (const auto& v : verdicts) {
    auto claims = nlohmann::json::array();
    for (const auto& c : v.findings.claims)
      claims.push_back({{"quantity", c.quantity},
                        {"unit", c.unit},
                        {"measured", c.measured},
                        {"judged", name_of(c.assessed)},
                        {"expected", c.expected},
                        {"bound", c.bound},
                        {"source", c.source},
                        {"reason", c.reason},
                        {"holds", c.holds()}});
    document.push_back({{"name", v.set->name},
                        {"title", v.set->title},
                        {"seconds", v.seconds},
                        {"failure", v.failure},
                        {"claims", claims}});
  }
  return {{"sets", document}};
}

std::string requested(const std::vector<Verdict>& verdicts) {
  std::string text = asked_columns;
  for (const auto& v : verdicts) text += requested(v);
  return text;
}

std::string requested(const Verdict& verdict) {
  std::string rows;
  for (const auto& c : verdict.findings.claims)
    rows += fmt::format("{},{},{:.4g},{:.4g},{},\"{}\"\n", verdict.set->name, name_of(c.assessed), c.expected,
                        c.bound, c.unit, c.quantity);
  return rows;
}

std::string document(const std::vector<Verdict>& verdicts) {
  std::size_t all = 0, holding = 0;
  for (const auto& v : verdicts)
    for (const auto& c : v.findings.claims) {
      ++all;
      holding += c.holds();
    }
  std::string out = fmt::format(
      "# Verification\n"
      "\n"
      "Written by `freeplay verify --document docs/verification`; {} of {} claims hold.\n"
      "A claim compares a quantity of a run with an expected value from an independent source. Its "
      "bound was fixed before the run\n"
      "([how to add a claim](../../verification/README.md)).\n"
      "\n"
      "Claims are grouped by mechanism or problem. A row gives a quantity, its expected value and "
      "the source of this value. The columns\n"
      "give the deviation of each formulation, scheme or law from the expected value, and its "
      "bound; with \"rel.\" both are relative to\n"
      "the expected value. Where no value is expected, the quantity itself is bounded. A number in "
      "brackets refers to the reason of the\n"
      "bound below the table. [verification.csv](verification.csv) lists all claims with expected "
      "values and bounds. Run times are those\n"
      "of the machine that wrote this page.\n",
      holding, all);
  for (const auto& v : verdicts) {
    out += fmt::format("\n## {}\n\n`freeplay verify {}`, {:.0f} s\n", v.set->title, v.set->name, v.seconds);
    out += tables_by_subject(v.findings.claims);
    if (!v.failure.empty())
      out += fmt::format("\n**FAILS, the set did not run to its end:** {}\n", v.failure);
    std::vector<std::string> drawn;
    for (const auto& curve : v.findings.curves)
      if (std::ranges::find(drawn, curve.figure) == drawn.end()) {
        drawn.push_back(curve.figure);
        out += fmt::format("\n![{}](figures/{}.png)\n", v.set->title, curve.figure);
      }
  }
  return out;
}

}  // namespace freeplay::verification
