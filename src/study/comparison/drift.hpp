// Drift: effect of each constraint stabilisation of the penalty formulation on a run (`freeplay
// drift`). At 200 uniform times it records the greatest constraint errors max |Φ_i(q, t)|,
// separately for lengths (m) and angles (rad), and the closure of the energy balance
// (values/ledger.hpp). measure_drift() runs the scene once for each stabilisation, writes its
// files, and keeps no state.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "values/result.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

/// Result of one stabilisation.
struct DriftRun {
  std::string stabilisation;
  Ending ending;
  double greatest_length = 0, greatest_angle = 0;  ///< m, rad: greatest |Φ|
  double closure = 0, stabilisation_work = 0;      ///< J
  long rhs = 0;
  double cpu_seconds = 0;
};

/// Runs the scene without stabilisation, with Baumgarte's stabilisation and with projection, by a
/// one-step integrator (dopri5 unless the scene names another). Writes drift.csv
/// (stabilisation,t,length,angle,closure) and drift.json into the folder.
std::vector<DriftRun> measure_drift(const Scene& scene, const StopToken& stop,
                                    const std::filesystem::path& folder,
                                    const std::function<void(const std::string&, double)>& on_progress);

}  // namespace freeplay
