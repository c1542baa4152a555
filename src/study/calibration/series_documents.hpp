// Contents of the result files of calibrations to series, and their conclusion in words. Documents are
// without their provenance.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "values/table.hpp"

namespace freeplay {

struct SeriesFit;
struct Study;

/// The conclusion in one or two sentences.
std::string conclusion(const Study& study, const SeriesFit& fit);
/// calibration.json.
nlohmann::json to_json(const Study& study, const SeriesFit& fit);
/// series.csv: measured value and model at each sample of each target in each formulation; `use` is fitted
/// or predicted.
Table series_table(const Study& study, const SeriesFit& fit);

}  // namespace freeplay
