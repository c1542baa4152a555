// Reads the points of a curve from CSV text with a header: two of its columns, selected by name, or
// the first two. Empty lines and lines that begin with # are ignored.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace freeplay {

/// Reads the points. `columns`: two names, or empty for the first two columns. `fail` throws an
/// error with the given message, which includes the line.
std::vector<std::pair<double, double>> read_points(const std::string& text,
                                                   const std::vector<std::string>& columns,
                                                   const std::function<void(const std::string&)>& fail);

/// Reads the lines of a CSV text as fields without spaces and quotes. Empty lines and lines that begin with #
/// are left out.
class TextRows {
 public:
  explicit TextRows(const std::string& text);
  /// Advances to the next row; false after the last one. The header is the first row.
  bool next();
  const std::vector<std::string>& fields() const { return fields_; }
  /// Number of the row's line in the text, from 1.
  long number() const { return number_; }

 private:
  std::istringstream in_;
  std::vector<std::string> fields_;
  long number_ = 0;
};
/// Message for a header whose separator is not a comma; empty for any other.
std::string wrong_separator(const std::string& header);
/// Message for a line with another number of fields than its header.
std::string wrong_count(std::size_t fields, std::size_t columns);
/// The number that is the whole text.
std::optional<double> number_in(std::string_view text);
/// A text without spaces and quotes at its ends; the fields of a line, each without them.
std::string trimmed(const std::string& text);
std::vector<std::string> fields(const std::string& line);

}  // namespace freeplay
