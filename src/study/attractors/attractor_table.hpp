// Results of bifurcation diagrams and basins: makes the chains of runs from the study, numbers the
// distinct attractors, and writes tables for users and figures. The functions keep no state.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "study/attractors/attractor_runs.hpp"

namespace freeplay {

/// Chains of [bifurcation]: up, down, and each drawn start of each value by itself.
std::vector<Chain> bifurcation_chains(const Study& study);
/// Chains of [basin]: each cell by itself; x is the inner loop.
std::vector<Chain> basin_chains(const Study& study);

/// Distinct attractors of all runs, numbered in the order of first occurrence, and the number of
/// each run's attractor, −1 for a failed run. In a bifurcation diagram, runs are compared at equal
/// values only, and the numbers restart at each value.
struct Classified {
  std::vector<Attractor> list;
  std::vector<std::vector<int>> of;  ///< in the shape of SettledRuns::chains
  bool at_each_value = false;        ///< whether the numbers restart at each value
};
Classified attractors_at_each_value(const SettledRuns& runs);
Classified attractors_of_all(const SettledRuns& runs);

/// Contents of bifurcation.csv and basin.csv, and of bifurcation.json and basin.json without their
/// provenance.
std::string bifurcation_csv(const Study& study, const SettledRuns& runs, const Classified& classified);
nlohmann::json bifurcation_json(const Study& study, const SettledRuns& runs, const Classified& classified);
std::string basin_csv(const Study& study, const SettledRuns& runs, const Classified& classified);
nlohmann::json basin_json(const Study& study, const SettledRuns& runs, const Classified& classified);

/// Text for a terminal of 80 columns: intervals of the axis with one kind of attractor in a branch;
/// attractors with their shares.
std::string bifurcation_text(const Study& study, const SettledRuns& runs, const Classified& classified);
std::string basin_text(const Study& study, const SettledRuns& runs, const Classified& classified);

}  // namespace freeplay
