// A scene against a user's measured acceleration: both formulations through the scene's accelerometer, at the
// file's sampling, compared as peaks, mean turns and spectra, with a verdict.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "measure/measurement.hpp"
#include "study/runs/case_run.hpp"
#include "study/sweep/intervals.hpp"

namespace freeplay {

/// Where a mean turn is quiet: its longest stretch with |a| at most 5 % of the ideal greatest. A slider
/// without contact and without friction shows it, in a measurement as in a run. Degrees; NaN when there is
/// none.
struct Quiet {
  double from = 0, to = 0;
};
Quiet quiet_stretch(const std::vector<double>& mean_turn, double ideal_maximum);

/// One model against the measurement. What is beyond doubt is said, and not taken out: a reversed curve stays reversed,
/// and one that is too large stays so. Only where the file gives times, and so no datum of the crank's angle, is the
/// model moved by the phase that fits best; the file's angles are taken as they are.
struct Agreement {
  std::string formulation;
  int sign = 1;               ///< −1: the measured curve is the model's reversed
  bool sign_decided = false;  ///< beyond doubt (alignment.hpp)
  Interval
      gain;  ///< measured over model, of the mean turns; 95 % where turns scatter or the file has an uncertainty
  Interval phase;    ///< degrees that the model's crank angle is behind the measurement's, in [−180, 180)
  double moved = 0;  ///< degrees that the model was moved by: the phase without a datum, else 0
  double peak_ratio = 0;      ///< model's median peak of a turn over the measured
  double greatest_ratio = 0;  ///< the same of the greatest
  double rms_difference = 0;  ///< m/s², of the mean turns
  /// m/s², standard: what the file's uncertainty and the scatter of both's turns make of that difference; NaN with a
  /// single turn and no uncertainty
  double rms_expected = NAN;
  double spectral_distance = 0;  ///< ‖A − B‖/‖B‖ over harmonics of the crank below 0.4 of the file's sampling
  double loss_angle = 0, return_angle = 0;  ///< degrees, the model's contact, in the measurement's datum
  Quiet quiet;                              ///< of the model, in the measurement's datum
  std::vector<double> mean_turn;            ///< in the measurement's datum
  std::vector<std::string> findings;        ///< what differs beyond doubt, in words
  TurnMetrics metrics;
  Ending ending;
  /// Nothing differs beyond doubt; undecided where nothing says how much doubt there is.
  enum class Verdict { agrees, differs, undecided } verdict = Verdict::undecided;
};
/// What a finding must reach to be told, beyond its interval: of a gain 2 %, of a phase 1°; of a difference of mean
/// turns, twice its standard error.
inline constexpr double told_gain = 0.02, told_phase = 1, told_difference = 2;

/// Judges a model's turns against a measurement's; sets all of `a` that comes from the signals. `datum`: the file
/// gives angles; `uncertainty`: m/s², standard, not taken to average out.
void judge(const TurnMetrics& measured, double uncertainty, bool datum, Agreement& a);
const char* text_of(Agreement::Verdict verdict);

struct Validation {
  double ideal_maximum = 0;
  double sampling = 0, uncertainty = 0;  ///< of the file
  TurnMetrics measured;
  Quiet quiet;  ///< of the measurement
  std::vector<Agreement> models;
  std::string question;  ///< about the file's units; empty: none
};

/// Throws SceneError for a scene without accelerometer, drive or clearance, and for a bad file.
Validation validate(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                    const std::filesystem::path& data, const Conduct& conduct);

nlohmann::json to_json(const Validation& v);

}  // namespace freeplay
