// Database of an ensemble's starts (study/store/run_store.hpp): tables runs (run, start, failure,
// steps, rows: a blob of doubles) and numbers (run, name, value).
#pragma once

#include "study/ensemble/ensemble.hpp"
#include "study/store/run_store.hpp"

namespace freeplay {

/// The database.
class EnsembleStore : public RunStore {
 public:
  explicit EnsembleStore(const std::filesystem::path& file, Database::Access access = Database::Access::write,
                         StopToken stop = {});
  /// Reads the result of a start; false if there is none with this key.
  bool find(const std::string& key, StartOutcome& outcome) const;
  void store(const std::string& key, int start, const StartOutcome& outcome) const;
};

/// Keys of starts. They depend on everything that affects a start, but not on the number of starts
/// and threads.
class StartKeys {
 public:
  StartKeys(const Scene& scene, const EnsemblePlan& plan);
  std::string operator()(int start) const;
  /// Digest of the common part of all starts, and their number.
  std::string subject() const;

 private:
  std::string common_;
  int starts_;
};

}  // namespace freeplay
