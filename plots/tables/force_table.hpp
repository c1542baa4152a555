// The forces of a result folder: its runs side by side, and what their columns mean by the scene, as far as
// this program can read it.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mechanism/elements.hpp"
#include "plots/tables/force_run.hpp"

namespace freeplay {
struct Scene;
}

namespace freeplay::plots {

/// Corners of a loose guide and sides of a loose slot, as the columns of their forces end.
inline constexpr const char* guide_corners[] = {"rear_lower",  "rear_upper", "front_lower",
                                                "front_upper", "right",      "left"};

class ForceTable {
 public:
  /// Of a compared scene both formulations and the ideal mechanism, else the folder's own run; those that
  /// have a forces.csv. Throws SceneError when such a file cannot be read.
  explicit ForceTable(const std::filesystem::path& folder);

  /// The folder's JSON file: of a comparison or of the run.
  const char* source() const { return source_; }
  const std::vector<ForceRun>& runs() const { return runs_; }
  /// Whether ForceRun::x is the crank's angle.
  bool turns() const { return drive_.has_value(); }

  /// Names of joints and contacts; of too many the loose joints first.
  std::vector<std::string> joints() const;
  /// Names of the drives with a torque.
  std::vector<std::string> drives() const;
  bool revolute(const std::string& name) const;
  /// What a figure of its force is headed with: on which body the force is.
  std::string heading(const std::string& name) const;

  bool any(const std::string& column) const;
  /// A column of every run (N, N m); of a loose guide the sum over its corners. Empty where a run has none.
  std::vector<Values> columns(const std::string& name, const char* suffix) const;
  /// |F| of every run (N).
  std::vector<Values> magnitudes(const std::string& name) const;

  std::string abscissa() const;  ///< what is drawn over, with its unit
  std::string extent() const;    ///< which part of the run is drawn, and what the means are over

 private:
  void add(const std::filesystem::path& folder, const char* title, int style);
  const Joint* joint(const std::string& name) const;
  bool loose(const std::string& name) const;

  const char* source_ = "run.json";
  std::vector<ForceRun> runs_;
  std::shared_ptr<const Scene> scene_;
  std::optional<SpeedDrive> drive_;  // that turns the crank
  double interval_ = 0;              // s, greatest of the runs
  std::set<std::string> undetermined_;
};

}  // namespace freeplay::plots
