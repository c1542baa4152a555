// Reduces long tables to the resolution of a screen without losing peaks. Rows are grouped into
// buckets; each bucket keeps the least and the greatest value of each column, in their order in
// time:
//
//     y_2i, y_2i+1 = min, max of bucket i (or max, min), at ¼ and ¾ of its time.
//
// All values occur in the file; the error of their times is less than the length of a bucket. Short
// tables are not reduced.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <vector>

namespace freeplay::report {

/// Rounds x to the given number of significant digits, to save space.
double rounded(double x, int digits);

class Thinning {
 public:
  /// A table of `rows` rows. About `most` values per column are kept, at least two.
  Thinning(long rows, std::size_t columns, long most);
  /// Adds the next row.
  void take(double t, std::span<const double> values);
  /// To be called after the last row.
  void finish();

  bool whole() const { return each_ == 1; }
  const std::vector<double>& t() const { return t_; }
  const std::vector<double>& column(std::size_t k) const { return columns_[k].values; }

 private:
  struct Column {
    std::vector<double> values = {};
    double least = 0, greatest = 0;
    bool rises = true;  ///< the least value comes before the greatest
    bool any = false;   ///< the bucket has a number
  };
  void close();

  long each_, filled_ = 0;  // rows per bucket; rows in the current one
  double from_ = 0, to_ = 0;
  std::vector<double> t_;
  std::vector<Column> columns_;
};

/// JSON numbers rounded to `digits` significant digits (ten for times). Values that are not finite
/// become null.
nlohmann::json numbers(const std::vector<double>& list, int digits = 6);

}  // namespace freeplay::report
