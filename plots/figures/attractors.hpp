// Bifurcation diagrams, as part of a figure.
#pragma once

#include <filesystem>
#include <string>

namespace freeplay::plots {

struct Figure;

/// Adds the diagram of one column of bifurcation.csv over the parameter, and with `with_exponents` the
/// Lyapunov exponents of the attractors beneath, if they were computed. Returns false if there is no run.
/// Throws SceneError.
bool add_bifurcation(Figure& f, const std::filesystem::path& folder, const std::string& column,
                     const std::string& unit, bool with_exponents = false);

}  // namespace freeplay::plots
