// A claim: a measured value, its expected value with a source, a bound that was fixed before the
// run with its reason, and the verdict. The sets of claims in this folder are run by `freeplay
// verify`, which writes their reports, and by the tests.
#pragma once

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace freeplay::verification {

/// The greater of two values, or NaN if either is NaN, which std::max would drop.
inline double greatest(double a, double b) { return a >= b || std::isnan(a) ? a : b; }

/// The name of a claim, "subject: quantity [scheme]"; without a scheme no brackets. The subject is
/// the mechanism or problem, the quantity a noun phrase, and the scheme a formulation, an
/// integrator or a law.
inline std::string claim_name(std::string_view subject, std::string_view quantity,
                              std::string_view scheme = {}) {
  std::string name{subject};
  name.append(": ").append(quantity);
  if (!scheme.empty()) name.append(" [").append(scheme).append("]");
  return name;
}

struct Claim {
  enum class Assessed {
    within,    ///< |measured − expected| ≤ bound
    relative,  ///< |measured − expected| ≤ bound |expected|
    at_most,   ///< measured ≤ bound
    between    ///< expected ≤ measured ≤ bound
  };
  std::string quantity;  ///< the name: claim_name()
  std::string unit;
  double measured = 0;
  Assessed assessed = Assessed::within;
  double expected = 0, bound = 0;
  std::string source;  ///< of the expected value
  std::string reason;  ///< of the bound

  /// Whether the deviation from an expected value is bounded, not the value itself.
  bool compared() const { return assessed == Assessed::within || assessed == Assessed::relative; }
  /// Significant digits of the expected value that resolve a tenth of the bound: 8 to 15.
  int digits() const;
  bool holds() const {
    switch (assessed) {
      case Assessed::within:
        return std::abs(measured - expected) <= bound;
      case Assessed::relative:
        return std::abs(measured - expected) <= bound * std::abs(expected);
      case Assessed::at_most:
        return measured <= bound;
      default:
        return expected <= measured && measured <= bound;
    }
  }
};

/// The curve from which a claim was evaluated, for docs/verification/verification.md.
struct Curve {
  std::string figure, title, x_label, y_label;
  std::vector<double> x, y;
};

struct Findings {
  std::vector<Claim> claims;
  std::vector<Curve> curves;

  void within(std::string quantity, std::string unit, double measured, double expected, double bound,
              std::string source, std::string reason) {
    claims.push_back({std::move(quantity), std::move(unit), measured, Claim::Assessed::within, expected,
                      bound, std::move(source), std::move(reason)});
  }
  void relative(std::string quantity, std::string unit, double measured, double expected, double bound,
                std::string source, std::string reason) {
    claims.push_back({std::move(quantity), std::move(unit), measured, Claim::Assessed::relative, expected,
                      bound, std::move(source), std::move(reason)});
  }
  void at_most(std::string quantity, std::string unit, double measured, double bound, std::string source,
               std::string reason) {
    claims.push_back({std::move(quantity), std::move(unit), measured, Claim::Assessed::at_most, 0, bound,
                      std::move(source), std::move(reason)});
  }
  void between(std::string quantity, std::string unit, double measured, double low, double high,
               std::string source, std::string reason) {
    claims.push_back({std::move(quantity), std::move(unit), measured, Claim::Assessed::between, low, high,
                      std::move(source), std::move(reason)});
  }
};

/// A part of a set: runs that add claims. `claims`: their number, for the parts of a set that takes
/// so long that its parts are tests of their own.
struct Part {
  Part(void (*add)(Findings&), std::size_t claims = 0) : add(add), claims(claims) {}
  void (*add)(Findings&);
  std::size_t claims;
};
using Parts = std::vector<Part>;

/// A set of claims, the argument of `freeplay verify`.
struct ClaimSet {
  const char* name;
  const char* title;
  Parts (*parts)();
};
std::span<const ClaimSet> claim_sets();

/// The claims of one set after its runs. `failure`: message of the exception that ended them, else
/// empty.
struct Verdict {
  const ClaimSet* set = nullptr;
  Findings findings;
  std::string failure;
  double seconds = 0;
  bool holds() const;
};
Verdict assess(const ClaimSet& set, const Parts& parts);
inline Verdict assess(const ClaimSet& set) { return assess(set, set.parts()); }

std::string table(const Verdict& verdict);  ///< for a terminal of 80 columns
/// verification.json, without provenance
nlohmann::json to_json(const std::vector<Verdict>& verdicts);
/// docs/verification/verification.md
std::string document(const std::vector<Verdict>& verdicts);

/// The rows of docs/verification/verification.csv, columns `asked_columns`: names, expected values
/// and bounds of the claims of a set, without measured values.
std::string requested(const Verdict& verdict);
inline constexpr const char* asked_columns = "set,judged,expected,bound,unit,quantity\n";
/// The whole file.
std::string requested(const std::vector<Verdict>& verdicts);

#define CLAIM_SET(function, name, title) Parts function();
#include "verification/claims/sets.def"
#undef CLAIM_SET

// Parts in files of their own, of the sets "published-cases", "films", "complementarity", "lyapunov"
// and "orbits".
void published_smooth(Findings& f);
void published_impacts(Findings& f);
void published_contacts(Findings& f);
void film_coefficients(Findings& f);
void piles(Findings& f);
void attractor_exponents(Findings& f);
void orbits_of_schemes(Findings& f);
void orbits_of_closed_contacts(Findings& f);

}  // namespace freeplay::verification
