// Validation: comparison of a scene with a measured acceleration. Both formulations are evaluated
// through the scene's accelerometer at the sampling rate of the file, and compared by assess()
// (agreement.hpp). The result is a verdict for each formulation. Where a model agrees, the same test is
// repeated with other clearances, to state which wrong clearance it would have found.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "measure/measurement.hpp"
#include "study/calibration/agreement.hpp"
#include "study/runs/case_run.hpp"
#include "values/table.hpp"

namespace freeplay {

/// The same test with another clearance, for a model that agrees.
struct ClearanceTrial {
  std::string key;       ///< of the clearance in the scene
  double clearance = 0;  ///< m, of the scene
  double factor = 1;     ///< of the clearance in the trial
  std::string formulation;
  bool finished = false;  ///< whether the run ended
  bool found = false;     ///< whether the test finds that this model differs
};
/// Perturbed starts from which a model is run until one agrees: its motions may settle on different
/// attractors, of which the measurement shows one.
inline constexpr int model_starts = 4;
/// Factors of the clearances in the trials.
inline constexpr std::array<double, 7> trial_factors{0.5, 0.8, 0.9, 1.1, 1.2, 1.5, 2};

/// Sets `power` of an agreeing model from its trials. A model passes only if the test finds half and
/// twice the clearance of a joint; otherwise it is undecided. Without trials (a scene without clearance
/// keys, or all runs stopped) it is undecided, too.
void assess_power(const std::vector<ClearanceTrial>& trials, Agreement& a);

/// Result of a validation.
struct Validation {
  double ideal_maximum = 0;
  double sampling = 0, uncertainty = 0;  ///< of the file
  TurnMetrics measured;                  ///< without the removed offset and outlying revolutions at the start
  std::size_t left_out = 0;              ///< number of these revolutions
  /// Offset of the measured signal from the mean of the ideal mechanism's: a mean acceleration does not
  /// depend on clearance if the velocity repeats with each revolution.
  SignalOffset offset;
  bool offset_removed = false;
  Quiet quiet;  ///< of the measurement
  /// Revolutions of the models: compared, discarded before, and of the scene's own run.
  double revolutions = 0, discarded = 0, stated = 0;
  std::vector<Agreement> models;
  std::vector<ClearanceTrial> trials;
  std::vector<std::string> remarks;  ///< on the measurement
  std::string plausibility;          ///< about the units of the file; empty: none
  std::string conclusion;            ///< in one or two sentences
};

/// Options of validate().
struct ValidateSetup {
  /// Compared revolutions of the models; 0: as many as the file has, from 20 to 200, and at least those
  /// of the scene, so that the scatter of the models does not limit the comparison.
  double revolutions = 0;
  /// Subtract the offset from the measured signal, in place of judging it.
  bool remove_offset = false;
  std::function<void(const std::string&, double)> on_progress = {};  ///< what is run, completed fraction
};

/// Validates a scene. If it discards no time, two revolutions are discarded. Throws SceneError for a
/// scene without accelerometer, drive or clearance, and for an invalid file.
Validation validate(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                    const std::filesystem::path& data, const ValidateSetup& setup, const Conduct& conduct);

/// validation.json, without provenance. `matched`: the nonsmooth model had the delivered restitution.
nlohmann::json to_json(const Validation& v, const std::string& data, bool matched);
/// overlay.csv: the mean revolutions; empty unless both models finished.
Table overlay_table(const Validation& v);

}  // namespace freeplay
