// Figures 5 to 13 of Flores, Koshy, Lankarani, Ambrósio and Claro, Nonlinear Dynamics 65 (2011)
// 383-398, by their numbers: figures/figure_05 to figure_13, as computed in both formulations. The
// measured curves of the paper are images without public data and are not drawn; figures 10 and 12
// show the three measured values that the paper's text states. Figure 13 is a map, not a surface.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freeplay::plots {

/// All figures 5 to 13, in order. Throws SceneError for invalid tables, or if they have no rows.
std::vector<std::filesystem::path> draw_flores2011(const std::filesystem::path& folder,
                                                   const std::string& source);

}  // namespace freeplay::plots
