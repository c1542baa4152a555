// gnuplot as a child of this program.
#pragma once

#include <filesystem>
#include <string>

namespace freeplay::plots {

/// Draws `script`, the name of a file in `folder`, with gnuplot working there: it reads no start-up file, and no name of a
/// folder is part of what it is told. Empty when it went well, else the first line of what gnuplot said. Throws
/// OutputError when it cannot be started.
std::string run_gnuplot(const std::filesystem::path& folder, const std::string& script);

}  // namespace freeplay::plots
