// A result file (CSV without quotes) as its columns of numbers.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace freeplay::test {

/// A field with a word, such as the channel's name in signals.csv, is NaN as a number. Throws if a
/// line has another number of fields than the header.
class Columns {
 public:
  explicit Columns(const std::filesystem::path& file);
  const std::string& header() const { return header_; }
  std::size_t rows() const { return rows_.size(); }
  const std::vector<double>& row(std::size_t i) const { return rows_.at(i); }
  bool has(const std::string& column) const { return index_.contains(column); }
  double at(std::size_t row, const std::string& column) const { return rows_.at(row)[index_.at(column)]; }

 private:
  std::string header_;
  std::map<std::string, std::size_t> index_;
  std::vector<std::vector<double>> rows_;
};

}  // namespace freeplay::test
