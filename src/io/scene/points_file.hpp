// Points of a curve from a table of comma separated values with a header: two of its columns, by their names or the
// first two. Lines that are empty or begin with # are passed over.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace freeplay {

/// `columns`: two names, or none; `fail`: throws what is wrong, with its line.
std::vector<std::pair<double, double>> read_points(const std::string& text,
                                                   const std::vector<std::string>& columns,
                                                   const std::function<void(const std::string&)>& fail);

}  // namespace freeplay
