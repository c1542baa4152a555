// freeplay compare: solves a scene in both formulations and compares them.
#include "study/comparison/compare.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/result_set.hpp"
#include "io/scene/read_scene.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/style.hpp"

namespace freeplay::cli {
namespace {

struct CompareRequest : Request {
  Reach reach = Reach::beside;  ///< permitted files of the scene
  std::string scene;
  std::vector<std::string> overrides;
  bool as_given = false;  ///< the impact law takes the surfaces' restitution unchanged
  bool forces = false;    ///< write forces.csv too
  std::string accuracy;   ///< fast, balanced or reference; empty: the scene's own settings
  std::string output;     ///< result folder
  std::string style;      ///< of the figures, preset or file
  double most_output = default_output_limit / 1e9;  ///< GB
};

int compare(const CompareRequest& request) {
  auto overrides = with_accuracy(request.accuracy, {Family::penalty, Family::nonsmooth}, request.overrides);
  if (request.forces) overrides.push_back("run.forces=true");
  const auto scene = open_scene(request.scene, overrides, request.reach == Reach::anywhere);
  const auto folder = result_folder(request.output, default_folder(request.scene, ""));
  if (!request.style.empty()) plots::choose_style(request.style);
  plots::style_of(folder, request.scene);  // reports an invalid style before the runs
  ResultSet set(folder, "compare");
  Progress progress;
  CompareSetup setup;
  setup.matched = !request.as_given;
  setup.stop = request.stop;
  setup.most_output = 1e9 * request.most_output;
  setup.on_progress = [&](const std::string& which, double done) { progress.show(which, done); };
  const auto comparison = freeplay::compare(*scene, setup, set.place());
  progress.clear();
  int status = report(comparison.penalty);
  if (comparison.penalty.ending.status != Ending::Status::interrupted) status |= report(comparison.nonsmooth);
  if (request.stop()) return 1;
  set.commit();

  if (const auto& assumed = comparison.penalty.assumed; !assumed.empty())
    fmt::print("{}", wrapped("start: " + assumed + "\n", 7));
  fmt::print("{}\n", wrapped(comparison_table(*scene, comparison, false)));
  say_undetermined(comparison.penalty);
  fmt::print("{}\nresults in {}\n", wrapped(comparison.verdict + "\n", 0), folder.string());
  std::fflush(stdout);
  const auto figures = plots::all(folder);
  if (!figures.empty()) fmt::print("figures:\n");
  for (const auto& path : figures) fmt::print("  {}\n", path.string());
  return status;
}

}  // namespace

void compare_verb(Program& program) {
  auto [options, request] =
      program.verb("compare", "solve a scene in both formulations and compare them", compare);
  options.scene(request.scene).required();
  options.set(request.overrides);
  options.allow_outside(request.reach);
  options.flag("--as-given", request.as_given, "use the input restitution in the impact law, unmatched");
  options.flag("--forces", request.forces, "also write forces.csv and draw its figures");
  options.accuracy(request.accuracy);
  options.output(request.output, "result folder; default out/NAME");
  options.style(request.style);
  options.limit_output(request.most_output);
}

}  // namespace freeplay::cli
