// What one run amounts to, in the same shape from either formulation, and run.json made from it.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "model/scene.hpp"
#include "sim/formulation.hpp"

namespace freeplay {

/// Statistics of one contact after the discarded start.
struct ContactSummary {
  std::string name;
  ContactModel model;
  double flight_fraction = 0, impact_fraction = 0, lasting_fraction = 0;  ///< of the time
  long impacts = 0;                                                       ///< all
  long counted_impacts = 0;           ///< with an approach speed of at least a tenth of the fastest
  double impacts_per_revolution = 0;  ///< counted ones; per second when nothing turns at a prescribed speed
  double fastest_approach = 0;        ///< m/s
  double median_approach = 0;         ///< m/s, of all impacts
  double median_impulse = 0, greatest_impulse = 0;  ///< N s
  double penetration = 0;                           ///< m, greatest
  double penetration_ratio = 0;                     ///< of the clearance
};

struct RunSummary {
  std::string formulation;
  Ending ending;
  double t_end = 0;  ///< s, reached
  State final_state;
  double revolutions = 0;  ///< counted in the statistics; 0 without a drive of prescribed speed
  EnergyLedger ledger;
  Work work;
  Extremes extremes;
  std::vector<ContactSummary> contacts;
  std::vector<std::string> notes;
  std::vector<ContactEvent> events;  ///< the first Recorder::kept_events
  double wall_seconds = 0, cpu_seconds = 0;
  long peak_memory_kib = 0;
};

/// Fails an ending whose state or energies are not finite: such a result is refused, whatever made it.
void refuse_not_finite(const RunSummary& summary, Ending& ending);

RunSummary summarise(const Scene& scene, const System& system, const Formulation& formulation);

/// Sections of run.json.
nlohmann::json to_json(const RunSummary& summary);
/// Version, commit, scene text, overrides and options.
nlohmann::json provenance(const Scene& scene);

/// Makes a formulation of a scene; study/ gets it from cli/, which alone may know formulations.
using MakeFormulation =
    std::function<std::unique_ptr<Formulation>(const Scene&, const System&, const State&)>;

/// One run from start to end. With a folder it writes run.json, trajectory.csv, events.csv and signals.csv
/// there. Throws SceneError or OutputError; a numerical failure is in the summary's ending.
RunSummary run_scene(const Scene& scene, const MakeFormulation& make,
                     const std::optional<std::filesystem::path>& folder,
                     const std::function<void(double)>& on_progress = {});

}  // namespace freeplay
