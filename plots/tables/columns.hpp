// Columns of a run's result files by their names: those of trajectory.csv, forces.csv and events.csv as their headers have
// them, the channels of signals.csv, t, and crank_angle where a drive turns at a prescribed speed.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace freeplay {
struct Scene;
}

namespace freeplay::plots {

/// Of a column of a result file by its name: "m" of slider.x, "N" of pin.fx_mean; "" where there is none.
std::string_view unit_of_column(std::string_view column);

/// A column, and where it stands.
struct Column {
  std::string name;
  std::string file;     ///< trajectory.csv, …; "" of t and crank_angle, which every file has
  std::string channel;  ///< of signals.csv
  std::string unit;
};

/// Instants at which another column passes a value, or at which the crank is at an angle.
struct Crossing {
  std::string column;  ///< "crank": the crank's angle
  double value = 0;    ///< in the column's unit; of the crank degrees
  int sense = 0;       ///< 1: rising, −1: falling, 0: both
};

/// What is drawn of one column over another.
struct Points {
  std::vector<double> x = {}, y = {};
  std::string without_rows = {};  ///< the file that has none, if one has
};

class RunColumns {
 public:
  /// Throws SceneError, as all here, for a folder that holds no run.
  explicit RunColumns(const std::filesystem::path& folder);
  /// All of them, in the order of the files.
  const std::vector<Column>& all() const { return all_; }
  /// Null where there is none of that name.
  const Column* find(std::string_view name) const;
  /// y over x from one time to another; of rows that both have at the same t. With a section its instants alone, between
  /// rows along straight lines.
  Points read(const Column& x, const Column& y, double from, double to,
              const std::optional<Crossing>& section) const;

 private:
  struct Series;
  /// Its rows from one time to another: memory is that of what is drawn.
  Series series(const Column& column, const std::string& file, const std::string& channel, double from,
                double to) const;
  /// crank_angle at a time (rad).
  double crank(double t) const;

  std::filesystem::path folder_;
  std::shared_ptr<const Scene> scene_;
  std::optional<std::pair<double, double>> crank_;  ///< rad at t = 0, rad/s
  std::vector<Column> all_;
};

/// What is wrong with a name that no run has: the one that was meant, or those that there are.
std::string no_column(const std::string& name, const std::vector<Column>& all);

}  // namespace freeplay::plots
