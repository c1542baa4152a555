// One run and its section points, in memory.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "facade/simulation.hpp"
#include "io/scene/read_section.hpp"

namespace freeplay {

struct SectionRequest {
  std::string formulation = "nonsmooth";
  std::string section;                    ///< as people write it (io/scene/read_section.hpp)
  std::vector<std::string> columns = {};  ///< likewise; none: all
  std::optional<double> period = {};      ///< s, in place of the drive's
  /// Periods before the points that are kept, and with them; without a period the scene's run.discard and run.duration.
  std::optional<double> discard = {}, keep = {};
  std::optional<State> start = {};  ///< in place of what run.start asks for
  /// Whom to blame for a section, a column and a number of periods: keys or options.
  std::string section_key = "section", column_key = "column", periods_key = "keep";
};

struct SectionPlan {
  SectionRule rule;
  std::vector<NamedColumn> columns;
  std::vector<std::string> shown;  ///< columns that a figure takes where nobody says
  double period = 0;               ///< s, 0: none
  double discard = 0, until = 0;   ///< s
};

struct SectionRun {
  SectionPlan plan;
  Ending ending;
  std::vector<double> t, rows;  ///< s; a row of the columns for each point
  State end;                    ///< where the run ended
  Work work;
  double cpu_seconds = 0;
  std::vector<std::string> notes;

  std::size_t size() const { return t.size(); }
  double at(std::size_t point, std::size_t column) const {
    return rows[point * plan.columns.size() + column];
  }
};

/// Ready to run. Throws SceneError for a scene that cannot be run, or that the request does not suit; Interrupted while the
/// start is made.
class SectionSimulation {
 public:
  SectionSimulation(const Scene& scene, const SectionRequest& request, StopToken stop);
  const SectionPlan& plan() const { return plan_; }
  /// Of the run; what is looked at in it stands beside that.
  Identity identity() const { return simulation_.identity(); }
  /// The state at the points, and nothing else kept; once.
  SectionRun run();

 private:
  StopToken stop_;
  Simulation simulation_;
  SectionPlan plan_;
};

}  // namespace freeplay
