// freeplay poincare: the state of a scene at the points of a Poincaré section.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/figures.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "mechanism/scene.hpp"
#include "study/runs/section_run.hpp"
#include "values/family.hpp"
#include "values/warning.hpp"

namespace freeplay::cli {
namespace {

struct PoincareRequest : Request {
  std::string scene, formulation = "nonsmooth";
  std::vector<std::string> overrides;
  std::string section = "every period";
  std::string x, y;  ///< columns of the figure
  std::optional<double> periods, discard;
  std::string output;  ///< result folder
};

int poincare(const PoincareRequest& request) {
  const auto scene = read_scene(request.scene, request.overrides);
  SectionRequest requested{.formulation = request.formulation,
                           .section = request.section,
                           .discard = request.discard,
                           .keep = request.periods,
                           .section_key = "--section",
                           .periods_key = request.periods ? "--periods" : "--discard"};
  if (request.discard && !request.periods)
    throw SceneError(
        "--discard counts discarded periods before those of --periods: give both, or run.discard in s");
  // Columns that do not exist are refused before anything is run.
  SectionSimulation simulation(scene, requested, request.stop);
  for (const auto* column : {&request.x, &request.y})
    if (!column->empty()) {
      auto one = requested;
      one.columns = {*column};
      one.column_key = column == &request.x ? "--x" : "--y";
      const SectionSimulation refused(scene, one, request.stop);
    }
  const auto folder = result_folder(request.output, default_folder(scene.file, "-poincare"));
  ResultSet set(folder, "poincare");
  const auto identity = simulation.identity();
  Progress progress;
  progress.show(request.formulation, 0);
  const auto run = simulation.run();
  progress.clear();
  if (run.ending.status == Ending::Status::interrupted) return interrupted(Kept::nothing);
  write_json(set.place() / "section.json", to_json(run, requested, {request.x, request.y}),
             provenance(scene, identity));
  write_file(set.place() / "section.csv", section_table(run).csv());
  set.commit();
  fmt::print("{}: {} points of \"{}\" from {:.6g} s to {:.6g} s\n", request.formulation, run.size(),
             request.section, run.plan.discard, run.plan.until);
  for (const auto& note : run.notes)
    fmt::print("{}", wrapped((is_warning(note) ? "" : "note: ") + note + "\n"));
  draw_results(folder, Undrawn::is_error);
  if (run.ending.status == Ending::Status::finished) return 0;
  fmt::print(stderr, "{}: stopped: {}\n", request.formulation, run.ending.reason);
  return 1;
}

}  // namespace

void poincare_verb(Program& program) {
  auto [options, request] =
      program.verb("poincare", "record the state of a scene on a Poincaré section", poincare);
  options.scene(request.scene).required();
  options.formulation(request.formulation);
  options.set(request.overrides);
  options
      .add("--section", request.section,
           "\"every period\", \"every 0.1 s\", \"pin.angle crosses 30 deg upwards\" or \"each touch of "
           "pin\" (contact onset)")
      .shows_default();
  options.add("--x", request.x, "abscissa of the figure, for example ball.y, pin.angle or phase")
      .takes("COLUMN");
  options.add("--y", request.y, "ordinate of the figure").takes("COLUMN");
  options.add("--periods", request.periods, "recorded periods of the drive; default the scene's duration")
      .number([](double x) { return x > 0; }, "must be greater than 0");
  options.add("--discard", request.discard, "discarded periods before those")
      .number([](double x) { return x >= 0; }, "must be 0 or greater");
  options.output(request.output, "result folder; default out/NAME-poincare");
}

}  // namespace freeplay::cli
