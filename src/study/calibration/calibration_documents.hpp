// Contents of the result files of calibrations, and their conclusions in words. Documents are without
// their provenance.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "values/table.hpp"

namespace freeplay {

struct CalibrationResult;
struct Estimate;
struct QuantityFit;
struct Study;
struct Unknown;

// Parts that all kinds of fits share.

/// A list for each row of a matrix.
nlohmann::json rows_of(const Eigen::MatrixXd& m);
/// Keys, ranges and estimates of the unknowns, by name.
nlohmann::json json_of(const std::vector<Unknown>& unknowns, const std::vector<Estimate>& estimates);
/// The value of an unknown with its interval and unit, to a number of digits.
std::string value_text(const Unknown& unknown, const Estimate& estimate, int digits);

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
