#include "study/comparison/drift.hpp"

#include <ctime>
#include <nlohmann/json.hpp>

#include "dynamics/system.hpp"
#include "facade/simulation.hpp"
#include "io/files/output_file.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/scene.hpp"
#include "simulation/residuals.hpp"
#include "values/table.hpp"

namespace freeplay {

std::vector<DriftRun> measure_drift(const Scene& scene, const StopToken& stop,
                                    const std::filesystem::path& folder,
                                    const std::function<void(const std::string&, double)>& on_progress) {
  constexpr int points = 200;
  const System system(scene.mechanism);
  std::vector<DriftRun> runs;
  Table rows("stabilisation,t,length,angle,closure");
  nlohmann::json summary = nlohmann::json::object();
  for (const auto& kind : choices(Stabilisation{})) {
    const std::string name(kind.text);
    Scene one = scene;
    one.penalty.stabilisation = kind.value;
    if (choice_of(one.penalty.integrator).traits.keeps_history) one.penalty.integrator = Integrator::dopri5;
    auto simulation = located_in(scene, [&] { return Simulation(one, "penalty", {.stop = stop}); });
    Result made;
    auto e = system.make_evaluation();
    DriftRun run;
    run.stabilisation = name;
    const auto cpu = std::clock();
    for (int i = 1; i <= points && run.ending.status == Ending::Status::finished; ++i) {
      made = simulation.run({.until = scene.run.duration * i / points, .keep_events = false, .stop = stop});
      run.ending = made.ending;
      const auto& state = made.final_state;
      system.place(state.t, state.q.data(), e);
      Extremes now;
      keep_residuals(system, e, now);
      rows.row(name, state.t, now.constraint_length, now.constraint_angle, made.ledger.closure());
      if (on_progress) on_progress(name, static_cast<double>(i) / points);
    }
    run.cpu_seconds = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
    run.greatest_length = made.extremes.constraint_length;
    run.greatest_angle = made.extremes.constraint_angle;
    run.closure = made.ledger.closure();
    run.stabilisation_work = made.ledger.stabilisation;
    run.rhs = made.work.rhs;
    summary[name] = {{"greatest_length_m", run.greatest_length},
                     {"greatest_angle_rad", run.greatest_angle},
                     {"closure_J", run.closure},
                     {"work_of_stabilisation_J", run.stabilisation_work},
                     {"right_hand_sides", run.rhs},
                     {"cpu_s", run.cpu_seconds}};
    runs.push_back(run);
    if (stop()) return runs;
  }
  make_folder(folder);
  write_file(folder / "drift.csv", rows.csv());
  write_json(folder / "drift.json", {{"runs", summary}}, provenance(scene));
  return runs;
}

}  // namespace freeplay
