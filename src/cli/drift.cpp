// freeplay drift: effect of each stabilisation on constraint errors and energy balance.
#include "study/comparison/drift.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/result_set.hpp"
#include "io/scene/read_scene.hpp"
#include "plots/drawing/figure.hpp"
#include "values/table.hpp"

namespace freeplay::cli {
namespace {

struct DriftRequest : Request {
  std::string scene;
  std::vector<std::string> overrides;
  std::string output;  ///< result folder
};

int drift(const DriftRequest& request) {
  const auto scene = open_scene(request.scene, request.overrides);
  const auto folder = result_folder(request.output, default_folder(request.scene, "-drift"));
  ResultSet set(folder, "drift");
  Progress progress;
  const auto runs = measure_drift(*scene, request.stop, set.place(),
                                  [&](const std::string& which, double done) { progress.show(which, done); });
  progress.clear();
  if (request.stop()) return interrupted(Kept::nothing);
  set.commit();
  Table table(",greatest m,greatest rad,closure J,rhs,CPU s");
  int status = 0;
  for (const auto& r : runs) {
    table.row(r.stabilisation, fmt::format("{:.2g}", r.greatest_length),
              fmt::format("{:.2g}", r.greatest_angle), fmt::format("{:.2g}", r.closure), r.rhs,
              fmt::format("{:.3g}", r.cpu_seconds));
    if (r.ending.status == Ending::Status::failed) {
      fmt::print(stderr, "{}: stopped: {}\n", r.stabilisation, r.ending.reason);
      status = 1;
    }
  }
  fmt::print("{}results in {}\nfigures:\n", table.terminal({12, 14, 14, 14, 12, 10}), folder.string());
  for (const auto& path : plots::all(folder)) fmt::print("  {}\n", path.string());
  return status;
}

}  // namespace

void drift_verb(Program& program) {
  auto [options, request] = program.verb(
      "drift", "compare constraint drift and energy errors of the penalty stabilisations", drift);
  options.scene(request.scene).required();
  options.set(request.overrides);
  options.output(request.output, "result folder; default out/NAME-drift");
}

}  // namespace freeplay::cli
