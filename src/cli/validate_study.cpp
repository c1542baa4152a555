// freeplay validate STUDY: calibrates, executes missing runs, and compares the results with
// published findings.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/calibrate.hpp"
#include "cli/default_folder.hpp"
#include "cli/document.hpp"
#include "cli/ending.hpp"
#include "cli/progress.hpp"
#include "cli/validate.hpp"
#include "cli/wrapped.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/figure.hpp"
#include "study/settings/provenance.hpp"
#include "study/sweep/sweep_document.hpp"
#include "study/sweep/tables.hpp"
#include "study/verdicts/verdicts.hpp"
#include "values/family.hpp"
#include "verification/experiment/flores2011.hpp"
#include "version.hpp"

namespace freeplay::cli {
namespace {

constexpr int all_cores = 0;

/// The scene of the fitted study at its optimum.
Variant calibrated_variant(const Study& study, const Study& fitted, const Fit& fit) {
  Variant v{"calibrated",     "Calibrated: " + fitted.title, fitted.scene, {}, family_names(), study.starts,
            study.revolutions};
  for (std::size_t i = 0; i < fitted.calibration->unknowns.size(); ++i)
    v.overrides.push_back(fmt::format("{}={}", fitted.calibration->unknowns[i].key, fit.unknowns[i].value));
  // The contact law must deliver the fitted restitution.
  v.overrides.push_back("penalty.contact=exact");
  return v;
}

}  // namespace

int validate_study(const ValidateRequest& request) {
  auto study = read_study(request.scene, request.reach);
  if (study.claims == "points") return validate_points(request, study);
  require_signal(study, "validate");
  if (study.claims != "flores2011")
    throw SceneError(
        fmt::format("{}: claims must be \"flores2011\" or \"points\"; for a measured signal use `freeplay "
                    "validate SCENE --data FILE`",
                    request.scene));
  if (study.axes.size() != 2)
    throw SceneError(
        fmt::format("{}: axes: claims = \"flores2011\" need two axes, clearance and speed", request.scene));
  if (!request.overrides.empty()) throw SceneError("validate: --set needs a scene with --data");
  const auto folder = result_folder(request.output, default_folder(study.file, ""));
  // Check that both studies can be run, before any run or change of results.
  auto planned = plan(study, request.conduct());
  nlohmann::json document;
  document["provenance"] = provenance(study);
  std::optional<Study> fitted;
  std::optional<CalibrationPlan> planned_fit;
  nlohmann::json origin_of_fit;
  if (!study.fit.empty()) {
    fitted = read_study(study.fit, request.reach);
    origin_of_fit = provenance(*fitted);
    planned_fit = plan_calibration(*fitted, request.conduct());
  }
  if (request.stop()) return interrupted(Kept::nothing);
  ResultSet set(folder, "validate-study");
  Progress progress;
  std::optional<CalibrationResult> fit;
  if (planned_fit) {
    fit = calibrate(std::move(*planned_fit), request.conduct(), set.lock(), all_cores,
                    progress.of_runs("calibration: "));
    progress.clear();
    if (fit->sweep.interrupted) return interrupted(Kept::runs);
    study.variants.push_back(calibrated_variant(study, *fitted, fit->all));
    planned = plan(study, request.conduct());
    write_json(set.place() / "calibration.json", to_json(*fitted, *fit, origin_of_fit));
  }
  Results results(folder / "sweep.db", study, request.stop);
  const auto summary =
      sweep(study, planned, request.conduct(), results, set.lock(), all_cores, progress.of_runs("matrix: "));
  progress.clear();
  if (summary.interrupted) return interrupted(Kept::runs);
  write_sweep_document(study, results, folder);
  const auto runs = results.runs();
  FindingCount count;
  for (const auto& v : study.variants)
    for (const auto& formulation : v.formulations) {
      fmt::print("{}, {}\n", v.title, formulation);
      for (const auto& f :
           verification::flores2011(study, results, runs, v.name, formulation, TurnMetrics::ratio_95,
                                    verification::fitted_findings(v.name, fitted ? &*fitted : nullptr))) {
        fmt::print("  {:<6}{:<4} {}\n             {}; bound: {}\n",
                   f.assessed ? f.holds ? "holds" : "FAILS"
                   : f.fitted ? "fitted"
                              : "-",
                   f.id, f.claim, f.measured, f.bound);
        document["verdicts"][v.name][formulation].push_back({{"id", f.id},
                                                             {"claim", f.claim},
                                                             {"measured", f.measured},
                                                             {"bound", f.bound},
                                                             {"judged", f.assessed},
                                                             {"fitted", f.fitted},
                                                             {"holds", f.holds}});
        count.assessed += f.assessed;
        count.holding += f.assessed && f.holds;
        if (f.assessed && !f.holds)
          count.failing.push_back(fmt::format("{} in {}, {}", f.id, v.name, formulation));
      }
      fmt::print("\n");
    }
  const auto conclusion = verdict(count);
  document["verdict"] = conclusion;
  write_json(set.place() / "experiment.json", document);
  write_tables(study, results, request.conduct(), set.place());
  const auto text =
      verification::experiment_document(study, results, fitted ? &*fitted : nullptr, fit ? &*fit : nullptr,
                                        fmt::format("{} ({})", version, commit));
  const auto place = request.document.empty() ? std::filesystem::path() : real_folder(request.document);
  if (place.empty()) write_file(set.place() / "experiment.md", text);
  if (request.stop()) return interrupted(Kept::runs);
  set.commit();
  const auto figures = plots::all(folder);
  if (!place.empty()) {
    const auto lock = lock_document(place, folder, "validate");
    write_file(place / "experiment.md", text);
    copy_figures(figures, place);
  }
  fmt::print("{} runs, {} made in {:.0f} s; results in {}\n", summary.total, summary.ran,
             summary.wall_seconds, folder.string());
  fmt::print("\n{}", wrapped(conclusion + "\n", 0));
  return count.failing.empty() ? 0 : 1;
}

}  // namespace freeplay::cli
