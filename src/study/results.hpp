// A study's results in one SQLite file. Each run is stored whole in one transaction, so a program that is
// stopped at any moment leaves only whole runs; the next one carries on with what is missing.
#pragma once

#include <set>

#include "study/case_run.hpp"

struct sqlite3;

namespace freeplay {

/// One row of `runs` as figures and claims use it.
struct RunRow {
  std::string key, variant, formulation;
  int start = 0;
  std::vector<double> values;  ///< of the axes
  std::array<double, TurnMetrics::count> metric{};
  std::string doubt;  ///< what the run says of itself that makes it DOUBTFUL; or ""
};

class Results {
 public:
  /// Opens or makes the file; `axes` are the names of its columns. Throws OutputError, also when the file
  /// holds another study's axes, or keys of another kind than run_key().
  Results(const std::filesystem::path& file, const Study& study);
  ~Results();
  Results(const Results&) = delete;
  Results& operator=(const Results&) = delete;

  /// Keys of the runs that are there.
  std::set<std::string> keys() const;
  void store(const std::string& key, const Case& one, const CaseResult& result);
  /// Removes runs that are not among `keep`: of an earlier form of the study.
  void retain(const std::set<std::string>& keep);
  /// Finished runs by variant, formulation, axes and start; of these keys, or with none given all.
  std::vector<RunRow> runs(const std::set<std::string>& keys = {}) const;
  /// Runs that failed: key, variant, formulation, reason.
  std::vector<std::array<std::string, 3>> failures() const;
  std::vector<Flight> flights(const std::string& key) const;
  std::vector<CountedImpact> impacts(const std::string& key) const;
  std::vector<double> spectrum(const std::string& key) const;
  std::vector<TracePoint> trace(const std::string& key) const;
  double cpu_seconds() const;

 private:
  class Statement;
  void execute(const std::string& sql) const;
  [[noreturn]] void fail(const std::string& what) const;

  std::filesystem::path file_;
  sqlite3* db_ = nullptr;
  std::size_t axes_ = 0;
};

}  // namespace freeplay
