// `freeplay calibrate` and `freeplay validate` of a study with measured rows, [rows]
// (study/calibration/row_fit.hpp).
#pragma once

#include "cli/cluster/shards.hpp"
#include "cli/validate.hpp"
#include "study/settings/study.hpp"

namespace freeplay::cli {

/// Fits the unknowns to all rows; returns the exit status: 1 if a fit is not at a minimum.
int calibrate_rows(const StudyRequest& request, const Study& study);
/// Fits them without each part of the rows, and predicts this part; exit status as above.
int validate_rows(const ValidateRequest& request, const Study& study);

}  // namespace freeplay::cli
