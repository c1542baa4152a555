// The tables of a run as CSV files of its result folder, which grow while it steps: trajectory.csv,
// events.csv, signals.csv and forces.csv. docs/reference/results.md lists their columns. The memory
// use is independent of the length of the run. Each object observes a run and owns its file;
// run_folder.cpp attaches them and commits the files.
#pragma once

#include <filesystem>
#include <vector>

#include "io/files/output_file.hpp"
#include "simulation/observer.hpp"
#include "simulation/table_rows.hpp"
#include "values/table.hpp"

namespace freeplay {

/// A table in a file.
class TableCsv : public TableSink {
 public:
  /// Opens a new file. `resumed`: load_from() follows, which restores the position in an existing
  /// file.
  explicit TableCsv(const std::filesystem::path& path, bool resumed = false) : file_(path, resumed) {}
  void put(std::span<const double> numbers, std::span<const std::string_view> texts) override;
  /// Writes a whole table.
  void write(const Table& table) {
    file_.write(table.csv_header());
    file_.write(table.csv_rows());
  }
  /// Flushes all output to the operating system and saves its position.
  void save_to(MemoryWriter& m) override;
  void load_from(MemoryReader& m) override;
  /// Continues the file after load_from(), which only checks it.
  void go_on() { file_.go_on_at(from_); }
  /// Keeps the partial file if the run is interrupted, because a checkpoint refers to it.
  void keep() { file_.keep(); }
  std::string name() const { return file_.path().filename().string(); }
  /// Flushes all output to the operating system.
  void settle() { file_.settle(); }
  /// Moves the complete file to its final name.
  void commit() { file_.commit(); }

 private:
  void head() override;
  OutputFile file_;
  std::uint64_t from_ = 0;
};

struct TrajectoryCsv final : RowsInto<TrajectoryRows, TableCsv>, Occasional {
  using RowsInto::RowsInto;
  double next() const override { return next_row(); }
};
using EventsCsv = RowsInto<EventRows, TableCsv>;
using SignalsCsv = RowsInto<SignalRows, TableCsv>;
using ForcesCsv = RowsInto<ForceRows, TableCsv>;

}  // namespace freeplay
