// freeplay validate STUDY with claims = "points": makes missing runs, and compares a quantity of
// each variant with measured values at single points of the axes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/default_folder.hpp"
#include "cli/ending.hpp"
#include "cli/progress.hpp"
#include "cli/validate.hpp"
#include "cli/wrapped.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "plots/drawing/figure.hpp"
#include "study/calibration/measured_points.hpp"
#include "study/settings/plan.hpp"
#include "study/settings/provenance.hpp"
#include "study/sweep/sweep.hpp"
#include "study/sweep/sweep_document.hpp"

namespace freeplay::cli {
namespace {

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

/// The measured points of a compared quantity.
const std::vector<MeasuredPoint>& points_of(const std::vector<MeasuredQuantity>& measured,
                                            const PointAgreement& a) {
  return std::ranges::find(measured, a.quantity, &MeasuredQuantity::name)->points;
}

/// The place of a measured point in words.
std::string place(const Study& study, const MeasuredPoint& point) {
  std::string text;
  for (std::size_t k = 0; k < point.at.size(); ++k) {
    const auto& axis = study.axes[k];
    text += fmt::format("{}{} = {:.6g}{}{}", k > 0 ? ", " : "", axis.name, point.at[k] * axis.scale,
                        axis.unit.empty() ? "" : " ", axis.unit);
  }
  return text;
}

/// A sentence for each variant and formulation.
std::string verdicts(const Study& study, const std::vector<MeasuredQuantity>& measured,
                     const std::vector<PointAgreement>& all) {
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
        text += fmt::format("greatest error {:.3g} at {}", a.greatest,
                            place(study, points_of(measured, a)[a.greatest_at]));
      }
      out += fmt::format("{} [{}] {}{}: {}\n", v.title, formulation,
                         verdict == Agreement::Verdict::undecided ? "is " : "", text_of(verdict), text);
    }
  return out;
}

/// The conclusion in one or two sentences.
std::string conclusion(const Study& study, const std::vector<MeasuredQuantity>& measured,
                       const std::vector<PointAgreement>& all) {
  std::vector<PointsAgreement> models;
  for (const auto& v : study.variants)
    for (const auto& formulation : v.formulations) {
      auto worst = Agreement::Verdict::agrees;
      double squares = 0;
      int count = 0;
      for (const auto& a : all) {
        if (a.variant != v.name || a.formulation != formulation) continue;
        worst = std::max(worst, a.verdict());
        const auto& points = points_of(measured, a);
        for (std::size_t i = 0; i < points.size(); ++i)
          squares += std::pow((a.model[i] - points[i].value) / points[i].value, 2), ++count;
      }
      models.push_back(
          {fmt::format("{} [{}]", v.title, formulation), outcome_of(worst), std::sqrt(squares / count)});
    }
  return verdict(models);
}

nlohmann::json to_json(const Study& study, const std::vector<MeasuredQuantity>& measured,
                       const std::vector<PointAgreement>& all) {
  nlohmann::json out;
  for (const auto& axis : study.axes) out["axes"].push_back({{"name", axis.name}, {"unit", axis.unit}});
  for (const auto& v : study.variants) out["variants"].push_back({{"name", v.name}, {"title", v.title}});
  for (const auto& m : measured) out["quantities"].push_back(m.name);
  for (const auto& a : all)
    out["agreement"].push_back({{"variant", a.variant},
                                {"formulation", a.formulation},
                                {"quantity", a.quantity},
                                {"rms", a.rms},
                                {"greatest", a.greatest},
                                {"greatest_at", place(study, points_of(measured, a)[a.greatest_at])},
                                {"outside", a.decided ? nlohmann::json(a.outside) : nlohmann::json()},
                                {"points", a.model.size()},
                                {"verdict", text_of(a.verdict())}});
  return out;
}

/// Columns that name a run, and then `columns`.
std::string csv_header(const Study& study, const char* columns) {
  std::string line = "quantity,variant,formulation,";
  for (const auto& axis : study.axes) line += axis.name + ",";
  return line + columns + "\n";
}

void write_points(const Study& study, const std::vector<MeasuredQuantity>& measured,
                  const std::vector<PointAgreement>& all, const std::filesystem::path& file) {
  std::string csv = csv_header(study, "measured,uncertainty,model");
  for (const auto& a : all) {
    const auto& points = points_of(measured, a);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto& p = points[i];
      csv += fmt::format("{},{},{}", a.quantity, a.variant, a.formulation);
      for (std::size_t k = 0; k < p.at.size(); ++k) csv += fmt::format(",{}", p.at[k] * study.axes[k].scale);
      csv += fmt::format(",{},{},{}\n", p.value, p.uncertainty, a.model[i]);
    }
  }
  write_file(file, csv);
}

/// The quantities of every run, for curves through the measured points.
void write_curves(const Study& study, const std::vector<MeasuredQuantity>& measured,
                  const std::vector<RunRow>& runs, const std::filesystem::path& file) {
  std::string csv = csv_header(study, "model");
  const QuantityReader quantity(study);
  for (const auto& m : measured)
    for (const auto& run : runs) {
      csv += fmt::format("{},{},{}", m.name, run.variant, run.formulation);
      for (std::size_t k = 0; k < run.values.size(); ++k)
        csv += fmt::format(",{}", run.values[k] * study.axes[k].scale);
      csv += fmt::format(",{}\n", quantity(m.name, run));
    }
  write_file(file, csv);
}

}  // namespace

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
  fmt::print("{}{}\n", table(measured, all), wrapped(verdicts(study, measured, all), 2));
  auto document = to_json(study, measured, all);
  document["provenance"] = provenance(study);
  const auto said = conclusion(study, measured, all);
  document["verdict"] = said;
  write_json(set.place() / "points.json", document);
  write_points(study, measured, all, set.place() / "points.csv");
  write_curves(study, measured, runs, set.place() / "curves.csv");
  if (request.stop()) return interrupted(Kept::runs);
  set.commit();
  fmt::print("{} runs, {} made; results in {}\n", summary.total, summary.ran, folder.string());
  for (const auto& figure : plots::points.draw(folder)) fmt::print("  {}\n", figure.string());
  fmt::print("\n{}", wrapped(said + "\n", 0));
  // Rows without a model have a failed run.
  return std::ranges::all_of(all, [](const auto& a) { return std::isfinite(a.rms); }) ? 0 : 1;
}

}  // namespace freeplay::cli
