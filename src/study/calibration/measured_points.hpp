// Measured values at single points of a study's axes, and how far the runs of each variant agree
// with them. The values are in a CSV file with a line for each value: the columns `quantity` (a
// measure or derived column of the study), `value`, `uncertainty` (standard, optional), and a
// column for each axis by its name, in the displayed unit.
#pragma once

#include <string>
#include <vector>

#include "study/calibration/validate.hpp"
#include "study/store/results.hpp"

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

/// Values of a study's measures and derived columns, by name.
class QuantityReader {
 public:
  explicit QuantityReader(const Study& study);
  /// The value in one run; NaN: absent.
  double operator()(const std::string& name, const RunRow& run) const;

 private:
  std::vector<std::string> names_;
  Deriver derive_;
};

/// Agreement of one variant in one formulation with one quantity.
struct PointAgreement {
  std::string variant, formulation, quantity;
  std::vector<double> model = {};  ///< at each measured point, mean over starts; NaN: no run finished
  double rms = 0;                  ///< root mean square of model less measured
  double greatest = 0;             ///< the greatest difference, with its sign
  std::size_t greatest_at = 0;
  int outside = 0;       ///< points that differ by more than two standard uncertainties
  bool decided = false;  ///< whether every point has an uncertainty and a model value
  Agreement::Verdict verdict() const {
    using enum Agreement::Verdict;
    return !decided ? undecided : outside == 0 ? agrees : differs;
  }
};

std::vector<PointAgreement> agreement_with(const Study& study, const std::vector<MeasuredQuantity>& measured,
                                           const std::vector<RunRow>& runs);

}  // namespace freeplay
