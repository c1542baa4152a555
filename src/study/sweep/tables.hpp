// Results of a study as CSV files, for figures and other programs.
#pragma once

#include "study/store/results.hpp"

namespace freeplay {

/// Writes cells.csv (each metric of each cell: mean, 95 % confidence interval, range over starts),
/// traces.csv (the last turn of start 0, and that of the ideal mechanism) and spectra.csv (means
/// over starts).
void write_tables(const Study& study, const Results& results, const Conduct& conduct,
                  const std::filesystem::path& folder);

}  // namespace freeplay
