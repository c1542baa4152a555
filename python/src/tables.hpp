// Tables of a run in memory for pandas: the rows of trajectory.csv, forces.csv, events.csv and
// signals.csv, computed by the same arithmetic as the files. Tables and documents of other results as
// values of Python.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "simulation/table_rows.hpp"
#include "values/table.hpp"

namespace freeplay::python {

/// A column of words: each distinct word is stored once.
struct Words {
  std::vector<std::string> names;
  std::vector<std::int32_t> codes;  ///< index into `names`, one per row
  void add(std::string_view word);

 private:
  std::map<std::string, std::int32_t, std::less<>> known_;
};

/// A table: its columns of numbers in row-major order, and its columns of texts.
class MemoryTable : public TableSink {
 public:
  std::vector<std::string> names;  ///< of the columns of numbers
  std::vector<double> numbers;
  std::vector<Words> texts;
  std::size_t rows() const { return names.empty() ? 0 : numbers.size() / names.size(); }
  void put(std::span<const double> row, std::span<const std::string_view> words) override;

 private:
  void head() override;
};

/// A list for each column, by its name.
pybind11::dict object_of(const Table& table);
/// Dicts, lists and values. Numbers keep NaN and infinity, which a file has as null.
pybind11::object object_of(const nlohmann::json& document);

}  // namespace freeplay::python
