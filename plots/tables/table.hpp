// Result tables (CSV with names in the header) read by type: a field is a number or a name, or the file is refused.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/input_file.hpp"

namespace freeplay::plots {

/// A table row by row; memory does not grow with it.
class Rows {
 public:
  /// Throws SceneError, as all here, when the file cannot be read or has no header.
  explicit Rows(const std::filesystem::path& file);
  const std::vector<std::string>& names() const { return names_; }
  bool has(std::string_view column) const;
  /// Where the column of that name stands; throws when there is none.
  std::size_t place(std::string_view column) const;
  /// The next row; false behind the last. Throws when it has not as many fields as the header.
  bool next();
  /// A field of the row as a number, of which nan and inf are some.
  double number(std::size_t place) const;
  /// The same; NaN for an empty field.
  double maybe_number(std::size_t place) const;
  /// A name: letters, digits, spaces and _ - + . : at most 100 of them.
  const std::string& name(std::size_t place) const;
  /// A text for people, with nothing hidden in it.
  const std::string& label(std::size_t place) const;
  /// The same; empty for an empty field.
  const std::string& maybe_label(std::size_t place) const;

 private:
  void split();
  [[noreturn]] void refuse(std::size_t place, const char* must) const;

  std::string file_, line_;
  LineReader lines_;
  std::vector<std::string> names_, fields_;
  std::size_t count_ = 0;  // of fields
};

/// The chosen columns of a small table, whole.
class Table {
 public:
  Table(const std::filesystem::path& file, const std::vector<std::string>& names,
        const std::vector<std::string>& numbers, const std::vector<std::string>& labels = {});
  const std::vector<std::string>& text(const std::string& column) const { return texts_.at(column); }
  const std::vector<double>& column(const std::string& column) const { return numbers_.at(column); }
  std::size_t rows() const { return rows_; }

 private:
  std::map<std::string, std::vector<std::string>> texts_;
  std::map<std::string, std::vector<double>> numbers_;
  std::size_t rows_ = 0;
};

}  // namespace freeplay::plots
