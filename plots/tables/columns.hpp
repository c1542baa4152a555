// Columns of a run's result files by their names: those in the headers of trajectory.csv,
// forces.csv and events.csv, the channels of signals.csv, t, and, if a drive turns at a prescribed speed,
// crank_angle. Functions of the columns of trajectory.csv:
//
//     JOINT.angle, .position, .rate   of revolute and translational joints, as in sections
//                                     (io/scene/read_section.hpp)
//     DRIVE.error                     target(t) − coordinate that a controller measures
//
// And expressions of all these, such as hypot(pin.fx, pin.fy).
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plots/drawing/gnuplot.hpp"

namespace freeplay {
class Expression;
struct Scene;
}  // namespace freeplay

namespace freeplay::plots {

/// Unit of a column of a result file by its name: "m" for slider.x, "N" for pin.fx_mean; "" if it
/// has none.
std::string_view unit_of_column(std::string_view column);

/// Unit of the samples of an instrument of the scene; "" if it has none of that name.
std::string_view unit_of_instrument(const Scene& scene, std::string_view name);
/// The quantity of a column: its name and symbol in the field.
struct ColumnQuantity {
  Word name{""}, symbol{""};
  bool mean = false;  ///< over the time since the row before
};

/// Quantity of a column of a result file or a section by its name; without a name if unknown. The unit
/// distinguishes rates of revolute and translational joints.
ColumnQuantity quantity_of_column(const std::string& column, std::string_view unit = "");

/// A number of run.json by its path: pin, "greatest impulse" and N s for pin.greatest_impulse_N_s.
struct RunNumber {
  std::string element, words, unit;
};
RunNumber number_of_run(const std::string& path);

/// A function of the time and of the bodies' coordinates and velocities in trajectory.csv.
struct StateFunction;

/// A column and its file.
struct Column {
  std::string name;
  std::string file;     ///< trajectory.csv, …; "" for t and crank_angle, which every file has
  std::string channel;  ///< channel in signals.csv
  std::string unit;
  ColumnQuantity quantity = {};
  std::shared_ptr<const StateFunction> function = {};  ///< null: the column is in the file
  /// The name without that of the quantity: slider for slider.x; empty for t.
  std::string element() const;
};

/// Adds coordinates of joints and errors of controllers to a list with the columns of trajectory.csv.
void add_state_functions(const Scene& scene, std::vector<Column>& all);

/// A column, or an expression of columns.
struct ColumnFormula {
  std::string text;  ///< name or expression
  std::string unit;  ///< SI
  std::vector<Column> columns;
  std::shared_ptr<const Expression> expression = {};  ///< null: the column itself
  /// Value for those of the columns, in their order.
  double value(std::span<const double> values) const;
};
/// Reads a name or an expression. Throws SceneError for an unknown name, an invalid expression, and
/// a sum of different dimensions.
ColumnFormula formula_of(const std::string& text, const std::vector<Column>& all);
/// Texts separated by commas outside parentheses.
std::vector<std::string> columns_named(std::string_view list);

/// A section: the instants at which another column passes a value, or the crank an angle.
struct Crossing {
  std::string column;  ///< "crank": the crank's angle
  double value = 0;    ///< in the unit of the column; degrees for the crank
  int sense = 0;       ///< 1: rising, −1: falling, 0: both
};

/// Points of one column over another.
struct Points {
  std::vector<double> x = {}, y = {};
  std::string without_rows = {};  ///< the file without rows, if there is one
};

class RunColumns {
 public:
  /// Throws SceneError if the folder has no run. All functions of this class throw SceneError.
  explicit RunColumns(const std::filesystem::path& folder);
  /// All columns, in the order of the files.
  const std::vector<Column>& all() const { return all_; }
  /// Null if there is no column of that name.
  const Column* find(std::string_view name) const;
  /// y over x between two times, from the rows that both have at the same t. With a section: only
  /// its instants, by linear interpolation between rows.
  Points read(const ColumnFormula& x, const ColumnFormula& y, double from, double to,
              const std::optional<Crossing>& section) const;
  Points read(const Column& x, const Column& y, double from, double to,
              const std::optional<Crossing>& section) const;

 private:
  struct Series;
  /// The rows of a column between two times. Only these are kept in memory.
  Series series(const Column& column, const std::string& file, const std::string& channel, double from,
                double to) const;
  /// crank_angle at time t (rad).
  double crank(double t) const;

  std::filesystem::path folder_;
  std::shared_ptr<const Scene> scene_;
  std::optional<std::pair<double, double>> crank_;  ///< rad at t = 0, rad/s
  std::vector<Column> all_;
};

using NamesByKind = std::vector<std::pair<std::string, std::vector<std::string>>>;
/// A list of names for a message: a line for each kind that has names, broken at 78 characters.
std::string listed_names(const NamesByKind& lists);

}  // namespace freeplay::plots
