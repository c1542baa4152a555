// The tables of docs/verification/experiment.md.
#pragma once

#include <string>

#include "values/table.hpp"
#include "verification/experiment/flores2011.hpp"

namespace freeplay::verification {

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
