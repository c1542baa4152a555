// freeplay scaling: measures how the cost of a step grows with the size of a mechanism; writes a
// table and a figure.
#include "verification/timing/scaling.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "plots/drawing/figure.hpp"

namespace freeplay::cli {
namespace {

struct ScalingRequest : Request {
  int most = 4096;
  int repetitions = 3;
  std::string output;    ///< result folder
  std::string document;  ///< folder for scaling.md and its figure
};

int scaling(const ScalingRequest& request) {
  const auto folder = result_folder(request.output, "out/scaling");
  ResultSet set(folder, "scaling");
  Progress progress;
  std::vector<verification::Measured> all;
  for (const auto& g : verification::growths()) {
    auto& costs = all.emplace_back(g).costs;
    fmt::print("{}\n", g.what);
    for (const int count : g.counts) {
      if (count > request.most) break;
      if (request.stop()) return interrupted(Kept::nothing);
      progress.show(fmt::format("{}, {} {}", g.name, count, g.counted),
                    double(costs.size()) / double(g.counts.size()));
      costs.push_back(verification::measure(g, count, request.repetitions));
      progress.clear();
    }
    fmt::print("{}{}\n", cost_table(all.back()).terminal({-12, 8, 11, 9, 9, 8, 9, 9}),
               conclusion(all.back()));
  }
  auto origin = provenance();
  origin["scene_file"] = "scaling";
  write_json(set.place() / "scaling.json", to_json(all), origin);
  write_file(set.place() / "scaling.csv", scaling_table(all).csv());
  set.commit();
  fmt::print("results in {}\n", folder.string());
  const auto figures = plots::all(folder);
  for (const auto& path : figures) fmt::print("  {}\n", path.string());
  write_page(request.document, folder, "scaling", "scaling.md", scaling_page(all, request.repetitions),
             figures);
  return 0;
}

}  // namespace

void scaling_verb(Program& program) {
  auto [options, request] = program.verb("scaling", scaling_what, scaling);
  options.output(request.output, "result folder");
  options.add("--document", request.document, "write scaling.md and its figure into this folder")
      .takes("FOLDER");
  options.add("--most", request.most, "greatest number of joints, links or bodies")
      .between(1, 1000000)
      .shows_default();
  options.add("--repeat", request.repetitions, "runs of each size; the fastest counts")
      .between(1, 100)
      .shows_default();
}

}  // namespace freeplay::cli
