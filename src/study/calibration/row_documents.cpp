#include "study/calibration/row_documents.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "study/calibration/calibration_documents.hpp"

namespace freeplay {
namespace {

std::string fit_name(const RowPrediction& p, std::size_t fit) {
  return p.fits.size() == 1 ? "all rows" : fmt::format("without part {}", fit);
}

nlohmann::json json_of_fit(const RowPrediction& p, const RowFit& fit) {
  nlohmann::json unknowns = nlohmann::json::object();
  for (std::size_t j = 0; j < p.unknowns.size(); ++j) {
    const auto& e = fit.unknowns[j];
    unknowns[p.unknowns[j].name] = {
        {"key", p.unknowns[j].key}, {"unit", p.unknowns[j].unit}, {"value", e.value},        {"low", e.low},
        {"high", e.high},           {"open_low", e.open_low},     {"open_high", e.open_high}};
  }
  return {
      {"rows", fit.residuals.size()},
      {"unknowns", unknowns},
      {"steps", fit.iterations},
      {"settled", fit.settled},
      {"fitted_residuals",
       {{"median", quantile_of(fit.residuals, 0.5)}, {"ninety_per_cent", quantile_of(fit.residuals, 0.9)}}}};
}

}  // namespace

std::string constants_text(const std::vector<RowPrediction>& predictions) {
  std::string out = "Fitted constants (95 % interval)\n";
  for (const auto& p : predictions) {
    out += fmt::format("{}: {}\n", p.name(), p.title);
    for (std::size_t f = 0; f < p.fits.size(); ++f) {
      const auto& fit = p.fits[f];
      out += fmt::format("  {} ({} rows fitted){}\n", fit_name(p, f), fit.residuals.size(),
                         fit.settled ? "" : ": NOT AT A MINIMUM");
      for (std::size_t j = 0; j < p.unknowns.size(); ++j) {
        const auto& e = fit.unknowns[j];
        out += fmt::format("    {:<24} {}{}{}\n", p.unknowns[j].name, value_text(p.unknowns[j], e, 4),
                           e.open()      ? ", open: not determined"
                           : e.open_low  ? ", open below"
                           : e.open_high ? ", open above"
                                         : "",
                           fit.at_bound(j) ? ", AT ITS BOUND" : "");
      }
    }
  }
  return out;
}

std::string fitted_text(const std::vector<RowPrediction>& predictions) {
  Table table("residuals of fitted rows,rows,median,90 %");
  for (const auto& p : predictions)
    for (std::size_t f = 0; f < p.fits.size(); ++f)
      table.row(p.fits.size() == 1 ? p.name() : fmt::format("{} {}", p.name(), fit_name(p, f)),
                p.fits[f].residuals.size(), fmt::format("{:.4g}", quantile_of(p.fits[f].residuals, 0.5)),
                fmt::format("{:.4g}", quantile_of(p.fits[f].residuals, 0.9)));
  return table.terminal({46, 8, 10, 10});
}

std::string predicted_text(const std::vector<RowPrediction>& predictions,
                           const std::vector<RowSummary>& summaries) {
  std::string out;
  for (std::size_t from = 0; from < summaries.size(); from += predictions.size()) {
    Table table(
        {fmt::format("{} ({})", summaries[from].rows, summaries[from].count), "median", "95 %", "90 %", ""});
    for (std::size_t m = 0; m < predictions.size(); ++m) {
      const auto& s = summaries[from + m];
      table.row(predictions[m].name(), fmt::format("{:.4g}", s.median.value),
                fmt::format("{:.3g}..{:.3g}", s.median.low, s.median.high), fmt::format("{:.4g}", s.ninety),
                s.best    ? "best"
                : s.worse ? "worse"
                          : "equal");
    }
    out += (from > 0 ? "\n" : "") + table.terminal({36, 9, 16, 9, 7});
  }
  return out +
         "90 %: nine of ten residuals are below. worse: the 95 % interval of the median less that\n"
         "of the best excludes 0.\n";
}

std::string conclusion(const std::vector<RowPrediction>& predictions,
                       const std::vector<RowSummary>& summaries) {
  const auto best = std::ranges::find(summaries, true, &RowSummary::best);
  std::string equal;
  const auto models = static_cast<std::ptrdiff_t>(predictions.size());
  for (auto s = summaries.begin(); s != summaries.begin() + models; ++s)
    if (!s->best && !s->worse)
      equal += fmt::format("{}{}", equal.empty() ? "" : ", ", predictions[s->model].name());
  return fmt::format(
      "Of {} models, {} predicts the {} held-out rows best: median residual {:.3g} ({:.3g} to {:.3g}), 90 % "
      "below {:.3g}.{}",
      predictions.size(), predictions[best->model].name(), best->count, best->median.value, best->median.low,
      best->median.high, best->ninety,
      equal.empty() ? predictions.size() > 1 ? " All others are worse." : ""
                    : fmt::format(" Not distinguishable from it: {}.", equal));
}

nlohmann::json to_json(const Study& study, const RowTable& table,
                       const std::vector<RowPrediction>& predictions,
                       const std::vector<RowSummary>& summaries) {
  nlohmann::json j = {{"rows", table.size()}, {"excluded", table.excluded}};
  for (const auto& t : study.rows->targets) j["targets"][t.name] = {{"value", t.value}, {"weight", t.weight}};
  for (const auto& p : predictions) {
    nlohmann::json one = {
        {"variant", p.variant}, {"title", p.title}, {"formulation", p.formulation}, {"runs", p.runs}};
    for (std::size_t f = 0; f < p.fits.size(); ++f) {
      one["fits"].push_back(json_of_fit(p, p.fits[f]));
      one["fits"].back()["fitted_to"] = fit_name(p, f);
    }
    for (const auto& s : summaries)
      if (predictions[s.model].name() == p.name())
        one["predicted"].push_back({{"rows", s.rows},
                                    {"count", s.count},
                                    {"median", s.median.value},
                                    {"low", s.median.low},
                                    {"high", s.median.high},
                                    {"ninety_per_cent", s.ninety},
                                    {"mean_difference", s.mean},
                                    {"best", s.best},
                                    {"worse_than_best", s.worse}});
    j["models"].push_back(std::move(one));
  }
  if (!summaries.empty()) j["verdict"] = conclusion(predictions, summaries);
  return j;
}

Table predictions_table(const Study& study, const RowTable& table,
                        const std::vector<RowPrediction>& predictions) {
  Table out("line,part,variant,formulation,residual");
  for (const auto& t : study.rows->targets)
    for (const char* what : {"measured", "predicted"}) out.column(fmt::format("{}_{}", t.name, what));
  for (const auto& c : study.rows->classes) out.column(c.name);
  for (const auto& p : predictions)
    for (std::size_t i = 0; i < table.size(); ++i) {
      std::vector<Table::Cell> row{table.lines[i], std::int64_t{table.part[i]}, p.variant, p.formulation,
                                   p.residual[i]};
      for (std::size_t t = 0; t < study.rows->targets.size(); ++t) {
        const auto at = static_cast<Eigen::Index>(i), k = static_cast<Eigen::Index>(t);
        const double measured = table.measured(at, k);
        row.emplace_back(measured);
        row.emplace_back(measured + p.difference(at, k) / study.rows->targets[t].weight);
      }
      for (const auto& values : table.values) row.emplace_back(values[i]);
      out.row(std::move(row));
    }
  return out;
}

}  // namespace freeplay
