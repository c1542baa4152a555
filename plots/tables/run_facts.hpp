// Facts that figures read from the run.json of a run: the scene, and the time span to show.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace freeplay {
class JsonFile;
struct Scene;
}  // namespace freeplay

namespace freeplay::plots {

class Rows;

/// The scene in the provenance of a result file; null if this program cannot read it.
std::shared_ptr<const Scene> scene_in(const JsonFile& file);
/// The scene of the run in a folder, also one that was built in code; null if this program cannot read it.
std::shared_ptr<const Scene> scene_of_run(const std::filesystem::path& folder);

/// Duration of one turn of the drive whose turns are counted (s); empty if no drive has a
/// prescribed speed.
std::optional<double> turn_of(const Scene* scene);

/// A time span of a run and its name in figures.
struct Span {
  double from, to;  ///< s
  std::string name;
  bool holds(double t) const { return t >= from && t <= to; }
};
/// The first turn; without turns the first tenth of the run.
Span first_part(std::optional<double> turn, double end);
/// The last `turns` turns, fewer if the run is short; without turns the last tenth.
Span last_part(std::optional<double> turn, double end, int turns);

/// A run with tables to draw.
struct RunFolder {
  std::filesystem::path folder;
  std::string title;  ///< penalty, nonsmooth, ideal joint
  int style;          ///< its line style: 1, 2, 3
};
/// The runs with a trajectory: the folder itself, the runs of a comparison in it, or that of a periodic
/// motion.
std::vector<RunFolder> runs_in(const std::filesystem::path& folder);

/// JSON file with the provenance of a folder of runs_in().
const char* source_of(const std::filesystem::path& folder);

/// Time of the last row of a run (s).
double end_of(const std::filesystem::path& folder);

/// Time before which the statistics of the run are discarded (s).
double discard_of(const std::filesystem::path& folder);

/// Coordinates of bodies in a trajectory, thinned for paper: if there are more rows than a curve needs, every
/// n-th row.
struct BodyMotion {
  std::vector<std::string> bodies;  ///< in the order of the file
  std::vector<double> t;
  /// [body][x, y, theta, vx, vy, omega][row]
  std::vector<std::array<std::vector<double>, 6>> coordinates;
};

/// The names before .omega in the header of a trajectory.
std::vector<std::string> bodies_in(const Rows& rows);
/// The motion of the first bodies of a run within a time span. About `rows` rows are kept.
BodyMotion motion_of(const std::filesystem::path& run, const Span& span, std::size_t most_bodies, long rows);

/// Difference of greatest and least value.
double range_of(const std::vector<double>& values);

}  // namespace freeplay::plots
