// What a run will write, told before it starts. Rows are known exactly; a number that varies has a width that hardly
// does (numbers are written in the shortest form that reads back the same). How many impacts there will be is not known
// beforehand, so events.csv is left out of the sum.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freeplay {

struct Scene;
struct State;

struct OutputEstimate {
  struct File {
    std::string name;
    double bytes = 0;
  };
  std::vector<File> files;
  double event_bytes = 0;  ///< of one event; 0 where nothing can touch

  double bytes() const;
  /// "17 MB (trajectory.csv 5.9 MB, ...)", the greatest first.
  std::string text() const;
};

/// Of the files that run_scene() writes for a run that begins at `start`.
OutputEstimate estimate_output(const Scene& scene, const State& start);

/// What may be written without being allowed to, bytes.
inline constexpr double default_output_limit = 10e9;

/// Throws SceneError when `copies` runs would write more than `limit` bytes together, OutputError when the file system of `folder`, which
/// need not exist yet, has less room than that.
void require_room(const Scene& scene, const OutputEstimate& estimate, int copies,
                  const std::filesystem::path& folder, double limit);

}  // namespace freeplay
