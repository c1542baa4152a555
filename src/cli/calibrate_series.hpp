// freeplay calibrate of a study whose targets are measured time series.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "values/stop.hpp"

namespace freeplay {
struct Study;
}

namespace freeplay::cli {

/// Fits, writes calibration.json and series.csv into the folder, draws figures, and prints a summary.
/// `origin`: provenance of the study. Returns the exit status: 1 if the fit does not hold.
int calibrate_series(const Study& study, const std::filesystem::path& folder, const nlohmann::json& origin,
                     int threads, const StopToken& stop);

}  // namespace freeplay::cli
