#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <regex>

#include "verification/claims/claim.hpp"

namespace freeplay::verification {
namespace {

constexpr ClaimSet sets[] = {
    {"closed-forms", "Closed forms", closed_forms},
    {"restitution", "Restitution that contact laws deliver", restitution},
    {"impact-laws", "Impact laws", impact_laws},
    {"complementarity", "Solvers of the contact problem", complementarity},
    {"mechanisms", "Published mechanisms", mechanisms},
    {"gears", "Gears, racks, pins in slots, end stops", gears},
    {"oracle", "The paper's scene against a derivation that shares no code", oracle},
    {"forces", "Forces that come out", forces},
    {"unseen", "What no integrator sees by itself", unseen},
    {"chosen", "Steps that choose their length, and hand-overs to them", chosen},
    {"films", "Lubricated joints by every scheme", films},
    {"springs", "Springs beyond a constant rate, and bushings", springs},
    {"cams", "Cams and followers", cams},
    {"rescaling", "What the paper's rig owes to its speed", rescaling},
    {"promises", "What runs and comparisons promise", promises},
    {"assembly", "How a mechanism goes together", assembly},
    {"driving", "Prescribed motions, forces by curves, motors", driving},
    {"equilibrium", "Places of rest and small motions about them", equilibrium},
    {"joint-friction", "Friction in joints from their reactions", joint_friction},
    {"groups", "Many discs of one kind", groups},
    {"orders", "Orders of convergence", orders},
    {"invariants", "Invariants over long runs", invariants},
    {"stiff-limit", "One formulation against the other: the stiff limit", stiff_limit},
    {"statistics", "One formulation against the other: statistics of long runs", statistics}};

bool compared(const Claim& c) {
  return c.judged == Claim::Judged::within || c.judged == Claim::Judged::relative;
}

/// Digits that show the bound and one beyond it: 8 to 15.
int digits(const Claim& c) {
  if (!compared(c) || c.bound == 0 || c.expected == 0) return 8;
  const double share = c.judged == Claim::Judged::relative ? c.bound : c.bound / std::abs(c.expected);
  return static_cast<int>(std::clamp(2 + std::ceil(-std::log10(share)), 8.0, 15.0));
}

std::string expected(const Claim& c) {
  switch (c.judged) {
    case Claim::Judged::within:
      return fmt::format("{:.{}g} ± {:.2g}", c.expected, digits(c), c.bound);
    case Claim::Judged::relative:
      return fmt::format("{:.{}g} (1 ± {:.2g})", c.expected, digits(c), c.bound);
    case Claim::Judged::at_most:
      return fmt::format("≤ {:.2g}", c.bound);
    default:
      return fmt::format("{:.4g} to {:.4g}", c.expected, c.bound);
  }
}

/// How far a claim that is compared lies from what is expected; empty for one that is bounded only.
std::string off(const Claim& c) {
  return compared(c) ? fmt::format("{:.1e}", std::abs(c.measured - c.expected)) : "";
}

const char* name_of(Claim::Judged judged) {
  constexpr const char* names[] = {"within", "relative", "at most", "between"};
  return names[static_cast<int>(judged)];
}

}  // namespace

std::span<const ClaimSet> claim_sets() { return sets; }

bool Verdict::holds() const { return failure.empty() && std::ranges::all_of(findings.claims, &Claim::holds); }

Verdict judge(const ClaimSet& set) {
  Verdict v;
  v.set = &set;
  const auto start = std::chrono::steady_clock::now();
  try {
    v.findings = set.find();
  } catch (const std::exception& e) {
    v.failure = e.what();
  }
  v.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return v;
}

std::string table(const Verdict& v) {
  std::string out = fmt::format("\n{} ({}, {:.1f} s)\n", v.set->title, v.set->name, v.seconds);
  for (const auto& c : v.findings.claims) {
    const auto numbers = fmt::format("{:.{}g}, expected {}{}", c.measured, digits(c), expected(c),
                                     compared(c) ? ", off by " + off(c) : "");
    const auto verdict = c.holds() ? "holds" : "FAILS";
    const auto unit = c.unit.empty() ? "" : ", " + c.unit;
    out += fmt::format("  {} {}{}\n        {}\n", verdict, c.quantity, unit, numbers);
    if (!c.holds()) out += fmt::format("        expected from: {}; bound: {}\n", c.source, c.reason);
  }
  if (!v.failure.empty()) out += fmt::format("  FAILS could not be judged: {}\n", v.failure);
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
                        {"judged", name_of(c.judged)},
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
  return document;
}

std::string asked(const Verdict& verdict) {
  static const std::regex measured(R"( \(-?[0-9.]+(e[-+]?\d+)?\))");
  std::string rows;
  for (const auto& c : verdict.findings.claims)
    rows += fmt::format("{},{},{:.4g},{:.4g},{},\"{}\"\n", verdict.set->name, name_of(c.judged), c.expected,
                        c.bound, c.unit, std::regex_replace(c.quantity, measured, ""));
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
      "# Verification\n\nWritten by `freeplay verify --document docs/verification`; {} of {} claims hold. Each has a "
      "value, an expected "
      "value with its source, a bound fixed before the run with its reason, and a verdict "
      "([how to add one](../verification/README.md)). Times are those of the machine that wrote this.\n",
      holding, all);
  for (const auto& v : verdicts) {
    out += fmt::format(
        "\n## {}\n`freeplay verify {}`, {:.0f} s\n\n"
        "| quantity | measured | expected | off by | source | reason of the bound | |\n"
        "| --- | --- | --- | --- | --- | --- | --- |\n",
        v.set->title, v.set->name, v.seconds);
    const auto cell = [](std::string text) {
      for (std::size_t i = 0; (i = text.find('|', i)) != std::string::npos; i += 2) text.replace(i, 1, "\\|");
      return text;
    };
    for (const auto& c : v.findings.claims)
      out +=
          fmt::format("| {}{} | {:.{}g} | {} | {} | {} | {} | {} |\n", cell(c.quantity),
                      c.unit.empty() ? "" : ", " + c.unit, c.measured, std::max(10, digits(c)), expected(c),
                      off(c), cell(c.source), cell(c.reason), c.holds() ? "holds" : "**FAILS**");
    if (!v.failure.empty()) out += "\n**Could not be judged:** " + v.failure + "\n";
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
