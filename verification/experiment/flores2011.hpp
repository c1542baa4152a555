// The measurements of Flores, Koshy, Lankarani, Ambrósio and Claro (Nonlinear Dynamics 65 (2011)
// 383–398) as their text states them (findings X1 to X13, docs/verification/experiment.md), and
// their verdicts on the runs of a study whose axes are clearance (m) and speed (rpm). The bounds
// were fixed before the matrix was run. The meaning of "maximum", the datum of X3 to X5 and the
// quantities of X5 and X13 were settled after the first runs had been seen.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>

#include "study/calibration/calibrate.hpp"
#include "study/store/results.hpp"
#include "study/verdicts/verdicts.hpp"
#include "values/table.hpp"

namespace freeplay::verification {

struct Finding {
  std::string id, claim;        ///< X6, the expected finding
  std::string measured, bound;  ///< the model's value, the expected range
  bool holds = false;
  bool assessed = true;  ///< false: the runs cannot decide
  bool fitted = false;   ///< the model was fitted to this: no verdict
};

/// The verdicts on one variant in one formulation. `statistic` is the meaning of "maximum";
/// `fitted` names the findings that this variant was fitted to.
std::vector<Finding> flores2011(const Study& study, const Results& results, const std::vector<RunRow>& runs,
                                const std::string& variant, const std::string& formulation,
                                TurnMetrics::Name statistic, const std::set<std::string>& fitted);
/// The targets that a variant was fitted to: those of the calibration, if it is the calibrated one.
std::set<std::string> fitted_findings(const std::string& variant, const Study* calibration);

/// The findings on a variant in one formulation.
struct VariantFindings {
  std::string variant, title, formulation;
  std::vector<Finding> findings;
};
/// Those on all variants, with the 95 % quantile of the peaks as "maximum". `calibration` may be null.
std::vector<VariantFindings> all_findings(const Study& study, const Results& results,
                                          const std::vector<RunRow>& runs, const Study* calibration);
FindingCount count(const std::vector<VariantFindings>& all);
/// experiment.json, without provenance.
nlohmann::json to_json(const std::vector<VariantFindings>& all);

/// The cells of the matrix in which the formulations' median peaks agree.
struct Cells {
  int all = 0, overlapping = 0;    ///< 95 % intervals of the mean over starts
  int within = 0;                  ///< each mean lies inside the other's interval
  std::vector<std::string> apart;  ///< neither does: "0.1 mm, 150 rpm: 1.73 (1.65..1.80), …"
};
Cells formulations_agree(const Study& study, const std::vector<RunRow>& runs, const std::string& variant);

/// docs/verification/experiment.md. `calibration` may be null; `version` is that of the program
/// that made the results.
std::string experiment_document(const Study& study, const Results& results, const Study* calibration_study,
                                const CalibrationResult* calibration, const std::string& version);

// The tables of docs/verification/experiment.md.

/// The sources of the tables.
struct Evidence {
  const Study& study;
  const Results& results;
  const std::vector<RunRow>& runs;
  const Study* calibration;  ///< may be null
};

std::string number(double x);
std::string show(double value, double low, double high);

/// The verdict on each statement of the paper in the variants that ran in full, and their counts.
std::string summary_table(const Evidence& e);
/// Each quantity that fails in the study's first variant, the assumptions that it points to, and
/// its value in the variant that changes the assumption.
std::string failures_table(const Evidence& e);
/// The claims on a variant, a verdict for each formulation; then, without verdicts, the quantities
/// that it was fitted to.
std::string claims_table(const Evidence& e, const Variant& v);
/// X6 to X9 for each meaning of "maximum".
std::string readings_table(const Evidence& e);
/// Change of the claims by every variant, relative to the study's first one, and a sentence for
/// each.
std::string influences_table(const Evidence& e);
std::string matrix_table(const Evidence& e, const Variant& v);
std::string calibration_tables(const Study& study, const CalibrationResult& r);

}  // namespace freeplay::verification
