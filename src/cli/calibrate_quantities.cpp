// freeplay calibrate for targets that are quantities of one run: fit, calibration.json and summary.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/calibrate.hpp"
#include "cli/ending.hpp"
#include "cli/terminal.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "study/calibration/calibration_documents.hpp"
#include "study/calibration/quantity_fit.hpp"
#include "study/settings/study.hpp"

namespace freeplay::cli {

int calibrate_quantities(const Study& study, const std::filesystem::path& folder,
                         const nlohmann::json& origin, const StopToken& stop) try {
  const auto& c = *study.calibration;
  Progress progress;
  const auto f = fit_quantities(
      study, stop, [&](int runs) { progress.show(fmt::format("{} runs with derivatives", runs), 0); });
  progress.clear();
  make_folder(folder);
  const FolderLock lock(folder, "calibrate");
  settle_result_sets(folder);
  write_json(folder / "calibration.json", to_json(study, f), origin);
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
  fmt::print(f.holds() ? stdout : stderr, "{}", wrapped(conclusion(study, f) + "\n", 0));
  return f.holds() ? 0 : 1;
} catch (const Interrupted&) {
  return interrupted(Kept::nothing);
}

}  // namespace freeplay::cli
