// Forces of one run as figures need them: the means of its forces.csv, cut to the last turn and thinned out.
// All are means over intervals of time, impulses included, the one measure of force that an impact law and a
// contact force share.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace freeplay {
struct SpeedDrive;
}

namespace freeplay::plots {

using Values = std::vector<double>;

/// Means of one run (N; N m of moments and torques), each over the time since the row before. An empty field
/// is NaN.
struct ForceRun {
  const char* title;
  int style;                       ///< 1 penalty, 2 nonsmooth, 3 ideal, as plots::style()
  Values t;                        ///< s, of the rows: one more than there are means
  std::vector<std::string> names;  ///< of the means without their suffix _mean, in the order of the file
  std::map<std::string, Values> mean;
  Values x;                        ///< s, or degrees of the crank: the middle of each interval
  double interval = 0;             ///< s, that a mean is over
  const char* part = "whole run";  ///< which is kept

  /// Null where the run has none of that name.
  const Values* find(const std::string& name) const {
    const auto it = mean.find(name);
    return it == mean.end() ? nullptr : &it->second;
  }
};

/// Reads t and the columns of means alone: a file has several others per joint. Throws SceneError when it
/// cannot be read or a field is no number.
ForceRun read_force_run(const std::filesystem::path& file, const char* title, int style);

/// Places each mean in the middle of its interval: in degrees of the drive's angle, of which the last whole
/// turn is kept; without a drive in seconds. A turn begins where the angle is a multiple of 360°; when the
/// run holds no such turn, its last 360° are kept, wrapped round. The drive's speed is not 0.
void keep_last_turn(ForceRun& run, const SpeedDrive* drive);

/// Joins `count` intervals at a time into one.
void merge(ForceRun& run, std::size_t count);

}  // namespace freeplay::plots
