// Part of the verb calibrate: fits to quantities of one run.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "values/stop.hpp"

namespace freeplay {
struct Study;
}

namespace freeplay::cli {

/// Calibrates a study whose targets are quantities of one run; writes calibration.json into the folder
/// and prints a summary. `origin`: provenance of the study. Returns the exit status: 1 if the fit is
/// rejected.
int calibrate_quantities(const Study& study, const std::filesystem::path& folder,
                         const nlohmann::json& origin, const StopToken& stop);

}  // namespace freeplay::cli
