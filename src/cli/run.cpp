#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "cli/commands.hpp"
#include "cli/default_folder.hpp"
#include "cli/progress.hpp"
#include "cli/wrapped.hpp"
#include "freeplay.hpp"
#include "plots/figure.hpp"
#include "study/compare.hpp"
#include "study/drift.hpp"
#include "study/settings.hpp"

namespace freeplay::cli {
namespace {

/// The overrides, those of --accuracy first, so that --set still wins.
std::vector<std::string> with_accuracy(const Request& request, const std::vector<std::string>& formulations) {
  std::vector<std::string> list;
  if (!request.accuracy.empty()) {
    const auto level = request.accuracy == "fast"       ? Accuracy::fast
                       : request.accuracy == "balanced" ? Accuracy::balanced
                                                        : Accuracy::reference;
    for (const auto& formulation : formulations)
      for (const auto& key : setting_for(formulation, level).keys()) list.push_back(key);
  }
  list.insert(list.end(), request.overrides.begin(), request.overrides.end());
  return list;
}

/// Which reactions mechanics leaves open.
void say_undetermined(const Result& r) {
  if (r.undetermined.empty()) return;
  fmt::print(
      "{}", wrapped(fmt::format("note: mechanics does not determine the reactions of {} (rows depend on each "
                                "other): those in forces.csv are of least norm\n",
                                fmt::join(r.undetermined, ", "))));
}

/// 0 for a finished run; else says on stderr why it ended.
int report(const Result& summary) {
  if (summary.ending.status == Ending::Status::finished) return 0;
  if (summary.ending.status == Ending::Status::failed)
    fmt::print(stderr, "{}: stopped: {}\n", summary.formulation, summary.ending.reason);
  else
    fmt::print(stderr, "{}: interrupted at t = {:.9g} s\n", summary.formulation, summary.t_end);
  return 1;
}

}  // namespace

int run(const Request& request) {
  if (request.resume.empty() == request.scene.empty())
    throw SceneError(request.scene.empty() ? "run needs a scene, or --resume FOLDER"
                                           : "--resume takes the scene from its folder; give one of both");
  RunPlan plan;
  plan.stop = request.stop;
  plan.checkpoint = request.checkpoint;
  Progress progress;
  Result summary;
  if (!request.resume.empty()) {
    if (!request.formulation.empty() || !request.overrides.empty() || !request.accuracy.empty() ||
        !request.output.empty() || request.forces)
      throw SceneError("--resume goes on as the run was begun: it takes no other option but --checkpoint");
    plan.folder = request.resume;
    plan.on_progress = [&](double done) { progress.show("resumed", done); };
    summary = resume_run(request.resume, plan);
  } else {
    if (request.formulation.empty()) throw SceneError("--formulation is required: penalty or nonsmooth");
    auto overrides = with_accuracy(request, {request.formulation});
    if (request.forces) overrides.push_back("run.forces=true");
    const Scene scene = read_scene(request.scene, overrides);
    plan.formulation = request.formulation;
    plan.folder = request.output.empty() ? default_folder(scene.file, "-" + request.formulation)
                                         : std::filesystem::path(request.output);
    plan.on_progress = [&](double done) { progress.show(request.formulation, done); };
    summary = run_scene(scene, plan);
  }
  progress.clear();
  fmt::print("{}: {:.6g} s in {} steps, {} right-hand sides, {:.3g} s CPU\n", summary.formulation,
             summary.t_end, summary.work.steps, summary.work.rhs, summary.cpu_seconds);
  for (const auto& c : summary.contacts)
    fmt::print(
        "{}: flight {:.2f} %, impacts {:.2f} %, lasting contact {:.2f} %; {} impacts;\n"
        "  restitution asked {:.4g}, delivered {:.4g};\n"
        "  greatest penetration {:.3g} of the clearance\n",
        c.name, 100 * c.flight_fraction, 100 * c.impact_fraction, 100 * c.lasting_fraction, c.impacts,
        c.model.restitution_asked, c.model.restitution_delivered, c.penetration_ratio);
  if (std::isfinite(summary.ledger.closure()))
    fmt::print("energy balance closes to {:.2g} J of {:.3g} J\n", summary.ledger.closure(),
               summary.ledger.scale());
  for (const auto& note : summary.notes) fmt::print("{}", wrapped("note: " + note + "\n"));
  say_undetermined(summary);
  fmt::print("results in {}\n", plan.folder->string());
  if (summary.ending.status == Ending::Status::interrupted && has_checkpoint(*plan.folder))
    fmt::print("go on with: freeplay run --resume {}\n", plan.folder->string());
  return report(summary);
}

int compare(const Request& request) {
  auto overrides = with_accuracy(request, {"penalty", "nonsmooth"});
  if (request.forces) overrides.push_back("run.forces=true");
  const Scene scene = read_scene(request.scene, overrides);
  const std::filesystem::path folder =
      request.output.empty() ? default_folder(scene.file, "") : std::filesystem::path(request.output);
  Progress progress;
  CompareSetup setup;
  setup.matched = !request.as_given;
  setup.stop = request.stop;
  setup.on_progress = [&](const std::string& which, double done) { progress.show(which, done); };
  const auto comparison = freeplay::compare(scene, setup, folder);
  progress.clear();
  int status = report(comparison.penalty);
  if (comparison.penalty.ending.status != Ending::Status::interrupted) status |= report(comparison.nonsmooth);
  if (request.stop()) return 1;

  fmt::print("{}\n", wrapped(comparison_table(scene, comparison, false)));
  say_undetermined(comparison.penalty);
  fmt::print("results in {}\nfigures:\n", folder.string());
  for (const auto& path : plots::all(folder)) fmt::print("  {}\n", path.string());
  return status;
}

int drift(const Request& request) {
  const Scene scene = read_scene(request.scene, request.overrides);
  const auto folder =
      request.output.empty() ? default_folder(scene.file, "-drift") : std::filesystem::path(request.output);
  Progress progress;
  const auto runs = measure_drift(scene, request.stop, folder,
                                  [&](const std::string& which, double done) { progress.show(which, done); });
  progress.clear();
  if (request.stop()) return 1;
  fmt::print("{:<12}{:>14}{:>14}{:>14}{:>12}{:>10}\n", "", "greatest m", "greatest rad", "closure J", "rhs",
             "CPU s");
  int status = 0;
  for (const auto& r : runs) {
    fmt::print("{:<12}{:>14.2g}{:>14.2g}{:>14.2g}{:>12}{:>10.3g}\n", r.stabilisation, r.greatest_length,
               r.greatest_angle, r.closure, r.rhs, r.cpu_seconds);
    if (r.ending.status == Ending::Status::failed) {
      fmt::print(stderr, "{}: stopped: {}\n", r.stabilisation, r.ending.reason);
      status = 1;
    }
  }
  fmt::print("results in {}\nfigures:\n", folder.string());
  for (const auto& path : plots::all(folder)) fmt::print("  {}\n", path.string());
  return status;
}

int figures(const Request& request) {
  const std::filesystem::path folder = request.scene;
  const auto made = plots::all(folder);
  if (made.empty())
    throw SceneError(request.scene +
                     ": has no result files to draw; give a folder made by freeplay run, compare, laws, "
                     "drift or validate");
  for (const auto& path : made) fmt::print("{}\n", path.string());
  return 0;
}

}  // namespace freeplay::cli
