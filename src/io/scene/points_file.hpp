// Reads the points of a curve from CSV text with a header: two of its columns, selected by name, or
// the first two. Empty lines and lines that begin with # are ignored.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace freeplay {

/// Reads the points. `columns`: two names, or empty for the first two columns. `fail` throws an
/// error with the given message, which includes the line.
std::vector<std::pair<double, double>> read_points(const std::string& text,
                                                   const std::vector<std::string>& columns,
                                                   const std::function<void(const std::string&)>& fail);

}  // namespace freeplay
