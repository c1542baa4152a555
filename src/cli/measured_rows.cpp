#include "cli/measured_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/ending.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "mechanism/error.hpp"
#include "study/calibration/row_documents.hpp"
#include "study/calibration/row_fit.hpp"

namespace freeplay::cli {
namespace {

bool settled(const std::vector<RowPrediction>& all) {
  return std::ranges::all_of(all,
                             [](const auto& p) { return std::ranges::all_of(p.fits, &RowFit::settled); });
}

std::string count_text(const RowTable& table, const std::vector<RowPrediction>& all) {
  long runs = 0;
  for (const auto& p : all) runs += p.runs;
  return fmt::format("{} rows{}, {} runs\n\n", table.size(),
                     table.excluded > 0 ? fmt::format(" ({} excluded by where)", table.excluded) : "", runs);
}

}  // namespace

int calibrate_rows(const StudyRequest& request, const Study& study) try {
  if (request.shards.requested())
    throw SceneError(fmt::format("{}: rows: fits to rows cannot be divided over machines", request.study));
  const auto table = read_rows(study);
  const auto folder = result_folder(request.output, default_folder(study.file, ""));
  const auto origin = provenance(study);
  Progress progress;
  const auto all = predict_rows(study, table, false, request.conduct(), request.threads,
                                [&](const std::string& what, double done) { progress.show(what, done); });
  progress.clear();
  make_folder(folder);
  const FolderLock lock(folder, "calibrate");
  settle_result_sets(folder);
  write_json(folder / "calibration.json", to_json(study, table, all, {}), origin);
  fmt::print("{}{}\n{}\nresults in {}\n", count_text(table, all), constants_text(all), fitted_text(all),
             folder.string());
  return settled(all) ? 0 : 1;
} catch (const Interrupted&) {
  return interrupted(Kept::nothing);
}

int validate_rows(const ValidateRequest& request, const Study& study) try {
  const auto table = read_rows(study);
  const auto folder = result_folder(request.output, default_folder(study.file, ""));
  const auto origin = provenance(study);
  Progress progress;
  constexpr int all_threads = 0;
  const auto all = predict_rows(study, table, true, request.conduct(), all_threads,
                                [&](const std::string& what, double done) { progress.show(what, done); });
  const auto found = summaries(study, table, all);
  progress.clear();
  ResultSet set(folder, "validate-rows");
  write_json(set.place() / "rows.json", to_json(study, table, all, found), origin);
  write_file(set.place() / "rows.csv", predictions_table(study, table, all).csv());
  set.commit();
  fmt::print("{}{}\nResiduals of predicted rows: each part by the fits to the others\n\n{}\n",
             count_text(table, all), constants_text(all), predicted_text(all, found));
  fmt::print("results in {}\n\n{}", folder.string(), wrapped(conclusion(all, found) + "\n", 0));
  return settled(all) ? 0 : 1;
} catch (const Interrupted&) {
  return interrupted(Kept::nothing);
}

}  // namespace freeplay::cli
