// One run of a scene that records the points of a Poincaré section in memory
// (simulation/section.hpp).
//
// Use: construct a SectionSimulation, which resolves the request and assembles the start; inspect
// plan(); then call run() once, or have it run with others (study/runs/executor.hpp). It owns the
// simulation.
#pragma once

#include <array>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "facade/simulation.hpp"
#include "io/scene/read_section.hpp"
#include "simulation/section.hpp"
#include "study/runs/executor.hpp"
#include "values/table.hpp"

namespace freeplay {

/// Specification of a section run.
struct SectionRequest {
  std::string formulation = "nonsmooth";
  std::string section;                    ///< text of the section (io/scene/read_section.hpp)
  std::vector<std::string> columns = {};  ///< names of columns; empty: all
  std::optional<double> period = {};      ///< s, instead of the drive's period
  /// Periods that are discarded, and periods that are evaluated after them. Without a period, the
  /// scene's run.discard and run.duration apply.
  std::optional<double> discard = {}, keep = {};
  std::optional<State> start = {};  ///< instead of that of run.start
  /// Keys or options to name in errors about the section, a column and the number of periods.
  std::string section_key = "section", column_key = "column", periods_key = "keep";
};

/// A request resolved for a scene.
struct SectionPlan {
  SectionRule rule;
  std::vector<NamedColumn> columns;
  std::vector<std::string> shown;  ///< default columns of a figure
  double period = 0;               ///< s; 0: none
  double discard = 0, until = 0;   ///< s
};

/// The section points of a run.
struct SectionRun {
  SectionPlan plan;
  Ending ending;
  std::vector<double> t, rows;  ///< times (s); rows of columns, one row for each point
  State end;                    ///< state at the end of the run
  Work work;
  double cpu_seconds = 0;
  std::vector<std::string> notes;

  std::size_t size() const { return t.size(); }
  double at(std::size_t point, std::size_t column) const {
    return rows[point * plan.columns.size() + column];
  }
};

/// section.json, without provenance. `shown`: columns x and y of the figure; empty: those of the plan.
nlohmann::json to_json(const SectionRun& run, const SectionRequest& request,
                       const std::array<std::string, 2>& shown);
/// section.csv.
Table section_table(const SectionRun& run);

/// A section run that is ready to start. Throws SceneError if the scene cannot be run or does not
/// suit the request, and Interrupted on a stop request during assembly.
class SectionSimulation : public StudyRun {
 public:
  /// `compilation`: of its study; null: it is alone.
  SectionSimulation(const Scene& scene, const SectionRequest& request, StopToken stop,
                    SharedCompilation* compilation = nullptr);
  const SectionPlan& plan() const { return plan_; }
  /// Identity of the run. It does not include the section.
  Identity identity() const { return simulation_.identity(); }
  /// Runs the simulation and returns the section points. Call once.
  SectionRun run();

  Simulation& simulation() override { return simulation_; }
  RunRequest request() override;
  double next_shown() const override { return points_->next(); }
  std::vector<Observer*> followers() const override;
  bool take(Result result) override;
  /// The run after its end.
  SectionRun& made() { return run_; }

 private:
  StopToken stop_;
  Simulation simulation_;
  SectionPlan plan_;
  std::unique_ptr<SectionPoints> points_;
  SectionRun run_;
};

}  // namespace freeplay
