// What a bifurcation or a basin amounts to: tables for people and for figures.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "study/attractors/attractor_runs.hpp"

namespace freeplay {

/// Chains of [bifurcation]: up, down, and each drawn start of each value by itself.
std::vector<Chain> bifurcation_chains(const Study& study);
/// Of [basin]: each cell by itself, x in the inner loop.
std::vector<Chain> basin_chains(const Study& study);

/// The attractors of all runs, each once, in the order in which they are met first; and which one each run is on, −1 for a run
/// that gave up. Of a bifurcation runs are compared at one value alone, and numbers count anew at each.
struct Told {
  std::vector<Attractor> list;
  std::vector<std::vector<int>> of;  ///< as SettledRuns::chains
};
Told told_at_each_value(const SettledRuns& runs);
Told told_at_all(const SettledRuns& runs);

/// bifurcation.csv, basin.csv, and what of the results stands in bifurcation.json and basin.json beside the provenance.
std::string bifurcation_csv(const Study& study, const SettledRuns& runs, const Told& told);
nlohmann::json bifurcation_json(const Study& study, const SettledRuns& runs, const Told& told);
std::string basin_csv(const Study& study, const SettledRuns& runs, const Told& told);
nlohmann::json basin_json(const Study& study, const SettledRuns& runs, const Told& told);

/// For a terminal of 80 columns: stretches of the axis on which a branch is of one kind; attractors with their share.
std::string bifurcation_text(const Study& study, const SettledRuns& runs, const Told& told);
std::string basin_text(const Study& study, const SettledRuns& runs, const Told& told);

}  // namespace freeplay
