// Runs gnuplot as a child process.
#pragma once

#include <filesystem>
#include <string>

namespace freeplay::plots {

/// Runs gnuplot on `script`, the name of a file in `folder`, with this folder as working directory.
/// gnuplot reads no start-up file, and its input contains no name of a folder. Returns an empty
/// string on success, otherwise the first line of gnuplot's message. Throws OutputError if gnuplot
/// cannot be started.
std::string run_gnuplot(const std::filesystem::path& folder, const std::string& script);

}  // namespace freeplay::plots
