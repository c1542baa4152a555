// A measured acceleration as a user brings it: a CSV file with a header, one column `t` (s) or `crank_angle`
// (degrees, running on or wrapping at 360), one `acceleration` (m/s²), perhaps one `uncertainty` (m/s²).
//
// Samples stay what they are: nothing is interpolated. A crank angle is the scene's, whichever way the lines go: where
// it runs against the crank's speed, the last line is the earliest. Times that are even to the digits that the file
// gives are taken to be even.
#pragma once

#include <filesystem>
#include <vector>

namespace freeplay {

struct Measurement {
  double sampling = 0;       ///< Hz, mean
  bool datum = false;        ///< the file gives angles
  double start_angle = 0;    ///< degrees of the crank at the first sample; 0 when only times are given
  std::vector<double> time;  ///< s, from the first sample
  std::vector<double> acceleration;  ///< m/s²
  double uncertainty = 0;            ///< m/s², root mean square; 0 when not given
};

/// `speed`: rad/s of the crank, as in the scene. `ideal_maximum` (m/s²) guards against wrong units. Throws
/// SceneError FILE:LINE for what is no such file: columns, numbers, order, gaps, less than a turn, units.
Measurement read_measurement(const std::filesystem::path& file, double speed, double ideal_maximum);

}  // namespace freeplay
