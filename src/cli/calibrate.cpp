// freeplay calibrate: fits unknowns to measured statistics, and predicts each statistic from the
// others.
#include "study/calibration/calibrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "cli/calibrate.hpp"
#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/figures.hpp"
#include "cli/folders.hpp"
#include "cli/shards.hpp"
#include "cli/terminal.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "study/calibration/quantity_fit.hpp"
#include "study/partition/divided.hpp"
#include "study/settings/study.hpp"
#include "study/sweep/sweep_table.hpp"
#include "study/verdicts/verdicts.hpp"
#include "values/table.hpp"

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

/// Unit of a target's statistic or measure; empty: none is stated.
std::string unit_of_target(const Study& study, std::size_t target) {
  const auto& of = study.calibration->targets[target];
  const auto& name = of.statistic;
  if (of.is_waveform()) return std::string(unit_of(TurnMetrics::rms));
  for (std::size_t m = 0; m < TurnMetrics::count; ++m)
    if (name == TurnMetrics::names()[m]) return std::string(unit_of(static_cast<TurnMetrics::Name>(m)));
  const auto it = std::ranges::find(study.units, name, &std::pair<std::string, std::string>::first);
  return it == study.units.end() ? "" : it->second;
}

nlohmann::json json_of(const Estimate& e) { return {{"value", e.value}, {"low", e.low}, {"high", e.high}}; }

nlohmann::json json_of(const Study& study, const Fit& f) {
  nlohmann::json j;
  const auto& c = *study.calibration;
  for (std::size_t i = 0; i < c.unknowns.size(); ++i) {
    auto& u = j["unknowns"][c.unknowns[i].name] = json_of(f.unknowns[i]);
    u["unit"] = c.unknowns[i].unit;
    u["open_low"] = f.unknowns[i].open_low;
    u["open_high"] = f.unknowns[i].open_high;
  }
  for (std::size_t i = 0; i < c.targets.size(); ++i) {
    auto& t = j[f.used[i] ? "fitted" : "predicted"][c.targets[i].name];
    t = {{"surface", json_of(f.on_surface[i])}};
    if (i < f.run_again.size()) t["run_again"] = json_of(f.run_again[i]);
    if (i < f.predictive.size()) t["predictive"] = json_of(f.predictive[i]);
    if (f.used[i] && i < f.contradicted.size())
      t["contradicted_by_runs"] = static_cast<bool>(f.contradicted[i]);
  }
  j["objective"] = f.objective;
  j["chi_squared"] = f.squares;
  j["degrees_of_freedom"] = f.degrees;
  j["correlation"] = rows_of(f.correlation);
  j["settled"] = f.settled;
  j["holds"] = f.holds();
  return j;
}

/// A ridge in words: the combination that the targets determine, its ends, and what would separate the rest.
std::string words_of(const Ridge& r, const Calibration& c) {
  const auto& a = c.unknowns[r.along];
  const auto with_unit = [](double x, const Unknown& u) {
    return fmt::format("{:.4g}{}", x, u.unit.empty() ? "" : " " + u.unit);
  };
  std::vector<std::string> combinations,
      ways{fmt::format("{} goes from {} to {}", a.name, with_unit(r.ends[r.along][0], a),
                       with_unit(r.ends[r.along][1], a))};
  for (std::size_t k = 0; k < c.unknowns.size(); ++k) {
    if (!r.follows[k]) continue;
    const auto& u = c.unknowns[k];
    if (r.powers_of)
      combinations.push_back(fmt::format("{} {} {}^{:.2g} to {:.2g} %", u.name, r.slope[k] > 0 ? "/" : "*",
                                         a.name, std::abs(r.slope[k]), 100 * r.within[k]));
    else
      combinations.push_back(fmt::format("{} {} {:.3g} {} to {:.2g}", u.name, r.slope[k] > 0 ? "-" : "+",
                                         std::abs(r.slope[k]), a.name, r.within[k]));
    ways.push_back(
        fmt::format("{} from {} to {}", u.name, with_unit(r.ends[k][0], u), with_unit(r.ends[k][1], u)));
  }
  return fmt::format(
      "The targets determine {}, but not each unknown: along this ridge {}; {}.",
      fmt::join(combinations, " and "), fmt::join(ways, " and "),
      r.separator.empty()
          ? std::string(
                "no statistic of a run changes clearly along it, so a further measurement must separate them")
          : fmt::format("{}, which changes by {:.2g} % along it, would separate them", r.separator,
                        100 * r.change));
}

std::string conclusion(const Calibration& c, const CalibrationResult& r) {
  CalibrationValues v;
  v.rejected = r.all.rejected;
  v.settled = r.all.settled;
  if (r.ridge) v.ridge = words_of(*r.ridge, c);
  for (std::size_t i = 0; i < r.all.contradicted.size(); ++i)
    if (r.all.contradicted[i]) v.contradicted.push_back(c.targets[i].name);
  for (std::size_t j = 0; j < c.unknowns.size(); ++j) {
    const auto& e = r.all.unknowns[j];
    v.unknowns.push_back(
        {c.unknowns[j].name, c.unknowns[j].unit, e.value, e.low, e.high, e.open_low || e.open_high});
  }
  for (std::size_t i = 0; i < r.left_out.size(); ++i) {
    if (!r.left_out[i].holds()) {
      v.unpredicted.push_back(c.targets[i].name);
      continue;
    }
    if (i >= r.left_out[i].predictive.size() || !std::isfinite(r.left_out[i].predictive[i].low)) continue;
    const auto& p = r.left_out[i].predictive[i];
    ++v.predictions;
    v.predicted += p.low <= r.measured[i] && r.measured[i] <= p.high;
  }
  return verdict(v);
}

}  // namespace

