// Figures 5 to 13 of Flores, Koshy, Lankarani, Ambrósio and Claro, Nonlinear Dynamics 65 (2011)
// 383-398, by their numbers: figures/figure_05 to figure_13, as computed in both formulations. The
// measured curves of the paper are images without public data and are not drawn; figures 10 and 12
// show the three measured values that the paper's text states.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freeplay::plots {

/// The variant of the tables that is drawn: "calibrated" if it exists, otherwise the first; "" for
/// tables without rows.
std::string variant_to_draw(const std::filesystem::path& folder);

/// Figures 6 to 10, 12 and 13, from cells.csv, traces.csv and spectra.csv. `source`: JSON file of
/// the folder with the provenance.
std::vector<std::filesystem::path> draw_matrix_of_paper(const std::filesystem::path& folder,
                                                        const std::string& variant,
                                                        const std::string& source);

/// All figures 5 to 13, in order. Throws SceneError for invalid tables, or if they have no rows.
std::vector<std::filesystem::path> draw_flores2011(const std::filesystem::path& folder,
                                                   const std::string& source);

}  // namespace freeplay::plots
