// What figures take from the run.json of a run beside its tables: the scene, and which time they show.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace freeplay {
struct Scene;
}

namespace freeplay::plots {

/// The scene of the run in a folder, as far as this program can read it; null where it cannot.
std::shared_ptr<const Scene> scene_of_run(const std::filesystem::path& folder);

/// Time of one turn of the drive whose turns are counted (s); nothing where none drives at a prescribed speed.
std::optional<double> turn_of(const Scene* scene);

/// A stretch of a run, and what figures call it.
struct Span {
  double from, to;  ///< s
  std::string name;
  bool holds(double t) const { return t >= from && t <= to; }
};
/// The first turn, or the first tenth of a run that turns nothing.
Span first_part(std::optional<double> turn, double end);
/// The last `turns` turns, fewer of a run that has hardly as many; or the last tenth.
Span last_part(std::optional<double> turn, double end, int turns);

/// A run whose tables are drawn.
struct RunFolder {
  std::filesystem::path folder;
  std::string title;  ///< penalty, nonsmooth, ideal joint
  int style;          ///< 1, 2, 3: line style of that
};
/// The folder itself, or the runs of a comparison that stand in it, those that have a trajectory.
std::vector<RunFolder> runs_in(const std::filesystem::path& folder);

/// Time of a run's last row (s).
double end_of(const std::filesystem::path& folder);

/// s, before which statistics of the run do not count.
double discard_of(const std::filesystem::path& folder);

}  // namespace freeplay::plots
