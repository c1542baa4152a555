// freeplay calibrate: fits unknowns to measured statistics, and predicts each statistic from the
// others; or fits them to quantities of one run.
#include "study/calibration/calibrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/calibrate_series.hpp"
#include "cli/cluster/shards.hpp"
#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/figures.hpp"
#include "cli/folders.hpp"
#include "cli/measured_rows.hpp"
#include "cli/terminal.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "study/calibration/calibration_documents.hpp"
#include "study/calibration/quantity_fit.hpp"
#include "study/calibration/series_fit.hpp"
#include "study/partition/divided.hpp"
#include "study/settings/study.hpp"

namespace freeplay::cli {
namespace {

std::string show(const Estimate& e) {
  if (!std::isfinite(e.low)) return fmt::format("{:.4g} (one start: no interval)", e.value);
  return fmt::format("{:.4g} ({:.4g}..{:.4g})", e.value, e.low, e.high);
}

/// Text of an unknown's value and interval; states whether it is open at a limit of the range.
std::string show_unknown(const Estimate& e, const std::string& name, bool decided) {
  const auto unit = name.empty() ? "" : " " + name;
  if (!std::isfinite(e.low))
    return fmt::format("{:.4g}{}, no interval: the fit is {}", e.value, unit, decided ? "rejected" : "open");
  if (e.open_low && e.open_high)
    return fmt::format("{:.4g}{}, open: no part of its range is excluded", e.value, unit);
  return show(e) + unit +
         (e.open_low    ? ", open below: the lower end of the range is not excluded"
          : e.open_high ? ", open above: the upper end of the range is not excluded"
                        : "");
}

/// Prints how well the targets determine each unknown, before the fit.
void print_identifiability(const Calibration& c, const CalibrationResult& r) {
  fmt::print("Identifiability (sensitivity over the whole range, in standard uncertainties)\n");
  for (std::size_t j = 0; j < c.unknowns.size(); ++j) {
    const auto column = r.before.sensitivity.col(static_cast<Eigen::Index>(j));
    Eigen::Index most = 0;
    column.maxCoeff(&most);
    fmt::print("  {:<16} {}; {:.0f} % of its range remains;\n{:19}most sensitive: {} ({:.2g})\n",
               c.unknowns[j].name, r.before.identified(j) ? "identified" : "NOT IDENTIFIED by these targets",
               100 * r.before.left_open[j], "", c.targets[static_cast<std::size_t>(most)].name,
               2 * column[most]);
  }
  for (std::size_t j = 0; j < c.unknowns.size(); ++j)
    for (std::size_t k = 0; k < j; ++k)
      if (const double x = r.before.correlation(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k));
          std::abs(x) > 0.9)
        fmt::print("  {} and {} correlate by {:.2f}: the targets determine mainly one combination of them\n",
                   c.unknowns[k].name, c.unknowns[j].name, x);
}

/// Calibrates a study whose targets are quantities of one run; writes calibration.json into the folder
/// and prints a summary. `origin`: provenance of the study. Returns the exit status: 1 if the fit is
/// rejected.
int calibrate_quantities(const Study& study, const std::filesystem::path& folder,
                         const nlohmann::json& origin, const StopToken& stop) try {
  const auto& c = *study.calibration;
  Progress progress;
  const auto f = fit_quantities(
      study, stop, [&](int runs) { progress.show(fmt::format("{} runs with derivatives", runs)); });
  progress.clear();
  make_folder(folder);
  const FolderLock lock(folder, "calibrate");
  settle_result_sets(folder);
  write_json(folder / "calibration.json", to_json(study, f), origin);
  fmt::print("{} runs with derivatives, {} iterations\n", f.runs, f.iterations);
  fmt::print("\nUnknowns (95 % interval)\n");
  for (std::size_t k = 0; k < c.unknowns.size(); ++k)
    fmt::print("  {:<16} {}{}\n", c.unknowns[k].name, value_text(c.unknowns[k], f.unknowns[k], 8),
               f.at_bound(k) ? ", AT ITS BOUND" : "");
  for (const bool used : {true, false}) {
    if (std::ranges::none_of(f.targets, [&](const auto& t) { return t.used == used; })) continue;
    fmt::print("\n{}\n  {:<16} {:>14} {:>14} {:>10} {:>10}\n",
               used ? "Fitted" : "Predicted: beyond the horizon", "target", "measured", "model", "residual",
               "deviation");
    for (std::size_t i = 0; i < c.targets.size(); ++i)
      if (const auto& t = f.targets[i]; t.used == used)
        fmt::print("  {:<16} {:>14.8g} {:>14.8g} {:>10.2g} {:>10.2g}\n", c.targets[i].name,
                   c.targets[i].value, t.value, (t.value - c.targets[i].value) / t.deviation,
                   used ? t.deviation : t.model_deviation);
  }
  fmt::print("residual: in standard deviations of the measurement\n");
  if (f.beyond)
    fmt::print("{}", wrapped(fmt::format("note: {} does not determine later events to a quarter of the time "
                                         "between them; later targets are predicted\n",
                                         f.horizon > 0 ? fmt::format("the fit to contact event {}", f.horizon)
                                                       : std::string("the fit")),
                             6));
  fmt::print("\nresults in {}\n\n", folder.string());
  fmt::print(f.holds() ? stdout : stderr, "{}", wrapped(conclusion(study, f) + "\n", 0));
  return f.holds() ? 0 : 1;
} catch (const Interrupted&) {
  return interrupted(Kept::nothing);
}

int calibrate(const StudyRequest& request) {
  const auto study = read_study(request.study, request.reach);
  if (study.rows) return calibrate_rows(request, study);
  const bool quantities = study.calibration && fits_quantities(*study.calibration);
  const bool series = study.calibration && fits_series(*study.calibration);
  if (!quantities && !series) require_signal(study, "calibrate");
  const auto folder = result_folder(request.output, default_folder(study.file, ""));
  const auto origin = provenance(study);  // reads all named files
  if (quantities && !request.shards.requested())
    return calibrate_quantities(study, folder, origin, request.stop);
  if (series && !request.shards.requested())
    return calibrate_series(study, folder, origin, request.threads, request.stop);
  auto plan = plan_calibration(study, request.conduct());
  if (request.stop()) return interrupted(Kept::nothing);
  // The points; fits follow after the merge, by the verb without these options.
  if (request.shards.requested())
    return in_shards(divided_sweep(plan.study, request.conduct(), "calibrate",
                                   study_arguments(request.study, request.reach), subject_of(study)),
                     request.shards, folder, request.threads, request.stop);
  make_folder(folder);
  const FolderLock lock(folder, "calibrate");
  settle_result_sets(folder);
  Progress progress;
  const auto r =
      freeplay::calibrate(std::move(plan), request.conduct(), lock, request.threads, progress.of_runs());
  progress.clear();
  for (const auto& q : r.plausibility_checks) fmt::print(stderr, "{}", wrapped("question: " + q + "\n", 10));
  if (r.sweep.interrupted) return interrupted(Kept::runs);
  const auto& c = *study.calibration;
  fmt::print("{} new runs in {:.0f} s, {} failed\n\n", r.sweep.ran, r.sweep.wall_seconds, r.sweep.failed);
  print_identifiability(c, r);
  fmt::print("\nResponse surfaces (of the logarithm), including {} points of {} refinements\n",
             r.tried - c.points, r.rounds);
  for (std::size_t i = 0; i < c.targets.size(); ++i)
    fmt::print(
        "  {:<10} {:<16} error {:.3f}, spread of outcomes {:.3f}{}\n{:29}error at the optimum {:.3f}, "
        "measurement uncertainty {:.3f}\n",
        c.targets[i].name, c.targets[i].statistic, r.surface_error[i], r.surface_spread[i],
        r.points[i] < r.tried ? fmt::format("; {} of {} points", r.points[i], r.tried) : "", "",
        std::sqrt(r.at_optimum[i].surface), std::hypot(r.tolerance[i], std::sqrt(r.at_optimum[i].scatter)));
  if (!r.refined)
    fmt::print("{}",
               wrapped("note: the error of a surface exceeds half the measurement uncertainty and widens "
                       "the intervals; increase calibrate.refinements or calibrate.starts\n"));
  const auto fit = [&](const Fit& f, const std::string& title) {
    fmt::print("\n{}\n", title);
    for (std::size_t j = 0; j < c.unknowns.size(); ++j)
      fmt::print("  {:<16} {}{}\n", c.unknowns[j].name,
                 show_unknown(f.unknowns[j], c.unknowns[j].unit, f.settled || f.rejected),
                 f.at_bound(j) ? ", AT ITS BOUND" : "");
    if (f.rejected)
      fmt::print(
          "  NOT MET: the targets deviate by more than their uncertainties\n           (chi-squared "
          "{:.1f}, {} degrees of freedom)\n",
          f.squares, f.degrees);
    for (std::size_t i = 0; i < c.targets.size(); ++i)
      if (f.contradicted[i])
        fmt::print("  {}: REJECTED: simulations at the optimum disagree with the surrogate\n",
                   c.targets[i].name);
    for (const bool used : {true, false})
      for (std::size_t i = 0; i < c.targets.size(); ++i)
        if (f.used[i] == used)
          fmt::print("  {:<10} {:<10} measured {:<8.4g} surface   {}\n{:34}runs      {}\n{:34}uncertain {}\n",
                     c.targets[i].name, used ? "fitted" : "PREDICTED", r.measured[i], show(f.on_surface[i]),
                     "", show(f.run_again[i]), "", show(f.predictive[i]));
  };
  fit(r.all, "Fitted to all");
  for (std::size_t i = 0; i < r.left_out.size(); ++i) fit(r.left_out[i], "Without " + c.targets[i].name);
  write_file(folder / "calibration.csv", outcomes_table(study, r).csv());
  write_file(folder / "misfit.csv", misfit_table(study, r).csv());
  write_json(folder / "calibration.json", to_json(study, r), origin);
  fmt::print("\n");
  draw_results(folder, Undrawn::is_error, request.stop);
  const bool holds = r.all.holds();
  fmt::print(holds ? stdout : stderr, "\n{}", wrapped(conclusion(study, r) + "\n", 0));
  return holds ? 0 : 1;
}

}  // namespace

void calibrate_verb(Program& program) {
  auto [options, request] =
      program.verb("calibrate", "fit unknown parameters of a study to measured statistics", calibrate);
  declare_study(options, request, "study file with [calibrate] or [rows]", "result folder; default out/NAME");
}

}  // namespace freeplay::cli
