// freeplay lyapunov: the Lyapunov exponents of a scene's motion.
#include "analysis/lyapunov.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "analysis/motion_documents.hpp"
#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/figures.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "facade/identify.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/scene.hpp"
#include "values/family.hpp"

namespace freeplay::cli {
namespace {

struct LyapunovVerb : Request {
  std::string scene, formulation = "nonsmooth";
  std::vector<std::string> overrides;
  int batches = LyapunovRequest{}.batches;
  std::optional<double> transient;
  std::string output;  ///< result folder
};

void print_spectrum(const Lyapunov& found) {
  fmt::print("{} Lyapunov exponents over {:.6g} s after {:.6g} s, {} batches, {} contact onsets\n",
             found.exponents.size(), found.duration, found.transient, found.batches, found.impacts);
  for (const auto& e : found.exponents)
    if (std::isfinite(e.value))
      fmt::print("  {:>16.9g} 1/s  ± {:<10.2g}{}\n", e.value, e.error,
                 found.period > 0 ? fmt::format("  {:.9g} per period", e.value * found.period) : "");
    else
      fmt::print("{}", wrapped(fmt::format("  minus infinity: {}\n", e.reason)));
  if (!std::isfinite(found.sum)) return;
  fmt::print("sum {:.9g} ± {:.2g} 1/s\n", found.sum, found.sum_error);
  if (found.unpredicted.empty())
    fmt::print("predicted by divergence and impacts: {:.9g} 1/s (impacts {:.9g})\n", found.predicted,
               found.impact_part);
}

int find_lyapunov(const LyapunovVerb& request) try {
  const auto scene = read_scene(request.scene, request.overrides);
  const auto folder = result_folder(request.output, default_folder(scene.file, "-lyapunov"));
  ResultSet set(folder, "lyapunov");  // before the work, which a locked folder would waste
  const auto found = located_in(scene, [&] {
    return lyapunov(scene, {.formulation = request.formulation,
                            .batches = request.batches,
                            .transient = request.transient,
                            .stop = request.stop});
  });
  if (!found.failure.empty()) {
    fmt::print(stderr, "{}", wrapped("no Lyapunov exponents: " + found.failure + "\n"));
    return 1;
  }
  write_json(set.place() / "lyapunov.json", to_json(found, request.formulation),
             provenance(scene, identify(scene, family_of(request.formulation), std::nullopt)));
  write_file(set.place() / "lyapunov.csv", course_table(found).csv());
  set.commit();
  print_spectrum(found);
  draw_results(folder, Undrawn::is_reported);
  if (found.stopped.empty()) return 0;
  fmt::print(stderr, "{}", wrapped("the run ended early: " + found.stopped + "\n"));
  return 1;
} catch (const Interrupted&) {
  return interrupted(Kept::nothing);
}

}  // namespace

void lyapunov_verb(Program& program) {
  auto [options, request] =
      program.verb("lyapunov", "compute the Lyapunov exponents of a motion with impacts", find_lyapunov);
  options.scene(request.scene).required();
  options.formulation(request.formulation);
  options.add("--batches", request.batches, "number of batches for the standard errors")
      .between(fewest_batches, 10'000)
      .shows_default();
  options
      .add("--transient", request.transient,
           "time excluded at the beginning; default: run.discard, at least a tenth of the run")
      .takes("SECONDS")
      .number([](double x) { return x >= 0; }, "must be 0 or greater");
  options.set(request.overrides);
  options.output(request.output, "result folder; default out/NAME-lyapunov");
}

}  // namespace freeplay::cli
