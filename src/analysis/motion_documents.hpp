// Contents of the result files about periodic motions, their branches, Lyapunov exponents and
// derivatives, for the program and for Python. A number that does not exist is NaN, null in a file.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "values/branch.hpp"
#include "values/lyapunov.hpp"
#include "values/sensitivity.hpp"
#include "values/table.hpp"

namespace freeplay {

struct OrbitRequest;
struct Scene;

// Documents are without their provenance.

/// orbit.json.
nlohmann::json to_json(const Scene& scene, const OrbitRequest& request, const Orbit& orbit);

/// lyapunov.json.
nlohmann::json to_json(const Lyapunov& found, const std::string& formulation);
/// lyapunov.csv: the means from the end of the transient to each time; empty fields where they are −∞ or
/// unknown.
Table course_table(const Lyapunov& found);

/// (p/Q) dQ/dp, the relative change of the quantity per relative change of the key. NaN without a
/// derivative or if the value is zero.
double influence(const Sensitivities& all, const Sensitivity& quantity, std::size_t key);
/// sensitivity.json. `deviations`: standard deviations of the keys (SI); empty: none were given.
nlohmann::json to_json(const Sensitivities& all, const std::vector<double>& deviations,
                       const std::string& formulation);

/// The tables of a continuation: branch.csv, branch_impacts.csv, bifurcations.csv and curves.csv.
struct BranchTables {
  explicit BranchTables(const Scene& scene);
  /// Adds what they do not have yet.
  void add(const Branches& found);
  /// The values of the columns of `branch`.
  static std::vector<double> values(const BranchPoint& point);
  Table branch, impacts, bifurcations, curves;
};
const char* name_of(BifurcationKind kind);
/// Lists of continue.json.
nlohmann::json to_json(const std::vector<BranchEnd>& ends);
nlohmann::json to_json(const std::vector<Bifurcation>& bifurcations);
nlohmann::json to_json(const std::vector<CurveEnds>& curves);

}  // namespace freeplay
