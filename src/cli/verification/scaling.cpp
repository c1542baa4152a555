// freeplay scaling: measures how the cost of a step grows with the size of a mechanism; writes a
// table and a figure.
#include "verification/timing/scaling.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "plots/drawing/figure.hpp"
#include "values/table.hpp"

namespace freeplay::cli {
namespace {

struct ScalingRequest : Request {
  int most = 4096;
  int repetitions = 3;
  std::string output;    ///< result folder
  std::string document;  ///< folder for scaling.md and its figure
};

using verification::Cost;
using verification::Growth;

const char* unit_of(const Growth& g) { return g.family == Family::penalty ? "right-hand side" : "step"; }

std::string table(const Growth& g, const std::vector<Cost>& costs, bool markdown) {
  Table t({g.counted, "bodies", "µs", "µs each", "set-up s", "MB", "problems", "pivots"});
  for (const auto& c : costs)
    t.row(c.count, c.bodies, fmt::format("{:.4g}", c.microseconds),
          fmt::format("{:.3g}", c.microseconds / c.count), fmt::format("{:.2g}", c.setup_s),
          fmt::format("{:.0f}", c.megabytes), fmt::format("{:.3g}", c.solves),
          fmt::format("{:.3g}", c.pivots));
  return markdown ? t.markdown() : t.terminal({-12, 8, 11, 9, 9, 8, 9, 9});
}

std::string conclusion(const Growth& g, const std::vector<Cost>& costs) {
  const double found = verification::exponent(g, costs);
  std::string text = std::isnan(found)
                         ? fmt::format("No exponent: it needs at least {} {}.\n", g.fit_from, g.counted)
                         : fmt::format("Exponent from {} {} on: {:.2f}; predicted {:g}, for {}.\n",
                                       g.fit_from, g.counted, found, g.predicted, g.reason);
  for (const auto& c : costs)
    if (!c.ending.empty()) text += fmt::format("The run with {} failed: {}\n", c.count, c.ending);
  return text;
}

/// Predicted cost for sizes from fit_from on; empty for smaller ones.
std::string predicted(const Growth& g, const std::vector<Cost>& costs, const Cost& c) {
  for (const auto& first : costs)
    if (first.count >= g.fit_from && c.count >= first.count)
      return fmt::format("{:.6g}", first.microseconds * std::pow(double(c.count) / first.count, g.predicted));
  return "";
}

int scaling(const ScalingRequest& request) {
  const auto folder = result_folder(request.output, "out/scaling");
  ResultSet set(folder, "scaling");
  Progress progress;
  std::string csv =
      "scene,count,bodies,microseconds,predicted,setup_s,megabytes,units,solves,pivots,lasting\n";
  std::string text = fmt::format(
      "# Cost against size\n\nWritten by `freeplay scaling --document docs/verification`: the fastest of "
      "{} runs, each "
      "in a separate process with one thread. *µs*: processor time of a step or a right-hand side; *each*: "
      "divided by the number of elements; *set-up*: time from the scene to the first step; *MB*: peak "
      "memory of the process; *problems*: contact problems per step; *pivots*: pivots, sweeps or Newton "
      "steps per problem. Times depend on the machine; exponents and counts do "
      "not.\n\n![cost](figures/scaling.png)\n",
      request.repetitions);
  nlohmann::json list = nlohmann::json::array();
  for (const auto& g : verification::growths()) {
    std::vector<Cost> costs;
    fmt::print("{}\n", g.what);
    for (const int count : g.counts) {
      if (count > request.most) break;
      if (request.stop()) return interrupted(Kept::nothing);
      progress.show(fmt::format("{}, {} {}", g.name, count, g.counted),
                    double(costs.size()) / double(g.counts.size()));
      costs.push_back(verification::measure(g, count, request.repetitions));
      progress.clear();
    }
    fmt::print("{}{}\n", table(g, costs, false), conclusion(g, costs));
    text += fmt::format("\n## {}\n\n{}, {}; µs a {}.\n\n{}\n{}", g.name, g.what, name_of(g.family),
                        unit_of(g), table(g, costs, true), conclusion(g, costs));
    for (const auto& c : costs)
      csv += fmt::format("{},{},{},{:.6g},{},{:.6g},{:.1f},{},{:.6g},{:.6g},{:.6g}\n", g.name, c.count,
                         c.bodies, c.microseconds, predicted(g, costs, c), c.setup_s, c.megabytes, c.units,
                         c.solves, c.pivots, c.lasting);
    const double found = verification::exponent(g, costs);
    list.push_back({{"scene", g.name},
                    {"what", g.what},
                    {"counted", g.counted},
                    {"unit", unit_of(g)},
                    {"fit_from", g.fit_from},
                    {"predicted_exponent", g.predicted},
                    {"exponent", std::isnan(found) ? nlohmann::json() : nlohmann::json(found)}});
  }
  auto origin = provenance();
  origin["scene_file"] = "scaling";
  write_json(set.place() / "scaling.json", {{"provenance", origin}, {"scenes", list}});
  write_file(set.place() / "scaling.csv", csv);
  set.commit();
  fmt::print("results in {}\n", folder.string());
  const auto figures = plots::all(folder);
  for (const auto& path : figures) fmt::print("  {}\n", path.string());
  write_page(request.document, folder, "scaling", "scaling.md", text, figures);
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
