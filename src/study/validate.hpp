// A scene against a user's measured acceleration: both formulations through the scene's accelerometer,
// aligned in phase, compared as peaks, mean turns and spectra.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "measure/measurement.hpp"
#include "study/case_run.hpp"

namespace freeplay {

/// Where a mean turn is quiet: its longest stretch with |a| at most 5 % of the ideal greatest. A slider
/// without contact and without friction shows it, in a measurement as in a run. Degrees; NaN when there is
/// none.
struct Quiet {
  double from = 0, to = 0;
};
Quiet quiet_stretch(const std::vector<double>& mean_turn, double ideal_maximum);

struct Agreement {
  std::string formulation;
  double phase = 0;           ///< degrees that the model's crank angle is behind the measurement's
  double peak_ratio = 0;      ///< model's median peak of a turn over the measured
  double greatest_ratio = 0;  ///< the same of the greatest
  double rms_difference = 0;  ///< m/s², of the mean turns after alignment
  double spectral_distance = 0;  ///< ‖A − B‖/‖B‖ over harmonics of the crank below 0.4 of the lower sampling
  double loss_angle = 0, return_angle = 0;  ///< degrees, the model's contact, in the measurement's datum
  Quiet quiet;                              ///< of the model, in the measurement's datum
  std::vector<double> mean_turn;            ///< aligned
  TurnMetrics metrics;
  Ending ending;
};

struct Validation {
  double ideal_maximum = 0;
  double sampling = 0, uncertainty = 0;  ///< of the file
  TurnMetrics measured;
  Quiet quiet;  ///< of the measurement
  std::vector<Agreement> models;
  std::string question;  ///< about the file's units; empty: none
};

/// Throws SceneError for a scene without accelerometer, drive or clearance, and for a bad file.
Validation validate(const std::filesystem::path& scene, const std::vector<std::string>& overrides,
                    const std::filesystem::path& data, const Conduct& conduct);

nlohmann::json to_json(const Validation& v);

}  // namespace freeplay
