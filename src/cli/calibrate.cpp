// freeplay calibrate: unknowns fitted to measured statistics, and each statistic predicted from the others.
#include "study/calibrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "cli/calibrate.hpp"
#include "cli/default_folder.hpp"
#include "cli/ending.hpp"
#include "cli/progress.hpp"
#include "cli/shards.hpp"
#include "cli/verb.hpp"
#include "cli/wrapped.hpp"
#include "io/output_file.hpp"
#include "io/result_set.hpp"
#include "io/run_json.hpp"
#include "study/divided_sweep.hpp"
#include "study/provenance.hpp"

namespace freeplay::cli {
namespace {

std::string show(const Estimate& e) {
  if (!std::isfinite(e.low)) return fmt::format("{:.4g} (one start: no interval)", e.value);
  return fmt::format("{:.4g} ({:.4g}..{:.4g})", e.value, e.low, e.high);
}

nlohmann::json json_of(const Estimate& e) { return {{"value", e.value}, {"low", e.low}, {"high", e.high}}; }

nlohmann::json json_of(const Study& study, const Fit& f) {
  nlohmann::json j;
  const auto& c = *study.calibration;
  for (std::size_t i = 0; i < c.unknowns.size(); ++i)
    j["unknowns"][c.unknowns[i].name] = json_of(f.unknowns[i]);
  for (std::size_t i = 0; i < c.targets.size(); ++i) {
    auto& t = j[f.used[i] ? "fitted" : "predicted"][c.targets[i].name];
    t = {{"surface", json_of(f.on_surface[i])}};
    if (i < f.run_again.size()) t["run_again"] = json_of(f.run_again[i]);
    if (i < f.predictive.size()) t["predictive"] = json_of(f.predictive[i]);
    if (f.used[i] && i < f.contradicted.size())
      t["contradicted_by_runs"] = static_cast<bool>(f.contradicted[i]);
  }
  j["objective"] = f.objective;
  return j;
}

}  // namespace

nlohmann::json to_json(const Study& study, const CalibrationResult& r, const nlohmann::json& origin) {
  nlohmann::json j;
  const auto& c = *study.calibration;
  j["provenance"] = origin;
  for (std::size_t i = 0; i < c.targets.size(); ++i)
    j["targets"][c.targets[i].name] = {
        {"statistic", c.targets[i].statistic},        {"measured", r.measured[i]},
        {"tolerance", c.targets[i].tolerance},        {"surface_error_of_logarithm", r.surface_error[i]},
        {"spread_of_logarithm", r.surface_spread[i]}, {"points", r.points[i]}};
  j["fitted_to_all"] = json_of(study, r.all);
  for (std::size_t i = 0; i < r.left_out.size(); ++i)
    j["left_out"][c.targets[i].name] = json_of(study, r.left_out[i]);
  return j;
}

namespace {

struct CalibrateRequest : Request {
  std::string scene;  ///< the study's file
  Reach reach = Reach::beside;
  std::string output;  ///< result folder
  int threads = 0;     ///< 0 for all cores
  ShardOptions shards;
};

int calibrate(const CalibrateRequest& request) {
  const auto study = read_study(request.scene, request.reach);
  require_signal(study, "calibrate");
  const auto folder = result_folder(request.output, default_folder(study.file, ""));
  const auto origin = provenance(study);  // reads every file that it names
  auto plan = plan_calibration(study, request.conduct());
  if (request.stop()) return interrupted(Kept::nothing);
  if (request.shards
          .asked())  // the points; fits are made of what is merged, by the verb without these options
    return in_shards(divided_sweep(plan.study, request.conduct(), "calibrate",
                                   study_arguments(request.scene, request.reach), subject_of(study)),
                     request.shards, folder, request.threads, request.stop);
  make_folder(folder);
  const FolderLock lock(folder, "calibrate");
  settle_result_sets(folder);
  Progress progress;
  const auto r = freeplay::calibrate(
      std::move(plan), request.conduct(), lock, request.threads, [&](const SweepProgress& p) {
        progress.show(fmt::format("{} of {} runs, {:.0f} s left", p.done, p.total, p.seconds_left),
                      static_cast<double>(p.done) / static_cast<double>(p.total));
      });
  progress.clear();
  for (const auto& q : r.questions) fmt::print(stderr, "{}", wrapped("question: " + q + "\n", 10));
  if (r.sweep.interrupted) return interrupted(Kept::runs);
  const auto& c = *study.calibration;
  fmt::print("{} runs made in {:.0f} s, {} failed\n\nResponse surfaces (of the logarithm)\n", r.sweep.ran,
             r.sweep.wall_seconds, r.sweep.failed);
  for (std::size_t i = 0; i < c.targets.size(); ++i)
    fmt::print("  {:<10} {:<18} error {:.3f} where outcomes spread by {:.3f}{}\n", c.targets[i].name,
               c.targets[i].statistic, r.surface_error[i], r.surface_spread[i],
               r.points[i] < c.points
                   ? fmt::format("; {} of {} points, the others' runs failed", r.points[i], c.points)
                   : "");
  const auto fit = [&](const Fit& f, const std::string& title) {
    fmt::print("\n{}\n", title);
    for (std::size_t j = 0; j < c.unknowns.size(); ++j)
      fmt::print("  {:<16} {} {}{}\n", c.unknowns[j].name, show(f.unknowns[j]), c.unknowns[j].unit,
                 f.at_bound(j) ? "  AT ITS BOUND" : "");
    for (std::size_t i = 0; i < c.targets.size(); ++i) {
      const double sigma = std::hypot(c.targets[i].tolerance, r.surface_error[i]);
      if (f.used[i] && std::abs(std::log(f.on_surface[i].value / r.measured[i])) > 3 * sigma)
        fmt::print("  {}: NOT MET, by more than three standard uncertainties\n", c.targets[i].name);
      if (f.contradicted[i])
        fmt::print("  {}: CONTRADICTED by its own runs: the surface is not what the model does\n",
                   c.targets[i].name);
    }
    for (const bool used : {true, false})
      for (std::size_t i = 0; i < c.targets.size(); ++i)
        if (f.used[i] == used)
          fmt::print("  {:<10} {:<10} measured {:<8.4g} surface   {}\n{:34}runs      {}\n{:34}uncertain {}\n",
                     c.targets[i].name, used ? "fitted" : "PREDICTED", r.measured[i], show(f.on_surface[i]),
                     "", show(f.run_again[i]), "", show(f.predictive[i]));
  };
  fit(r.all, "Fitted to all");
  for (std::size_t i = 0; i < r.left_out.size(); ++i) fit(r.left_out[i], "Without " + c.targets[i].name);
  write_json(folder / "calibration.json", to_json(study, r, origin));
  fmt::print("\nresults in {}\n", folder.string());
  if (std::ranges::none_of(r.all.contradicted, std::identity{})) return 0;
  fmt::print(stderr, "{}",
             wrapped("the fit to all targets is contradicted by runs at its optimum and is none: take more "
                     "points, or narrower ranges\n"));
  return 1;
}

}  // namespace

void calibrate_verb(Program& program) {
  auto [options, request] =
      program.verb("calibrate", "fit a study's unknowns to measured statistics", calibrate);
  options.add("study", request.scene, "study file with [calibrate]").required();
  options.output(request.output, "result folder; default out/NAME");
  options.allow_outside(request.reach);
  options.threads(request.threads);
  declare_shards(options, request.shards);
}

}  // namespace freeplay::cli
