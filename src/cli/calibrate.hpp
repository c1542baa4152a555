// The result of a calibration as calibration.json.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace freeplay {
struct Study;
struct CalibrationResult;
}  // namespace freeplay

namespace freeplay::cli {

/// `origin`: provenance of the study.
nlohmann::json to_json(const Study& study, const CalibrationResult& result, const nlohmann::json& origin);

}  // namespace freeplay::cli
