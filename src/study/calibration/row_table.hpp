// RowTable: the rows of a study's CSV file (study/settings/measured_rows.hpp), as settings of the scene and
// measured values.
#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

#include "study/settings/study.hpp"

namespace freeplay {

/// The used rows, in the order of the file.
struct RowTable {
  std::vector<long> lines;                         ///< of the file, from 1
  std::vector<std::vector<std::string>> settings;  ///< KEY=VALUE of each row
  Eigen::MatrixXd measured;                        ///< a row for each, a column for each target
  std::vector<std::vector<double>> values;         ///< of each classification: its value in each row
  std::vector<int> part;                           ///< of each row
  std::size_t excluded = 0;                        ///< rows that `where` excludes
  std::size_t size() const { return lines.size(); }
};

/// Class of a value: the number of edges that are at most the value.
int class_of(const RowClasses& classes, double value);
/// Its range in words.
std::string class_name(const RowClasses& classes, int number);

/// Reads study.rows. Throws SceneError for a wrong expression, a line that is not numeric, an expression
/// without a value, or no row.
RowTable read_rows(const Study& study);

}  // namespace freeplay
