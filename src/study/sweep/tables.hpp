// A study's results as CSV files, for figures and other programs.
#pragma once

#include "study/store/results.hpp"

namespace freeplay {

/// Writes cells.csv (every statistic of every cell: mean, 95 % interval, range over starts), traces.csv (the
/// last turn of start 0, and the ideal mechanism's) and spectra.csv (means over starts).
void write_tables(const Study& study, const Results& results, const Conduct& conduct,
                  const std::filesystem::path& folder);

}  // namespace freeplay
