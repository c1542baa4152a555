// Database of bifurcation diagrams and basins (study/store/run_store.hpp). Stored runs are not
// repeated, so an interrupted study continues, and its file finally has the same contents.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "study/attractors/attractor.hpp"
#include "study/runs/section_run.hpp"
#include "study/store/run_store.hpp"

namespace freeplay {

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
  /// Reads a run; false if there is none with this key. Refuses the file if the run is not as expected.
  bool find(const std::string& key, const Expected& expected, SettledRun& run) const;
  void store(const std::string& key, const SettledRun& run, const std::vector<NamedColumn>& columns);

  /// @name Exponents, averaged over at least `periods`
  /// Their table exists from begin_exponents() on, in studies that request them.
  ///@{
  void begin_exponents();
  std::optional<AttractorExponent> find_exponent(const std::string& key, long periods) const;
  void store_exponent(const std::string& key, long periods, const AttractorExponent& exponent);
  ///@}
};

}  // namespace freeplay
