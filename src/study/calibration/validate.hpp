// Validation: comparison of a scene with a measured acceleration. Both formulations are evaluated
// through the scene's accelerometer at the sampling rate of the file, and compared in peaks, mean
// turns and spectra. The result is a verdict for each formulation. A turn is one revolution of the
// crank.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "measure/measurement.hpp"
#include "study/runs/case_run.hpp"
#include "study/sweep/intervals.hpp"
#include "study/verdicts/verdicts.hpp"

namespace freeplay {

/// Quiet interval of a mean turn: the longest interval with |a| at most 5 % of the greatest ideal
/// acceleration. A slider without contact and friction produces it, in measurements and in runs.
/// Degrees; NaN if there is none.
struct Quiet {
  double from = 0, to = 0;
};
/// The quiet interval of a mean turn, given in equal parts from crank angle 0.
Quiet quiet_stretch(const std::vector<double>& mean_turn, double ideal_maximum);

/// Comparison of one formulation with the measurement. Differences that are beyond doubt are
/// reported, not corrected: a reversed or scaled curve is not changed. Only if the file gives
/// times, and thus no datum of the crank angle, is the computed curve shifted by the best-fitting
/// phase. Angles of a file are used unchanged.
struct Agreement {
  std::string formulation;
  int sign = 1;               ///< −1: the measured curve is reversed relative to the computed one
  bool sign_decided = false;  ///< beyond doubt (measure/alignment.hpp)
  /// Measured over computed mean turn; 95 % if turns scatter or the file has an uncertainty.
  Interval gain;
  /// Degrees of the computed crank angle behind the measured one, in [−180, 180).
  Interval phase;
  double moved = 0;           ///< degrees, applied shift: the phase without a datum, else 0
  double peak_ratio = 0;      ///< median peak of a turn, computed over measured
  double peak_error = 0;      ///< standard error of peak_ratio, from the scatter of the peaks
  double greatest_ratio = 0;  ///< greatest peak, computed over measured
  double rms_difference = 0;  ///< m/s², of the difference of the mean turns
  /// m/s², standard deviation of that difference expected from the file's uncertainty and the
  /// scatter of the turns; NaN with a single turn and no uncertainty.
  double rms_expected = NAN;
  double rms_measured = 0;  ///< m/s², of the measured mean turn
  /// ‖A − B‖/‖B‖ over harmonics of the crank below 0.4 of the file's sampling rate.
  double spectral_distance = 0;
  /// Degrees, of the computed contact, in the measurement's datum.
  double loss_angle = 0, return_angle = 0;
  Quiet quiet;                        ///< of the computed curve, in the measurement's datum
  std::vector<double> mean_turn;      ///< computed, in the measurement's datum
  std::vector<std::string> findings;  ///< differences beyond doubt, as text
  TurnMetrics metrics;
  Ending ending;
  /// `agrees`: no difference of the mean turns beyond doubt. `undecided`: the uncertainty is unknown,
  /// or twice its value exceeds the measured signal, so that zero would agree too.
  enum class Verdict { agrees, differs, undecided } verdict = Verdict::undecided;
};
/// Least size of a reported difference, in addition to its interval: gain 2 %, phase 1°, and for
/// mean turns twice the standard error.
inline constexpr double told_gain = 0.02, told_phase = 1, told_difference = agreement_factor;

/// Compares the turns of a run with those of a measurement; sets the members of `a` that depend on
/// the signals. `datum`: the file gives angles. `uncertainty`: m/s², standard deviation, assumed
/// not to average out.
void assess(const TurnMetrics& measured, double uncertainty, bool datum, Agreement& a);
/// Name of a verdict: "agrees", "differs" or "undecided".
const char* text_of(Agreement::Verdict verdict);

/// Outcome of a comparison for the verdict in words.
SignalAgreement::Outcome outcome_of(Agreement::Verdict verdict);

/// Result of a validation.
struct Validation {
  double ideal_maximum = 0;
  double sampling = 0, uncertainty = 0;  ///< of the file
  TurnMetrics measured;
  Quiet quiet;  ///< of the measurement
  std::vector<Agreement> models;
  std::string plausibility;  ///< about the units of the file; empty: none
  std::string conclusion;    ///< in one or two sentences
};

/// Validates a scene. Throws SceneError for a scene without accelerometer, drive or clearance, and
/// for an invalid file.
Validation validate(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                    const std::filesystem::path& data, const Conduct& conduct);

/// The result as JSON, without provenance.
nlohmann::json to_json(const Validation& v);

}  // namespace freeplay
