// What a sweep found: as tables for a terminal of 80 columns, and as one CSV file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/store/results.hpp"

namespace freeplay {

/// Each variant and cell on a line, means over starts. Of a study with an accelerometer the accelerations; of its measures and
/// what it derives, or else of the contacts, as many tables as their columns need.
std::string sweep_table(const Study& study, const std::vector<RunRow>& runs);

/// The view `named`, a run on a line, by name: absent is empty. `file` lies in the study's result folder.
void write_export(const Study& study, const Results& results, const std::filesystem::path& file);

/// Spectra, a harmonic on a line, and traces, a sample on a line, of the runs that the study names.
void write_spectra(const Results& results, const std::filesystem::path& file);
void write_traces(const Results& results, const std::filesystem::path& file);

}  // namespace freeplay
