// Results of a sweep as tables for a terminal of 80 columns, and as CSV files.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "measure/turns.hpp"
#include "study/store/results.hpp"
#include "study/verdicts/verdicts.hpp"

namespace freeplay {

// sweep.json: what the database of a sweep does not state, for figures and reports: the provenance
// of the study, names, units and scales of its axes, measures and derived quantities, its variants,
// units of the statistics, and the verdict.

/// Unit of a statistic of turns (docs/reference/study.md); "" if it has none.
std::string_view unit_of(TurnMetrics::Name name);

/// Writes sweep.json beside sweep.db. The write lock of the database keeps processes that share the
/// folder apart. Throws SceneError if the study's scene cannot be read, and OutputError.
void write_sweep_document(const Study& study, const Results& results, const std::filesystem::path& folder,
                          const std::string& verdict = "");

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

// Results of a study as CSV files, for figures and other programs.

/// Writes cells.csv (each metric of each cell: mean, 95 % confidence interval, range over starts),
/// traces.csv (the last turn of start 0, and that of the ideal mechanism) and spectra.csv (means
/// over starts).
void write_tables(const Study& study, const Results& results, const Conduct& conduct,
                  const std::filesystem::path& folder);

}  // namespace freeplay
