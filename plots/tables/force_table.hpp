// The forces of a result folder: its runs side by side, and the meaning of their columns according
// to the scene, if this program can read it.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mechanism/elements.hpp"

// Forces of one run for figures: the means of its forces.csv, cut to the last turn and thinned. All
// are means over time intervals and include impulses: this is the only measure of force that impact
// laws and contact forces share.

namespace freeplay {
struct Scene;
struct SpeedDrive;
}  // namespace freeplay

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

/// Suffixes of force columns: corners of a guide with clearance, sides of a slot with clearance.
inline constexpr const char* guide_corners[] = {"rear_lower",  "rear_upper", "front_lower",
                                                "front_upper", "right",      "left"};

class ForceTable {
 public:
  /// Reads the runs that have a forces.csv: both formulations and the ideal mechanism of a
  /// comparison, or a single run. Throws SceneError if such a file cannot be read.
  explicit ForceTable(const std::filesystem::path& folder);

  /// The JSON file of the folder: that of the comparison or of the run.
  const char* source() const { return source_; }
  const std::vector<ForceRun>& runs() const { return runs_; }
  /// Whether ForceRun::x is the crank angle.
  bool turns() const { return drive_.has_value(); }

  /// Names of joints and contacts. If there are too many, joints with clearance have priority.
  std::vector<std::string> joints() const;
  /// Names of the drives that have a torque.
  std::vector<std::string> drives() const;
  bool revolute(const std::string& name) const;
  /// Heading of a figure of this force; it names the body on which the force acts.
  std::string heading(const std::string& name) const;

  bool any(const std::string& column) const;
  /// A column of every run (N, N m); for a guide with clearance the sum over its corners. Empty for
  /// runs without it.
  std::vector<Values> columns(const std::string& name, const char* suffix) const;
  /// |F| in every run (N).
  std::vector<Values> magnitudes(const std::string& name) const;

  /// the part of the run that is drawn, and the interval of the means
  std::string extent() const;

 private:
  void add(const std::filesystem::path& folder, const char* title, int style);
  const Joint* joint(const std::string& name) const;
  bool clearance_joint(const std::string& name) const;

  const char* source_ = "run.json";
  std::vector<ForceRun> runs_;
  std::shared_ptr<const Scene> scene_;
  std::optional<SpeedDrive> drive_;  // the drive of the crank
  double interval_ = 0;              // s, greatest interval of the runs
  std::set<std::string> undetermined_;
};

}  // namespace freeplay::plots
