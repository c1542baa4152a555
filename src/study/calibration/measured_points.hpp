// Measured values at single points of a study's axes, and how far the runs of each variant agree with
// them. The values are in a CSV file with a line for each value: the columns `quantity` (a measure or
// derived column of the study), `value`, `uncertainty` (standard, optional), and a column for each axis
// by its name, in the displayed unit.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <cmath>
#include <string>
#include <vector>

#include "study/calibration/agreement.hpp"
#include "study/store/results.hpp"
#include "values/table.hpp"

namespace freeplay {

struct MeasuredPoint {
  std::vector<double> at;  ///< values of the axes, in the units of their keys
  double value = 0;
  double uncertainty = 0;  ///< standard; 0: not stated
};

struct MeasuredQuantity {
  std::string name;
  std::vector<MeasuredPoint> points;
};

/// Reads study.points. Throws SceneError for a missing column, a quantity that the study does not
/// compute, a value without a run, or a line that is not numeric.
std::vector<MeasuredQuantity> read_measured_points(const Study& study);

/// Agreement of one variant in one formulation with one quantity.
struct PointAgreement {
  std::string variant, formulation, quantity;
  std::vector<MeasuredPoint> points;
  std::vector<double> model = {};  ///< at each measured point, mean over starts; NaN: no run finished
  double rms = 0;                  ///< root mean square of model less measured
  double greatest = 0;             ///< the greatest difference, with its sign
  std::string greatest_at = {};    ///< its point in words
  int outside = 0;                 ///< points that differ by more than two standard uncertainties
  bool decided = false;            ///< whether every point has an uncertainty and a model value
  Agreement::Verdict verdict() const {
    using enum SignalAgreement::Outcome;
    return !decided ? undecided : outside == 0 ? agrees : differs;
  }
};

std::vector<PointAgreement> agreement_with(const Study& study, const std::vector<MeasuredQuantity>& measured,
                                           const std::vector<RunRow>& runs);

/// The conclusion in one or two sentences.
std::string conclusion(const Study& study, const std::vector<PointAgreement>& all);

/// points.json, without provenance.
nlohmann::json to_json(const Study& study, const std::vector<PointAgreement>& all);
/// points.csv.
Table points_table(const Study& study, const std::vector<PointAgreement>& all);
/// curves.csv: the quantities of every run, for curves through the measured points.
Table curves_table(const Study& study, const std::vector<MeasuredQuantity>& measured,
                   const std::vector<RunRow>& runs);

}  // namespace freeplay
