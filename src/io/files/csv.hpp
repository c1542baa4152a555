// Observers that write the CSV files of a result folder while a run steps: trajectory.csv,
// events.csv, signals.csv and forces.csv. docs/reference/results.md lists their columns. The memory
// use is independent of the length of the run. Each observer owns its file; run_folder.cpp attaches
// the observers and commits the files.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "io/files/output_file.hpp"
#include "simulation/observer.hpp"
#include "simulation/occasional.hpp"
#include "simulation/table_rows.hpp"

namespace freeplay {

/// Base class of observers that write one file.
class FileObserver : public Observer {
 public:
  /// Opens a new file. `resumed`: load() follows, which restores the position in an existing file.
  explicit FileObserver(const std::filesystem::path& path, bool resumed = false) : file_(path, resumed) {}
  /// Continues the file after load(), which only checks it.
  void go_on() { file_.go_on_at(from_); }
  /// Keeps the partial file if the run is interrupted, because a checkpoint refers to it.
  void keep() { file_.keep(); }
  std::string name() const { return file_.path().filename().string(); }
  /// Flushes all output to the operating system.
  void settle() { file_.settle(); }
  /// Moves the complete file to its final name.
  void commit() { file_.commit(); }
  void save(MemoryWriter& m) override;
  void load(MemoryReader& m) override;

 protected:
  /// Whether the header has not been written yet.
  bool fresh() const { return fresh_; }
  void header(std::string_view text) {
    file_.write(text);
    fresh_ = false;
  }
  void field(double x) {
    file_.write(",");
    file_.number(x);
  }
  void line(std::span<const double> numbers);
  OutputFile file_;

 private:
  bool fresh_ = true;
  std::uint64_t from_ = 0;
};

/// trajectory.csv: state and contact positions at multiples of the output step.
class TrajectoryCsv final : public FileObserver, public Occasional, RowSink {
 public:
  using FileObserver::FileObserver;
  double next() const override { return rows_.next(); }
  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;
  void save(MemoryWriter& m) override;
  void load(MemoryReader& m) override;

 private:
  void row(std::span<const double> numbers) override { line(numbers); }
  TrajectoryRows rows_;
};

/// events.csv: contact events, one a line.
class EventsCsv final : public FileObserver {
 public:
  using FileObserver::FileObserver;
  Wants wants() const override { return {.steps = false}; }
  void begin(const Layout& layout, const State& state) override;
  void event(const Event& event) override;
};

/// signals.csv: samples of the instruments.
class SignalsCsv final : public FileObserver {
 public:
  using FileObserver::FileObserver;
  Wants wants() const override { return {.samples = true, .steps = false}; }
  void begin(const Layout& layout, const State& state) override;
  void sample(std::size_t channel, double t, double value) override;

 private:
  std::vector<std::string> names_;
  double crank_start_ = 0, crank_speed_ = 0;
};

/// forces.csv: forces and accelerations at the times of trajectory.csv, and their means since the
/// previous row.
class ForcesCsv final : public FileObserver, RowSink {
 public:
  using FileObserver::FileObserver;
  Wants wants() const override { return {.forces = true}; }
  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;
  void save(MemoryWriter& m) override;
  void load(MemoryReader& m) override;

 private:
  void row(std::span<const double> numbers) override { line(numbers); }
  ForceRows rows_;
};

}  // namespace freeplay
