// Long tables made short enough for a screen, and no peak lost: of each bucket of rows the least and the greatest value of each
// column, in the order in which they came,
//
//     y_2i, y_2i+1 = min, max of bucket i (or max, min),    at a quarter and three quarters of its time.
//
// A value is one that the file has; its time is off by less than the bucket's length. A table that is short enough stays whole.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <vector>

namespace freeplay::report {

/// x to so many significant digits: what a screen can show is shorter to write.
double rounded(double x, int digits);

class ThinnedTable {
 public:
  /// Of `rows` rows, so many columns; about `most` values a column are kept, at least two.
  ThinnedTable(long rows, std::size_t columns, long most);
  /// The next row.
  void take(double t, std::span<const double> values);
  /// Behind the last row.
  void finish();

  bool whole() const { return each_ == 1; }
  const std::vector<double>& t() const { return t_; }
  const std::vector<double>& column(std::size_t k) const { return columns_[k].values; }

 private:
  struct Column {
    std::vector<double> values = {};
    double least = 0, greatest = 0;
    bool rises = true;  ///< the least came first
    bool any = false;   ///< a number has come
  };
  void close();

  long each_, filled_ = 0;  // rows a bucket; in the present one
  double from_ = 0, to_ = 0;
  std::vector<double> t_;
  std::vector<Column> columns_;
};

/// Numbers for a page: six significant digits, of times ten; what is no finite number is null.
nlohmann::json numbers(const std::vector<double>& list, int digits = 6);

}  // namespace freeplay::report
