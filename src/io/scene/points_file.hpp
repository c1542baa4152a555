// Reads the points of a curve from CSV text with a header: two of its columns, selected by name, or
// the first two. Empty lines and lines that begin with # are ignored.
#pragma once

#include <functional>
#include <optional>
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

/// A CSV text with a header: its fields without spaces and quotes. Empty lines and lines that begin
/// with # are left out.
struct TextTable {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
  std::vector<long> line;  ///< number of each row's line in the text, from 1
};
/// Reads the whole text; `fail` throws an error if it has no header.
TextTable read_text_table(const std::string& text, const std::function<void(const std::string&)>& fail);
/// Message for a header whose separator is not a comma; empty for any other.
std::string wrong_separator(const std::string& header);
/// The number that is the whole text.
std::optional<double> number_in(std::string_view text);
/// A text without spaces and quotes at its ends; the fields of a line, each without them.
std::string trimmed(const std::string& text);
std::vector<std::string> fields(const std::string& line);

}  // namespace freeplay
