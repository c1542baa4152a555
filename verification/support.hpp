// What tests share: where the scenes are, and short ways to run one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formulations/make.hpp"
#include "sim/run_summary.hpp"

namespace freeplay::test {

inline std::filesystem::path source_folder() { return FREEPLAY_SOURCE_DIR; }
inline std::filesystem::path flores() { return source_folder() / "cases/flores2011/scene.toml"; }
inline std::filesystem::path scene_file(const std::string& name) {
  return source_folder() / "verification/scenes" / (name + ".toml");
}

/// One run in memory.
inline RunSummary simulate(const Scene& scene, Family family) {
  return run_scene(
      scene,
      [family](const Scene& s, const System& system, const State& state) {
        return make(family, s, system, state);
      },
      std::nullopt);
}

/// Touches (impacts and beginnings of lasting contact) in the order of time.
inline std::vector<ContactEvent> touches(const RunSummary& run) {
  std::vector<ContactEvent> list;
  for (const auto& e : run.events)
    if (e.kind != EventKind::separation) list.push_back(e);
  return list;
}

/// The i-th touch (from 0), or an error that says how many there were.
ContactEvent touch(const RunSummary& run, std::size_t i);

/// Slope of log y over log x, least squares through all points: an observed order.
double observed_order(const std::vector<double>& x, const std::vector<double>& y);

/// A row of N four-bars that share their uprights (IFToMM benchmark A02: links of 1 m and 1 kg, gravity, the
/// first upright turning at 1 rad/s), the joint between every coupler and the upright behind it loose.
Scene row_of_four_bars(int count, double clearance);

/// A folder that is removed with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Runs the freeplay program; its output on both streams, and its exit status.
struct Outcome {
  int status;
  std::string out, err;
};
Outcome freeplay(const std::string& arguments);

}  // namespace freeplay::test
