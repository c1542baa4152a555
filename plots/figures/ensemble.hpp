// Bands of an ensemble over time, as part of a figure.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freeplay::plots {

struct Figure;

inline constexpr std::size_t most_bands = 4;  ///< panels of one figure

/// Adds a panel for each of the chosen columns of bands.csv, in the order of the file; for none
/// chosen, for the first columns. Returns false if there is none. Throws SceneError.
bool add_bands(Figure& f, const std::filesystem::path& folder, const std::vector<std::string>& chosen);

}  // namespace freeplay::plots
