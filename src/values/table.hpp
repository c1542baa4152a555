// A table of results: named columns, whose names state the units, and rows of numbers and texts. The
// writers print it as CSV, as Markdown and for a terminal. Tables of a run, which may be long, are
// written row by row instead (simulation/table_rows.hpp).
//
//     Table t({"setting", "rhs", "CPU ms"});
//     t.row(name, 1200, fmt::format("{:.3g}", ms));
//     text = t.terminal({29, 9, 9});
#pragma once

#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace freeplay {

class Table {
 public:
  using Cell = std::variant<double, std::int64_t, std::string>;

  explicit Table(std::vector<std::string> columns = {}) : columns_(std::move(columns)) {}
  /// From the header of a CSV file.
  explicit Table(const char* names);
  void column(std::string name) { columns_.push_back(std::move(name)); }
  template <class... X>
  void row(const X&... cells) {
    rows_.push_back({cell(cells)...});
  }
  void row(std::vector<Cell> cells) { rows_.push_back(std::move(cells)); }
  void row(const std::vector<double>& numbers) { rows_.emplace_back(numbers.begin(), numbers.end()); }
  template <class X>
  static Cell cell(const X& x) {
    if constexpr (std::is_floating_point_v<X>)
      return static_cast<double>(x);
    else if constexpr (std::is_integral_v<X>)
      return static_cast<std::int64_t>(x);
    else
      return std::string(x);
  }
  const std::vector<std::string>& columns() const { return columns_; }
  const std::vector<std::vector<Cell>>& rows() const { return rows_; }

  /// The header and the rows; numbers in the shortest form that reads back the same.
  std::string csv() const { return csv_header() + csv_rows(); }
  std::string csv_header() const;
  /// The rows from this one on, for a table that is written while it grows.
  std::string csv_rows(std::size_t from = 0) const;
  std::string markdown() const;
  /// Columns of these widths, the first one to the left (of negative width: to the right), the others
  /// to the right, at least one space apart. A first cell that is too wide has a line of its own.
  /// `rule`: a line below the header.
  std::string terminal(const std::vector<int>& widths, bool rule = false) const;

 private:
  std::vector<std::string> columns_;
  std::vector<std::vector<Cell>> rows_;
};

}  // namespace freeplay
