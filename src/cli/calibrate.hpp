// Parts of the verb calibrate: its result as calibration.json, and fits to quantities of one run.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "values/stop.hpp"

namespace freeplay {
struct Study;
struct CalibrationResult;
}  // namespace freeplay

namespace freeplay::cli {

/// A list for each row.
nlohmann::json rows_of(const Eigen::MatrixXd& matrix);

/// `origin`: provenance of the study.
nlohmann::json to_json(const Study& study, const CalibrationResult& result, const nlohmann::json& origin);

/// Calibrates a study whose targets are quantities of one run; writes calibration.json into the folder
/// and prints a summary. Returns the exit status: 1 if the fit is rejected.
int calibrate_quantities(const Study& study, const std::filesystem::path& folder,
                         const nlohmann::json& origin, const StopToken& stop);

}  // namespace freeplay::cli
