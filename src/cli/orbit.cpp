// freeplay orbit: a periodic motion of a scene, and its stability.
#include "analysis/orbit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
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
#include "facade/run_folder.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/scene.hpp"
#include "values/family.hpp"

namespace freeplay::cli {
namespace {

struct OrbitVerb : Request {
  std::string scene, formulation = "nonsmooth";
  std::vector<std::string> overrides, shift;
  int periods = 1;
  double settle = OrbitRequest{}.settle;
  std::optional<double> period;
  std::string output;  ///< result folder
};

void print(const Orbit& found) {
  fmt::print("periodic motion of {} x {:.9g} s, {}, residual {:.2g} after {} Newton steps\n", found.periods,
             found.period, found.stable ? "stable" : "not stable", found.residual, found.iterations);
  if (found.moved > 0)
    fmt::print("the section was moved by {:.9g} s, away from a contact onset\n", found.moved);
  fmt::print("{} contact onset{} per motion\n", found.impacts.size(), found.impacts.size() == 1 ? "" : "s");
  for (const auto& c : found.lasting)
    fmt::print("{} is closed during the whole motion, with at least {:.6g} N at t = {:.9g} s\n", c.joint,
               c.least_force, c.t);
  for (const auto& m : found.multipliers)
    fmt::print("  multiplier {:>16.10g} {:>+16.10g} i   modulus {:.10g}\n", m.real(), m.imag(), std::abs(m));
}

/// Runs the motion over its periods, for figures, reports and films. Its folder can be repeated by
/// `freeplay run --from`.
void run_motion(const Scene& scene, const Orbit& found, const OrbitVerb& request,
                const std::filesystem::path& folder) {
  constexpr double rows_of_a_period = 1000, fewest_rows = 2000, most_rows = 20'000;
  auto one = scene;
  const double length = found.periods * found.period;
  one.run.duration = found.state.t + length;
  one.run.output_step = length / std::clamp(rows_of_a_period * found.periods, fewest_rows, most_rows);
  one.run.discard = found.state.t;  // statistics of the motion alone
  const auto result = run_scene(
      one,
      {.formulation = request.formulation, .start = found.state, .folder = folder, .stop = request.stop});
  if (result.ending.status == Ending::Status::interrupted) throw Interrupted();
  if (result.ending.status != Ending::Status::finished)
    fmt::print(stderr, "{}", wrapped("the run of the motion stopped: " + result.ending.reason + "\n"));
}

int find_orbit(const OrbitVerb& request) try {
  const auto scene = read_scene(request.scene, request.overrides);
  const auto folder = result_folder(request.output, default_folder(scene.file, "-orbit"));
  ResultSet set(folder, "orbit");  // before the work, which a locked folder would waste
  const OrbitRequest which{.formulation = request.formulation,
                           .periods = request.periods,
                           .settle = request.settle,
                           .period = request.period,
                           .shift = request.shift,
                           .stop = request.stop};
  const auto found = located_in(scene, [&] { return orbit(scene, which); });
  if (!found.failure.empty()) {
    fmt::print(stderr, "{}", wrapped("no periodic motion found: " + found.failure + "\n"));
    return 1;
  }
  write_json(set.place() / "orbit.json", to_json(scene, which, found),
             provenance(scene, identify(scene, family_of(request.formulation), std::nullopt)));
  run_motion(scene, found, request, set.place() / "motion");
  set.commit();
  print(found);
  if (!request.shift.empty())
    fmt::print("shift of {} per motion: {:.9g}\n", fmt::join(request.shift, ", "), found.shift);
  draw_results(folder, Undrawn::is_reported);
  return 0;
} catch (const Interrupted&) {
  return interrupted(Kept::nothing);
}

}  // namespace

void orbit_verb(Program& program) {
  auto [options, request] = program.verb("orbit", "find a periodic motion and its stability", find_orbit);
  options.scene(request.scene).required();
  options.formulation(request.formulation);
  options.add("--periods", request.periods, "periods of the drive after which the motion repeats")
      .between(1, 100'000)
      .shows_default();
  options.add("--settle", request.settle, "periods of the drive from the scene's start to the first guess")
      .number([](double x) { return x >= 0; }, "must be 0 or greater")
      .shows_default();
  options
      .add("--period", request.period,
           "period of the drives in seconds, if the scene does not show it; without a drive, an estimate of "
           "that of the motion")
      .takes("SECONDS")
      .number([](double x) { return x > 0; }, "must be greater than 0");
  options
      .add(
          "--shift", request.shift,
          "a coordinate, BODY.x, BODY.y or BODY.theta, or x or y of all bodies, that need not return; may be "
          "repeated: all these change by the same amount")
      .takes("COORDINATE")
      .one_each();
  options.set(request.overrides);
  options.output(request.output, "result folder; default out/NAME-orbit");
}

}  // namespace freeplay::cli
