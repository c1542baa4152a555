// What Flores, Koshy, Lankarani, Ambrósio and Claro (Nonlinear Dynamics 65 (2011) 383–398) measured, as their
// text states it (X1 to X13, docs/experiment.md), judged on the runs of a study whose axes are clearance (m)
// and speed (rpm). Bounds were fixed before the matrix was run.
#pragma once

#include "study/calibrate.hpp"
#include "study/intervals.hpp"

namespace freeplay::verification {

struct Finding {
  std::string id, claim;        ///< X6, what must hold
  std::string measured, bound;  ///< what the model gives, what would hold
  bool holds = false;
  bool judged = true;  ///< false: the runs cannot say
};

/// The verdicts on one variant in one formulation. `statistic` is what "maximum" is taken to mean.
std::vector<Finding> flores2011(const Study& study, const Results& results, const std::vector<RunRow>& runs,
                                const std::string& variant, const std::string& formulation,
                                TurnMetrics::Name statistic);

/// In which of the matrix's cells the formulations' median peaks lie within each other's intervals.
struct Cells {
  int agreeing = 0, all = 0;
  std::vector<std::string> apart;  ///< "0.1 mm, 150 rpm: 1.73 (1.65..1.80) against 1.62 (1.57..1.68)"
};
Cells formulations_agree(const Study& study, const std::vector<RunRow>& runs, const std::string& variant);

/// docs/experiment.md. `calibration` may be null.
std::string experiment_document(const Study& study, const Results& results, const Study* calibration_study,
                                const CalibrationResult* calibration);

}  // namespace freeplay::verification
