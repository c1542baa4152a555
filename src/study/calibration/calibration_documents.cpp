#include "study/calibration/calibration_documents.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "study/calibration/calibrate.hpp"
#include "study/calibration/quantity_fit.hpp"
#include "study/settings/study.hpp"
#include "study/sweep/sweep_table.hpp"
#include "study/verdicts/verdicts.hpp"

namespace freeplay {

nlohmann::json rows_of(const Eigen::MatrixXd& m) {
  auto rows = nlohmann::json::array();
  for (const auto row : m.rowwise()) rows.push_back(std::vector<double>(row.begin(), row.end()));
  return rows;
}

nlohmann::json json_of(const std::vector<Unknown>& unknowns, const std::vector<Estimate>& estimates) {
  nlohmann::json j;
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    const auto& e = estimates[k];
    const auto& u = unknowns[k];
    j[u.name] = {{"key", u.key},
                 {"value", e.value},
                 {"low", e.low},
                 {"high", e.high},
                 {"unit", u.unit},
                 {"open_low", e.open_low},
                 {"open_high", e.open_high}};
  }
  return j;
}

std::string value_text(const Unknown& unknown, const Estimate& estimate, int digits) {
  auto text = fmt::format("{:.{}g}", estimate.value, digits);
  if (std::isfinite(estimate.low))
    text += fmt::format(" ({:.{}g}..{:.{}g})", estimate.low, digits, estimate.high, digits);
  return unknown.unit.empty() ? text : text + " " + unknown.unit;
}

namespace {

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

nlohmann::json json_of(const Calibration& c, const Fit& f) {
  nlohmann::json j;
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

}  // namespace

std::string conclusion(const Study& study, const CalibrationResult& r) {
  const auto& c = *study.calibration;
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

std::string conclusion(const Study& study, const QuantityFit& f) {
  const auto& c = *study.calibration;
  if (f.rejected)
    return fmt::format(
        "Rejected: the model cannot meet the fitted targets within their uncertainties (chi-squared "
        "{:.3g}, {} "
        "degrees of freedom).",
        f.squares, f.degrees);
  std::vector<std::string> open, missed;
  for (std::size_t k = 0; k < c.unknowns.size(); ++k)
    if (f.unknowns[k].open()) open.push_back(c.unknowns[k].name);
  // With 3 standard deviations, one of 400 predictions is named that is right.
  for (std::size_t i = 0; i < c.targets.size(); ++i)
    if (const double residual = (f.targets[i].value - c.targets[i].value) / f.targets[i].deviation;
        !f.targets[i].used && !(std::abs(residual) <= 3))
      missed.push_back(std::isfinite(residual) ? fmt::format("{} ({:.2g})", c.targets[i].name, residual)
                                               : c.targets[i].name + " (not reached)");
  if (!open.empty())
    return fmt::format(
        "Not determined: the fitted targets exclude no part of the range of {}{}.",
        fmt::join(open, " and of that of "),
        missed.empty() ? "" : fmt::format("; the model does not meet {}", fmt::join(missed, ", ")));
  std::string words = missed.empty() ? "The model meets the fitted targets:"
                                     : fmt::format(
                                           "The model meets the fitted targets, but not those beyond "
                                           "the horizon (standard deviations): {}. From the fitted ones:",
                                           fmt::join(missed, ", "));
  for (std::size_t k = 0; k < c.unknowns.size(); ++k) {
    const auto& e = f.unknowns[k];
    words += fmt::format("{} {} = {:.6g} ({:.6g}..{:.6g}){}{}", k > 0 ? "," : "", c.unknowns[k].name, e.value,
                         e.low, e.high, c.unknowns[k].unit.empty() ? "" : " ", c.unknowns[k].unit);
  }
  return words + ".";
}

nlohmann::json to_json(const Study& study, const CalibrationResult& r) {
  nlohmann::json j;
  const auto& c = *study.calibration;
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
  j["verdict"] = conclusion(study, r);
  j["fitted_to_all"] = json_of(c, r.all);
  for (std::size_t i = 0; i < r.left_out.size(); ++i)
    j["left_out"][c.targets[i].name] = json_of(c, r.left_out[i]);
  return j;
}

nlohmann::json to_json(const Study& study, const QuantityFit& f) {
  const auto& c = *study.calibration;
  nlohmann::json j, fit;
  for (std::size_t i = 0; i < c.targets.size(); ++i) {
    const auto& t = f.targets[i];
    j["targets"][c.targets[i].name] = {{"statistic", c.targets[i].statistic},
                                       {"measured", c.targets[i].value},
                                       {"standard_deviation", t.deviation}};
    fit[t.used ? "fitted" : "predicted"][c.targets[i].name] = {
        {"value", t.value},
        {"standard_deviation", t.model_deviation},
        {"residual", (t.value - c.targets[i].value) / t.deviation}};
  }
  fit["unknowns"] = json_of(c.unknowns, f.unknowns);
  fit["correlation"] = rows_of(f.correlation);
  fit["chi_squared"] = f.squares;
  fit["degrees_of_freedom"] = f.degrees;
  fit["holds"] = f.holds();
  j["fitted_to_all"] = fit;
  j["method"] = "derivatives";
  j["runs"] = f.runs;
  j["iterations"] = f.iterations;
  j["last_event"] = f.horizon;
  j["verdict"] = conclusion(study, f);
  return j;
}

Table outcomes_table(const Study& study, const CalibrationResult& r) {
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

Table misfit_table(const Study& study, const CalibrationResult& r) {
  const auto& c = *study.calibration;
  Table table("x_name,y_name,x,y,excess");
  for (const auto& map : r.maps)
    for (const auto& p : map.points)
      table.row(c.unknowns[map.x].name, c.unknowns[map.y].name, unscaled(c.unknowns[map.x], p.x),
                unscaled(c.unknowns[map.y], p.y), p.excess);
  return table;
}

}  // namespace freeplay
