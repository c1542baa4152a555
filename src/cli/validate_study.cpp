// freeplay validate STUDY: calibrates, executes missing runs, and compares the results with
// published findings.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

#include "cli/ending.hpp"
#include "cli/folders.hpp"
#include "cli/measured_rows.hpp"
#include "cli/terminal.hpp"
#include "cli/validate.hpp"
#include "io/files/build_identity.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/figure.hpp"
#include "study/calibration/calibration_documents.hpp"
#include "study/calibration/measured_points.hpp"
#include "study/settings/study.hpp"
#include "study/sweep/sweep.hpp"
#include "study/sweep/sweep_table.hpp"
#include "study/verdicts/verdicts.hpp"
#include "values/family.hpp"
#include "verification/experiment/flores2011.hpp"

namespace freeplay::cli {
namespace {

constexpr int all_cores = 0;

/// The scene of the fitted study at its optimum.
Variant calibrated_variant(const Study& study, const Study& fitted, const Fit& fit) {
  Variant v{"calibrated",       "Calibrated: " + fitted.title, fitted.scene, {}, family_names(),
            study.starts.count, study.length.revolutions};
  for (std::size_t i = 0; i < fitted.calibration->unknowns.size(); ++i)
    v.overrides.push_back(fmt::format("{}={}", fitted.calibration->unknowns[i].key, fit.unknowns[i].value));
  // The contact law must deliver the fitted restitution.
  v.overrides.push_back("penalty.contact=exact");
  return v;
}

// claims = "points": makes missing runs, and compares a quantity of each variant with measured values at
// single points of the axes.

/// A table for each quantity, with a row for each variant and formulation.
std::string table(const std::vector<MeasuredQuantity>& measured, const std::vector<PointAgreement>& all) {
  std::string out;
  for (const auto& m : measured) {
    out += fmt::format("{} ({} points)\n{:<30}{:<12}{:>10}{:>12}{:>14}\n", m.name, m.points.size(), "", "",
                       "rms error", "greatest", "outside 2u");
    for (const auto& a : all)
      if (a.quantity == m.name)
        out += fmt::format("{:<30}{:<12}{:>10.3g}{:>12.3g}{:>14}\n", a.variant, a.formulation, a.rms,
                           a.greatest, a.decided ? fmt::format("{}", a.outside) : "-");
    out += "\n";
  }
  return out;
}

/// A sentence for each variant and formulation.
std::string verdicts(const Study& study, const std::vector<PointAgreement>& all) {
  std::string out;
  for (const auto& v : study.variants)
    for (const auto& formulation : v.formulations) {
      std::string text;
      auto verdict = Agreement::Verdict::agrees;
      for (const auto& a : all) {
        if (a.variant != v.name || a.formulation != formulation) continue;
        // One undecided quantity leaves all undecided; otherwise one that differs is decisive.
        verdict = std::max(verdict, a.verdict());
        text += fmt::format("{}{}: ", text.empty() ? "" : "; ", a.quantity);
        if (a.decided) text += fmt::format("{} of {} points outside, ", a.outside, a.model.size());
        text += fmt::format("greatest error {:.3g} at {}", a.greatest, a.greatest_at);
      }
      out += fmt::format("{} [{}] {}{}: {}\n", v.title, formulation,
                         verdict == Agreement::Verdict::undecided ? "is " : "", text_of(verdict), text);
    }
  return out;
}

int validate_points(const ValidateRequest& request, const Study& study) {
  const auto measured = read_measured_points(study);
  const auto folder = result_folder(request.output, default_folder(study.file, ""));
  const auto planned = plan(study, request.conduct());
  if (request.stop()) return interrupted(Kept::nothing);
  ResultSet set(folder, "validate-points");
  Progress progress;
  Results results(folder / "sweep.db", study, request.stop);
  const auto summary = sweep(study, planned, request.conduct(), results, set.lock(), 0, progress.of_runs());
  progress.clear();
  if (summary.interrupted) return interrupted(Kept::runs);
  write_sweep_document(study, results, folder);
  const auto runs = results.runs();
  const auto all = agreement_with(study, measured, runs);
  fmt::print("{}{}\n", table(measured, all), wrapped(verdicts(study, all), 2));
  write_json(set.place() / "points.json", to_json(study, all), provenance(study));
  write_file(set.place() / "points.csv", points_table(study, all).csv());
  write_file(set.place() / "curves.csv", curves_table(study, measured, runs).csv());
  if (request.stop()) return interrupted(Kept::runs);
  set.commit();
  fmt::print("{} runs, {} made; results in {}\n", summary.total, summary.ran, folder.string());
  for (const auto& figure : plots::points.draw(folder)) fmt::print("  {}\n", figure.string());
  fmt::print("\n{}", wrapped(conclusion(study, all) + "\n", 0));
  // Rows without a model have a failed run.
  return std::ranges::all_of(all, [](const auto& a) { return std::isfinite(a.rms); }) ? 0 : 1;
}

}  // namespace

int validate_study(const ValidateRequest& request) {
  auto study = read_study(request.scene, request.reach);
  if (study.claims == "points") return validate_points(request, study);
  if (study.claims == "rows") return validate_rows(request, study);
  require_signal(study, "validate");
  if (study.claims != "flores2011")
    throw SceneError(
        fmt::format("{}: claims must be \"flores2011\", \"points\" or \"rows\"; for a measured signal use "
                    "`freeplay validate SCENE --data FILE`",
                    request.scene));
  if (study.axes.size() != 2)
    throw SceneError(
        fmt::format("{}: axes: claims = \"flores2011\" need two axes, clearance and speed", request.scene));
  if (!request.overrides.empty()) throw SceneError("validate: --set needs a scene with --data");
  const auto folder = result_folder(request.output, default_folder(study.file, ""));
  // Check that both studies can be run, before any run or change of results.
  auto planned = plan(study, request.conduct());
  const auto origin = provenance(study);
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
    write_json(set.place() / "calibration.json", to_json(*fitted, *fit), origin_of_fit);
  }
  Results results(folder / "sweep.db", study, request.stop);
  const auto summary =
      sweep(study, planned, request.conduct(), results, set.lock(), all_cores, progress.of_runs("matrix: "));
  progress.clear();
  if (summary.interrupted) return interrupted(Kept::runs);
  write_sweep_document(study, results, folder);
  const auto found = verification::all_findings(study, results, results.runs(), fitted ? &*fitted : nullptr);
  for (const auto& of : found) {
    fmt::print("{}, {}\n", of.title, of.formulation);
    for (const auto& f : of.findings)
      fmt::print("  {:<6}{:<4} {}\n             {}; bound: {}\n",
                 f.assessed ? f.holds ? "holds" : "FAILS"
                 : f.fitted ? "fitted"
                            : "-",
                 f.id, f.claim, f.measured, f.bound);
    fmt::print("\n");
  }
  write_json(set.place() / "experiment.json", verification::to_json(found), origin);
  write_tables(study, results, request.conduct(), set.place());
  const auto text = verification::experiment_document(study, results, fitted ? &*fitted : nullptr,
                                                      fit ? &*fit : nullptr, version_text());
  if (request.document.empty()) write_file(set.place() / "experiment.md", text);
  if (request.stop()) return interrupted(Kept::runs);
  if (!request.document.empty()) real_folder(request.document);  // refused before the results are replaced
  set.commit();
  write_page(request.document, folder, "validate", "experiment.md", text, plots::all(folder));
  fmt::print("{} runs, {} made in {:.0f} s; results in {}\n", summary.total, summary.ran,
             summary.wall_seconds, folder.string());
  const auto count = verification::count(found);
  fmt::print("\n{}", wrapped(verdict(count) + "\n", 0));
  return count.failing.empty() ? 0 : 1;
}

}  // namespace freeplay::cli
