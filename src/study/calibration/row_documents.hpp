// Results of fits to measured rows (study/calibration/row_fit.hpp) as tables, documents and words. Constants
// and residuals of fitted rows, and residuals of predicted rows, are in separate tables.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

#include "study/calibration/row_fit.hpp"
#include "values/table.hpp"

namespace freeplay {

/// The fitted constants, for the terminal.
std::string constants_text(const std::vector<RowPrediction>& predictions);
/// The residuals of fitted rows, for the terminal.
std::string fitted_text(const std::vector<RowPrediction>& predictions);
/// The residuals of predicted rows, for the terminal: a block for all rows and for each class.
std::string predicted_text(const std::vector<RowPrediction>& predictions,
                           const std::vector<RowSummary>& summaries);

/// The conclusion in one or two sentences.
std::string conclusion(const std::vector<RowPrediction>& predictions,
                       const std::vector<RowSummary>& summaries);

/// rows.json or calibration.json, without provenance; `summaries` is empty for fits to all rows.
nlohmann::json to_json(const Study& study, const RowTable& table,
                       const std::vector<RowPrediction>& predictions,
                       const std::vector<RowSummary>& summaries);
/// rows.csv: each predicted row of each model.
Table predictions_table(const Study& study, const RowTable& table,
                        const std::vector<RowPrediction>& predictions);

}  // namespace freeplay
