// The starts of an ensemble that are made (study/store/run_store.hpp): tables runs (run, start, failure, steps, rows: a blob of doubles) and
// numbers (run, name, value).
#pragma once

#include "study/ensemble/ensemble.hpp"
#include "study/store/run_store.hpp"

namespace freeplay {

class EnsembleStore : public RunStore {
 public:
  explicit EnsembleStore(const std::filesystem::path& file, Database::Access access = Database::Access::write,
                         StopToken stop = {});
  /// False where there is none of that key.
  bool find(const std::string& key, StartOutcome& outcome) const;
  void store(const std::string& key, int start, const StartOutcome& outcome) const;
};

/// What tells one start from any other: neither how many there are nor on how many threads.
class StartKeys {
 public:
  StartKeys(const Scene& scene, const EnsemblePlan& plan);
  std::string operator()(int start) const;
  /// Of all that starts have in common, and how many they are.
  std::string subject() const;

 private:
  std::string common_;
  int starts_;
};

}  // namespace freeplay
