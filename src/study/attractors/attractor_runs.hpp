// Execution of runs that determine attractors. Runs that are stored
// (AttractorStore) are not repeated.
//
// A chain is a sequence of runs, each of which may start where the one before ended. The positions
// and velocities of the bodies are projected onto the constraints of the next value
// (dynamics/assembly/assembly.hpp); first-order states are kept. Contacts start anew. Drives
// continue from their angles; quantities prescribed by a curve continue because a run ends after
// whole periods.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/attractor.hpp"
#include "study/runs/section_run.hpp"
#include "study/settings/study.hpp"
#include "study/store/run_store.hpp"

namespace freeplay {

// Database of bifurcation diagrams and basins (study/store/run_store.hpp). Stored runs are not
// repeated, so an interrupted study continues, and its file finally has the same contents.

/// The largest Lyapunov exponent of an attractor (study/attractors/attractor_exponents.hpp).
struct AttractorExponent {
  double value = 0;    ///< 1/s; −∞ if perturbations vanish in finite time, NaN if it is not known
  double error = 0;    ///< 1/s, standard error; NaN unless the value is finite
  std::string reason;  ///< why the value is −∞ or NaN, or its average shorter; else empty
};

/// Result of one run.
struct SettledRun {
  std::string key;  ///< in the database
  std::string branch;
  std::vector<double> values;
  std::string failure, doubt;   ///< reason of an early end; reason for doubtful points
  std::vector<double> t, rows;  ///< times (s); rows of columns, one row for each point
  State end;
  double period = 0;  ///< s; 0: none. Not stored
  /// Rad, of the drives at its end; NaN for those that prescribe no speed. Not stored.
  std::vector<double> drive_angles;
  Attractor attractor;                        ///< determined from `rows`
  std::optional<AttractorExponent> exponent;  ///< of the attractor, if requested
  bool finished() const { return failure.empty(); }
};

/// The database.
class AttractorStore : public RunStore {
 public:
  explicit AttractorStore(const std::filesystem::path& file, StopToken stop);
  /// What a stored run of a scene must have.
  struct Expected {
    const std::vector<NamedColumn>& columns;  ///< of its points
    std::size_t coordinates = 0, states = 0;  ///< of its end
    double until = 0;                         ///< s, its end if it finished
  };
  /// Reads a run; false if there is none with its key. Refuses the file if the run is not as expected.
  bool find(const Expected& expected, SettledRun& run) const;
  void store(const SettledRun& run, const std::vector<NamedColumn>& columns);

  /// @name Exponents, averaged over at least `periods`
  /// Their table exists from begin_exponents() on, in studies that request them.
  ///@{
  void begin_exponents();
  std::optional<AttractorExponent> find_exponent(const std::string& key, long periods) const;
  void store_exponent(const std::string& key, long periods, const AttractorExponent& exponent);
  ///@}
};

struct Scene;

/// One run: its scene, and its row in the results.
struct ChainLink {
  std::vector<std::string> overrides;
  std::vector<double> values;  ///< of the axes, one or two
  int start = -1;              ///< number of the drawn start; −1: the scene's own start
};

/// A sequence of runs.
struct Chain {
  std::string branch;  ///< "up", "down", "start 3"; "grid" for a basin
  std::vector<ChainLink> links;
};

/// Results of all chains.
struct SettledRuns {
  std::vector<std::vector<SettledRun>> chains;  ///< in the order of the request
  std::vector<NamedColumn> columns;
  Likeness likeness;
  std::size_t found = 0, made = 0;
  long in_lanes = 0;  ///< steps of made runs that were made together with those of other runs
  double period = 0;  ///< s, of the first run; 0: none
  bool interrupted = false;
};

/// Checks every scene of the chains, then executes missing runs, with chains in parallel on
/// `threads` threads (0: all cores). Throws SceneError.
SettledRuns settle(const Study& study, const AttractorPlan& plan, const char* table,
                   const std::vector<Chain>& chains, AttractorStore& store, int threads, StopToken stop,
                   const OnProgress& on_progress);

/// End of a run, as start of another one.
struct Handed {
  State state;
  /// Rad, of the scene's drives; NaN for drives that prescribe no speed.
  std::vector<double> drive_angles;
};

/// Starts a scene from the end of a run, whose value may differ: sets the angles of its drives and returns
/// the start.
State take_over(Scene& scene, const Handed& from, const StopToken& stop);

/// The scene of a run. Throws SceneError.
Scene scene_of(const Study& study, const AttractorPlan& plan, const ChainLink& link, const StopToken& stop);

/// KEY=VALUE of every key of an axis, for an index in its list of values.
std::vector<std::string> settings_at(const Axis& axis, std::size_t place);

}  // namespace freeplay
