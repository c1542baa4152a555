// Reader of a measured acceleration in a CSV file with a header: one column `t` (s) or
// `crank_angle` (degrees, continuous or wrapped at 360), one column `acceleration` (m/s²), and
// optionally `uncertainty` (m/s²). Or in the long format of signals.csv: `channel`, `t` (s), `value`
// (m/s²), optionally `crank_angle` (rad) and `uncertainty`; the samples of one channel are read.
// A name may be followed by its unit in brackets, as in "t (s)" or "time [s]".
//
// The samples are kept as measured, without interpolation. The crank angle is that of the scene in
// either order of the lines: where it runs against the crank's speed, the last line is the
// earliest. Times that are uniform to the number of digits in the file are made exactly uniform.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freeplay {

/// A measurement in the order of time.
struct Measurement {
  double sampling = 0;  ///< Hz, mean rate
  bool datum = false;   ///< whether the file has angles
  /// degrees of the crank at the first sample; 0 if the file has times only
  double start_angle = 0;
  std::vector<double> time;          ///< s, from the first sample on
  std::vector<double> acceleration;  ///< m/s²
  double uncertainty = 0;            ///< m/s², root mean square; 0 if not given
};

/// Reads a measurement. `channel`: the one to read from a file in the long format, by the name of
/// the scene's accelerometer. `speed` is the crank's, as in the scene (rad/s). `ideal_maximum` (m/s²),
/// the greatest acceleration of the ideal mechanism, serves to detect wrong units. Throws
/// SceneError with FILE:LINE for missing columns, bad numbers, wrong order, gaps, less than one
/// turn, or implausible units.
Measurement read_measurement(const std::filesystem::path& file, double speed, double ideal_maximum,
                             const std::string& channel = "accelerometer");

}  // namespace freeplay
