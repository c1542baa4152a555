// Contents of the result files of calibrations, and their conclusions in words. Documents are without
// their provenance.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "values/table.hpp"

namespace freeplay {

struct CalibrationResult;
struct QuantityFit;
struct Study;

/// The conclusion in one or two sentences.
std::string conclusion(const Study& study, const CalibrationResult& result);
std::string conclusion(const Study& study, const QuantityFit& fit);

/// calibration.json.
nlohmann::json to_json(const Study& study, const CalibrationResult& result);
nlohmann::json to_json(const Study& study, const QuantityFit& fit);

/// calibration.csv: outcomes of all points over each unknown, and the 95 % range of each measured
/// value.
Table outcomes_table(const Study& study, const CalibrationResult& result);
/// misfit.csv: f − min f for each pair of unknowns, minimised over the others.
Table misfit_table(const Study& study, const CalibrationResult& result);

}  // namespace freeplay
