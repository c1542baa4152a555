// Forces of one run for figures: the means of its forces.csv, cut to the last turn and thinned. All
// are means over time intervals and include impulses: this is the only measure of force that impact
// laws and contact forces share.
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

/// Means of one run (N; moments and torques: N m), each over the time since the previous row. An
/// empty field is NaN.
struct ForceRun {
  const char* title;
  int style;  ///< 1 penalty, 2 nonsmooth, 3 ideal, as plots::style()
  Values t;   ///< s, of the rows: one value more than the means have
  /// of the means, without the suffix _mean, in the order of the file
  std::vector<std::string> names;
  std::map<std::string, Values> mean;
  Values x;                        ///< middle of each interval: s, or degrees of the crank
  double interval = 0;             ///< s, length of the interval of a mean
  const char* part = "whole run";  ///< part of the run that is kept

  /// Null if the run has no column of that name.
  const Values* find(const std::string& name) const {
    const auto it = mean.find(name);
    return it == mean.end() ? nullptr : &it->second;
  }
};

/// Reads only t and the columns of means; a file has several more columns per joint. Throws
/// SceneError if the file cannot be read or a field is not a number.
ForceRun read_force_run(const std::filesystem::path& file, const char* title, int style);

/// Assigns each mean to the middle of its interval, in degrees of the drive's angle, or in seconds
/// without a drive. With a drive, whose speed must not be 0, only the last whole turn is kept. A
/// turn begins at a multiple of 360°. If the run has no such turn, its last 360° are kept, wrapped
/// to one turn.
void keep_last_turn(ForceRun& run, const SpeedDrive* drive);

/// Merges each `count` consecutive intervals into one.
void merge(ForceRun& run, std::size_t count);

}  // namespace freeplay::plots
