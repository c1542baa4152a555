// Estimate of a run's output before it starts, to refuse a run that would fill the disk. The number
// of rows is known exactly. The mean width of a written number varies little, because numbers are
// written in the shortest form that reads back the same. The number of impacts is unknown in
// advance, so the sum excludes events.csv. Use: require_room(scene, estimate_output(scene, start),
// ...).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freeplay {

struct Scene;
struct State;

/// Estimated sizes of the result files of one run.
struct OutputEstimate {
  struct File {
    std::string name;
    double bytes = 0;
  };
  std::vector<File> files;
  double event_bytes = 0;  ///< size of one event; 0 if no contact is possible

  double bytes() const;
  /// Text for messages: "17 MB (trajectory.csv 5.9 MB, ...)", the largest files first.
  std::string text() const;
};

/// Estimates the files that run_scene() writes for a run from this start.
OutputEstimate estimate_output(const Scene& scene, const State& start);

/// Default limit of the output, bytes.
inline constexpr double default_output_limit = 10e9;

/// Throws SceneError if `copies` such runs together would write more than `limit` bytes, and
/// OutputError if the file system of `folder` has less free space. The folder need not exist.
void require_room(const Scene& scene, const OutputEstimate& estimate, int copies,
                  const std::filesystem::path& folder, double limit);

}  // namespace freeplay
