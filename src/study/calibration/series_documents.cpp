#include "study/calibration/series_documents.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "study/calibration/calibration_documents.hpp"
#include "study/calibration/series_fit.hpp"
#include "study/settings/study.hpp"

namespace freeplay {

std::string conclusion(const Study& study, const SeriesFit& f) {
  const auto& c = *study.calibration;
  std::vector<std::string> stopped, open, bare, values, fitted, predicted;
  for (const auto& s : f.series) {
    const auto name = fmt::format("{} [{}]", c.targets[s.target].name, s.formulation);
    if (!s.reason.empty()) {
      stopped.push_back(fmt::format("{} ({})", name, s.reason));
      continue;
    }
    const auto share = fmt::format("{:.2g} % of {}", 100 * s.misfit.rms / s.misfit.measured_rms, name);
    (s.fitted ? fitted : predicted).push_back(share);
  }
  for (std::size_t j = 0; j < c.unknowns.size(); ++j) {
    const auto& e = f.unknowns[j];
    const auto& u = c.unknowns[j];
    if (!std::isfinite(e.low))
      bare.push_back(u.name);
    else if (e.open_low || e.open_high)
      open.push_back(u.name);
    values.push_back(fmt::format("{} = {}", u.name, value_text(u, e, 4)));
  }
  if (!stopped.empty())
    return fmt::format("Failed: runs at the optimum stopped: {}.", fmt::join(stopped, ", "));
  if (!f.converged)
    return "Not converged: the misfit has no minimum that a step of the unknowns would not change by a "
           "tenth of their standard deviations.";
  auto words = fmt::format("{}.", fmt::join(values, ", "));
  if (!open.empty())
    words += fmt::format(" The series do not exclude an end of the range of {}.", fmt::join(open, ", "));
  if (!bare.empty())
    words += fmt::format(" {:.2g} independent samples give no interval of {}.", f.independent,
                         fmt::join(bare, ", "));
  words += fmt::format(" The residual is {} (fitted)", fmt::join(fitted, ", "));
  if (!predicted.empty()) words += fmt::format(", and {} (predicted)", fmt::join(predicted, ", "));
  return words + ".";
}

nlohmann::json to_json(const Study& study, const SeriesFit& f) {
  const auto& c = *study.calibration;
  nlohmann::json j;
  for (const auto& t : c.targets)
    j["targets"][t.name] = {{"statistic", t.statistic},
                            {"channel", t.channel},
                            {"hold_out", t.hold_out},
                            {"against", t.against},
                            {"against_unit", t.unit}};
  nlohmann::json fit;
  fit["unknowns"] = json_of(c.unknowns, f.unknowns);
  for (const auto& s : f.series) {
    auto& one = fit[s.fitted ? "fitted" : "predicted"][c.targets[s.target].name][s.formulation];
    if (!s.reason.empty()) {
      one = {{"stopped", s.reason}};
      continue;
    }
    const auto& m = s.misfit;
    one = {{"samples", m.samples},
           {"rms", m.rms},
           {"mean", m.mean},
           {"greatest", m.greatest},
           {"greatest_at", m.greatest_at},
           {"measured_rms", m.measured_rms},
           {"correlation_time", m.correlation_time},
           {"independent_samples", m.independent}};
    if (!c.targets[s.target].levels.empty())
      one["flanks"] = {
          {"compared", m.flanks}, {"unpaired", m.unpaired}, {"rms", m.flank_rms}, {"mean", m.flank_mean}};
  }
  fit["correlation"] = rows_of(f.correlation);
  fit["independent_samples"] = f.independent;
  fit["converged"] = f.converged;
  fit["holds"] = f.holds();
  j["fitted_to_all"] = fit;
  j["method"] = "series";
  j["runs"] = f.runs;
  j["iterations"] = f.iterations;
  j["verdict"] = conclusion(study, f);
  return j;
}

Table series_table(const Study& study, const SeriesFit& f) {
  const auto& c = *study.calibration;
  Table table("target,formulation,use,t,against,measured,model");
  for (const auto& s : f.series)
    for (std::size_t i = 0; i < s.model.size(); ++i)
      table.row(c.targets[s.target].name, s.formulation, s.fitted ? "fitted" : "predicted", s.t[i],
                s.against.empty() ? std::nan("") : s.against[i], s.measured[i], s.model[i]);
  return table;
}

}  // namespace freeplay
