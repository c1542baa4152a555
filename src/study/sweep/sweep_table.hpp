// Results of a sweep as tables for a terminal of 80 columns, and as CSV files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/store/results.hpp"
#include "study/verdicts/verdicts.hpp"

namespace freeplay {

/// Tables with one line for each variant and cell, and means over starts. With an accelerometer:
/// the accelerations. Otherwise the measures and derived columns, or, without these, the contact
/// metrics, in as many tables as their columns need.
std::string sweep_table(const Study& study, const std::vector<RunRow>& runs);

/// The values of the verdict: the first measure or derived column, else the median peak or the
/// first contact metric, of each cell. `failed`: number of failed runs of the study.
SweepValues sweep_values(const Study& study, const std::vector<RunRow>& runs, std::size_t failed);

/// The view `named` as CSV, one run a line with named columns; absent values are empty. `file` is
/// in the study's result folder.
void write_export(const Study& study, const Results& results, const std::filesystem::path& file);

/// Spectra with one harmonic a line, and traces with one sample a line, of the runs that the study
/// names.
void write_spectra(const Results& results, const std::filesystem::path& file);
void write_traces(const Results& results, const std::filesystem::path& file);

}  // namespace freeplay
