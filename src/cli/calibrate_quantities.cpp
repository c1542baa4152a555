// freeplay calibrate for targets that are quantities of one run: fit, calibration.json and summary.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/calibrate.hpp"
#include "cli/ending.hpp"
#include "cli/terminal.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "study/calibration/quantity_fit.hpp"

namespace freeplay::cli {
namespace {

nlohmann::json document_of(const Study& study, const QuantityFit& f, const nlohmann::json& origin,
                           const std::string& conclusion) {
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
  for (std::size_t k = 0; k < c.unknowns.size(); ++k) {
    const auto& e = f.unknowns[k];
    fit["unknowns"][c.unknowns[k].name] = {
        {"key", c.unknowns[k].key}, {"value", e.value},           {"low", e.low},
        {"high", e.high},           {"unit", c.unknowns[k].unit}, {"open_low", e.open_low},
        {"open_high", e.open_high}};
  }
  fit["correlation"] = rows_of(f.correlation);
  fit["chi_squared"] = f.squares;
  fit["degrees_of_freedom"] = f.degrees;
  fit["holds"] = f.holds();
  j["fitted_to_all"] = fit;
  j["method"] = "derivatives";
  j["runs"] = f.runs;
  j["iterations"] = f.iterations;
  j["last_event"] = f.horizon;
  j["verdict"] = conclusion;
  j["provenance"] = origin;
  return j;
}

std::string conclusion_of(const Calibration& c, const QuantityFit& f) {
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

}  // namespace

int calibrate_quantities(const Study& study, const std::filesystem::path& folder,
                         const nlohmann::json& origin, const StopToken& stop) try {
  const auto& c = *study.calibration;
  Progress progress;
  const auto f = fit_quantities(
      study, stop, [&](int runs) { progress.show(fmt::format("{} runs with derivatives", runs), 0); });
  progress.clear();
  const auto conclusion = conclusion_of(c, f);
  make_folder(folder);
  const FolderLock lock(folder, "calibrate");
  settle_result_sets(folder);
  write_json(folder / "calibration.json", document_of(study, f, origin, conclusion));
  fmt::print("{} runs with derivatives, {} iterations\n", f.runs, f.iterations);
  fmt::print("\nUnknowns (95 % interval)\n");
  for (std::size_t k = 0; k < c.unknowns.size(); ++k) {
    const auto& e = f.unknowns[k];
    fmt::print("  {:<16} {:.8g}{}{}{}\n", c.unknowns[k].name, e.value,
               std::isfinite(e.low) ? fmt::format(" ({:.8g}..{:.8g})", e.low, e.high) : "",
               c.unknowns[k].unit.empty() ? "" : " " + c.unknowns[k].unit,
               f.at_bound(k) ? ", AT ITS BOUND" : "");
  }
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
  fmt::print(f.holds() ? stdout : stderr, "{}", wrapped(conclusion + "\n", 0));
  return f.holds() ? 0 : 1;
} catch (const Interrupted&) {
  return interrupted(Kept::nothing);
}

}  // namespace freeplay::cli
