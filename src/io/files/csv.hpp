// Observers that stream what they see into the files of a result folder. Memory does not grow with the length of
// the run.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "io/files/output_file.hpp"
#include "simulation/observer.hpp"
#include "simulation/table_rows.hpp"

namespace freeplay {

/// An observer with a file of its own.
class FileObserver : public Observer {
 public:
  /// `resumed`: load() follows.
  explicit FileObserver(const std::filesystem::path& path, bool resumed = false) : file_(path, resumed) {}
  /// After load(): goes on with the file, which load() has only looked at.
  void go_on() { file_.go_on_at(from_); }
  /// A checkpoint knows how to go on with it.
  void keep() { file_.keep(); }
  std::string name() const { return file_.path().filename().string(); }
  /// Hands all of it to the operating system.
  void settle() { file_.settle(); }
  /// Puts the file in its place.
  void commit() { file_.commit(); }
  void save(MemoryWriter& m) override;
  void load(MemoryReader& m) override;

 protected:
  /// Whether the header is still to be written.
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

/// trajectory.csv: state and contacts at multiples of the output step.
class TrajectoryCsv final : public FileObserver, RowSink {
 public:
  using FileObserver::FileObserver;
  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;
  void save(MemoryWriter& m) override;
  void load(MemoryReader& m) override;

 private:
  void row(std::span<const double> numbers) override { line(numbers); }
  TrajectoryRows rows_;
};

/// events.csv
class EventsCsv final : public FileObserver {
 public:
  using FileObserver::FileObserver;
  Wants wants() const override { return {.steps = false}; }
  void begin(const Layout& layout, const State& state) override;
  void event(const Event& event) override;
};

/// signals.csv: the instruments' samples.
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

/// forces.csv: forces and accelerations at the rows of trajectory.csv, and their means since the row before.
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