nlohmann::json rows_of(const Eigen::MatrixXd& m) {
  auto rows = nlohmann::json::array();
  for (const auto row : m.rowwise()) rows.push_back(std::vector<double>(row.begin(), row.end()));
  return rows;
}

nlohmann::json to_json(const Study& study, const CalibrationResult& r, const nlohmann::json& origin) {
  nlohmann::json j;
  const auto& c = *study.calibration;
  j["provenance"] = origin;
  for (std::size_t i = 0; i < c.targets.size(); ++i)
    j["targets"][c.targets[i].name] = {{"statistic", c.targets[i].statistic},
                                       {"unit", unit_of_target(study, i)},
                                       {"measured", r.measured[i]},
                                       {"tolerance", r.tolerance[i]},
                                       {"surface_error_of_logarithm", r.surface_error[i]},
                                       {"spread_of_logarithm", r.surface_spread[i]},
                                       {"points", r.points[i]},
                                       {"surface_error_at_optimum", std::sqrt(r.at_optimum[i].surface)},
                                       {"scatter_at_optimum", std::sqrt(r.at_optimum[i].scatter)}};
  for (std::size_t k = 0; k < c.unknowns.size(); ++k) {
    auto& u = j["identifiability"]["unknowns"][c.unknowns[k].name];
    u = {{"range_left_open", r.before.left_open[k]}, {"identified", r.before.identified(k)}};
    for (std::size_t i = 0; i < c.targets.size(); ++i)
      u["sensitivity"][c.targets[i].name] =
          r.before.sensitivity(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
  }
  j["identifiability"]["correlation"] = rows_of(r.before.correlation);
  j["refinement"] = {{"rounds", r.rounds}, {"points", r.tried - c.points}, {"fine_enough", r.refined}};
  if (r.ridge) {
    auto& ridge = j["ridge"];
    ridge = {{"along", c.unknowns[r.ridge->along].name},
             {"separator", r.ridge->separator},
             {"change_of_separator", r.ridge->change}};
    for (std::size_t k = 0; k < c.unknowns.size(); ++k)
      ridge["unknowns"][c.unknowns[k].name] = {{"from", r.ridge->ends[k][0]},
                                               {"to", r.ridge->ends[k][1]},
                                               {r.ridge->powers_of ? "power" : "slope", r.ridge->slope[k]},
                                               {"within", r.ridge->within[k]},
                                               {"follows", static_cast<bool>(r.ridge->follows[k])}};
  }
  j["verdict"] = conclusion(c, r);
  j["fitted_to_all"] = json_of(study, r.all);
  for (std::size_t i = 0; i < r.left_out.size(); ++i)
    j["left_out"][c.targets[i].name] = json_of(study, r.left_out[i]);
  return j;
}

namespace {

/// calibration.csv: outcomes of all points over each unknown, and the 95 % range of each measured
/// value.
Table points_table(const Study& study, const CalibrationResult& r) {
  const auto& c = *study.calibration;
  Table table("target,unknown,at,outcome,measured,low,high,target_unit,unknown_unit");
  for (const auto& o : r.outcomes) {
    const double known = std::hypot(r.tolerance[o.target], std::sqrt(r.at_optimum[o.target].scatter));
    for (std::size_t j = 0; j < c.unknowns.size(); ++j)
      table.row(c.targets[o.target].name, c.unknowns[j].name,
                unscaled(c.unknowns[j], o.xi[static_cast<Eigen::Index>(j)]), o.value, r.measured[o.target],
                r.measured[o.target] * std::exp(-1.96 * known), r.measured[o.target] * std::exp(1.96 * known),
                unit_of_target(study, o.target), c.unknowns[j].unit);
  }
  return table;
}

/// misfit.csv: f − min f for each pair of unknowns, minimised over the others.
Table misfit_table(const Calibration& c, const CalibrationResult& r) {
  Table table("x_name,y_name,x,y,excess");
  for (const auto& map : r.maps)
    for (const auto& p : map.points)
      table.row(c.unknowns[map.x].name, c.unknowns[map.y].name, unscaled(c.unknowns[map.x], p.x),
                unscaled(c.unknowns[map.y], p.y), p.excess);
  return table;
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

int calibrate(const StudyRequest& request) {
  const auto study = read_study(request.study, request.reach);
  const bool quantities = study.calibration && fits_quantities(*study.calibration);
  if (!quantities) require_signal(study, "calibrate");
  const auto folder = result_folder(request.output, default_folder(study.file, ""));
  const auto origin = provenance(study);  // reads all named files
  if (quantities && !request.shards.requested())
    return calibrate_quantities(study, folder, origin, request.stop);
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
  write_file(folder / "calibration.csv", points_table(study, r).csv());
  write_file(folder / "misfit.csv", misfit_table(c, r).csv());
  write_json(folder / "calibration.json", to_json(study, r, origin));
  fmt::print("\n");
  draw_results(folder, Undrawn::is_error, request.stop);
  const bool holds = r.all.holds();
  fmt::print(holds ? stdout : stderr, "\n{}", wrapped(conclusion(c, r) + "\n", 0));
  return holds ? 0 : 1;
}

}  // namespace

void calibrate_verb(Program& program) {
  auto [options, request] =
      program.verb("calibrate", "fit unknown parameters of a study to measured statistics", calibrate);
  declare_study(options, request, "study file with [calibrate]", "result folder; default out/NAME");
}

}  // namespace freeplay::cli
