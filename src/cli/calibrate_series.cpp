#include "cli/calibrate_series.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/ending.hpp"
#include "cli/figures.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "study/calibration/calibration_documents.hpp"
#include "study/calibration/series_documents.hpp"
#include "study/calibration/series_fit.hpp"
#include "study/settings/study.hpp"

namespace freeplay::cli {
namespace {

/// The misfits of the fitted or of the predicted series.
void print_misfits(const Calibration& c, const SeriesFit& f, bool fitted) {
  if (std::ranges::none_of(f.series, [&](const auto& s) { return s.fitted == fitted; })) return;
  fmt::print("\n{}\n  {:<18} {:<9} {:>8} {:>8} {:>8} {:>6} {:>9} {:>6}\n", fitted ? "Fitted" : "Predicted",
             "target", "", "rms", "of", "mean", "indep.", "flank", "pairs");
  for (const auto& s : f.series) {
    if (s.fitted != fitted) continue;
    const auto& m = s.misfit;
    if (!s.reason.empty()) {
      fmt::print("  {:<18} {:<9} stopped: {}\n", c.targets[s.target].name, s.formulation, s.reason);
      continue;
    }
    const bool flanks = !c.targets[s.target].levels.empty();
    fmt::print(
        "  {:<18} {:<9} {:>8.4g} {:>8.4g} {:>8.2g} {:>6.3g} {:>9} {:>6}\n", c.targets[s.target].name,
        s.formulation, m.rms, m.measured_rms, m.mean, m.independent,
        flanks ? fmt::format("{:.3g}", m.flank_rms) : "-",
        flanks ? fmt::format("{}{}", m.flanks, m.unpaired > 0 ? fmt::format("-{}", m.unpaired) : "") : "-");
  }
}

}  // namespace

int calibrate_series(const Study& study, const std::filesystem::path& folder, const nlohmann::json& origin,
                     int threads, const StopToken& stop) try {
  const auto& c = *study.calibration;
  Progress progress;
  const auto f =
      fit_series(study, threads, stop, [&](int runs) { progress.show(fmt::format("{} runs", runs)); });
  progress.clear();
  make_folder(folder);
  const FolderLock lock(folder, "calibrate");
  settle_result_sets(folder);
  write_json(folder / "calibration.json", to_json(study, f), origin);
  write_file(folder / "series.csv", series_table(study, f).csv());
  fmt::print("{} runs, {} iterations\n\nUnknowns (95 % interval)\n", f.runs, f.iterations);
  for (std::size_t k = 0; k < c.unknowns.size(); ++k)
    fmt::print("  {:<16} {}{}\n", c.unknowns[k].name, value_text(c.unknowns[k], f.unknowns[k], 6),
               f.at_bound(k) ? ", AT ITS BOUND" : "");
  for (const bool fitted : {true, false}) print_misfits(c, f, fitted);
  fmt::print(
      "rms, mean: of model less measured; of: rms of the measured value about its mean;\n"
      "indep.: independent samples of the residual; flank: rms difference at the levels\n"
      "over `against`, SI; pairs: compared passages, then those without a partner\n\n");
  draw_results(folder, Undrawn::is_error, stop);
  fmt::print(f.holds() ? stdout : stderr, "\n{}", wrapped(conclusion(study, f) + "\n", 0));
  return f.holds() ? 0 : 1;
} catch (const Interrupted&) {
  return interrupted(Kept::nothing);
}

}  // namespace freeplay::cli
