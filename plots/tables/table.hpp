// Typed readers of result tables (CSV with names in the header). A field that is neither a number
// nor a name is an error.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/input_file.hpp"

namespace freeplay::plots {

/// Reads a table row by row with constant memory.
class Rows {
 public:
  /// Throws SceneError if the file cannot be read or has no header. All functions of this class
  /// throw SceneError.
  explicit Rows(const std::filesystem::path& file);
  const std::vector<std::string>& names() const { return names_; }
  bool has(std::string_view column) const;
  /// Index of the column of that name. Throws if there is none.
  std::size_t place(std::string_view column) const;
  /// Advances to the next row; false after the last one. Throws if the number of fields differs
  /// from the header.
  bool next();
  /// A field of the row as a number; nan and inf are allowed.
  double number(std::size_t place) const;
  /// number(), but NaN for an empty field.
  double maybe_number(std::size_t place) const;
  /// A field as a name: at most 100 letters, digits, spaces and _ - + . :
  std::string name(std::size_t place) const;
  /// A field as a text for display; hidden characters are an error.
  std::string label(std::size_t place) const;
  /// label(), but empty for an empty field.
  std::string maybe_label(std::size_t place) const;

 private:
  void split();
  [[noreturn]] void refuse(std::size_t place, const char* must) const;

  std::string file_, line_;
  LineReader lines_;
  std::vector<std::string> names_;
  std::vector<std::string_view> fields_;  // of line_
};

/// Selected columns of a small table, read as a whole. Labels may be empty.
class ReadTable {
 public:
  ReadTable(const std::filesystem::path& file, const std::vector<std::string>& names,
            const std::vector<std::string>& numbers, const std::vector<std::string>& labels = {});
  const std::vector<std::string>& text(const std::string& column) const { return texts_.at(column); }
  const std::vector<double>& column(const std::string& column) const { return numbers_.at(column); }
  std::size_t rows() const { return rows_; }

 private:
  std::map<std::string, std::vector<std::string>> texts_;
  std::map<std::string, std::vector<double>> numbers_;
  std::size_t rows_ = 0;
};

/// Index of a text in the list, to which a new one is appended.
std::size_t place_in(std::vector<std::string>& list, std::string_view text);

}  // namespace freeplay::plots
