// freeplay sensitivity: derivatives of results with respect to keys of a scene.
#include "analysis/sensitivity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "analysis/motion_documents.hpp"
#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/figures.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "facade/identify.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/points_file.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/scene.hpp"
#include "values/family.hpp"

namespace freeplay::cli {
namespace {

struct SensitivityVerb : Request {
  std::string scene, formulation = "nonsmooth";
  std::vector<std::string> overrides, of, to, spread;
  std::string output;       ///< result folder
  bool no_compile = false;  ///< derivatives by keys from differences
};

/// Standard deviations of the keys from KEY=VALUE; keys that are not in `to` are appended there.
std::vector<double> deviations_of(const std::vector<std::string>& spread, std::vector<std::string>& to) {
  std::vector<double> deviations(to.size());
  std::vector<std::string> given;
  for (const auto& text : spread) {
    const auto equals = text.rfind('=');
    const double value =
        equals == text.npos ? NAN : number_in(std::string_view(text).substr(equals + 1)).value_or(NAN);
    if (!(value >= 0) || !std::isfinite(value))
      throw SceneError(fmt::format(
          "--spread {}: must be KEY=DEVIATION, with a standard deviation of at least 0 in the unit of the "
          "key",
          text));
    const auto key = text.substr(0, equals);
    if (std::ranges::find(given, key) != given.end())
      throw SceneError(
          fmt::format("--spread {}: {} has a deviation already; give one for each key", text, key));
    given.push_back(key);
    const auto place = static_cast<std::size_t>(std::ranges::find(to, key) - to.begin());
    if (place == to.size()) {
      to.push_back(key);
      deviations.push_back(0);
    }
    deviations[place] = value;
  }
  return deviations;
}

int sensitivity(const SensitivityVerb& request) try {
  const auto scene = read_scene(request.scene, request.overrides);
  const auto folder = result_folder(request.output, default_folder(scene.file, "-sensitivity"));
  auto to = request.to;
  const auto deviations = deviations_of(request.spread, to);
  if (to.empty()) throw SceneError("--to or --spread must name at least one key");
  ResultSet set(folder, "sensitivity");  // before the work, which a locked folder would waste
  const auto all = located_in(scene, [&] {
    return sensitivities(scene, {.of = request.of,
                                 .to = to,
                                 .formulation = request.formulation,
                                 .stop = request.stop,
                                 .compile = request.no_compile ? Compile::never : Compile::automatic});
  });
  write_json(set.place() / "sensitivity.json",
             to_json(all, request.spread.empty() ? std::vector<double>() : deviations, request.formulation),
             provenance(scene, identify(scene, family_of(request.formulation), std::nullopt)));
  set.commit();
  for (const auto& q : all.quantities) {
    fmt::print("{}{}{}\n", q.name,
               std::isfinite(q.value) ? fmt::format(" = {:.12g}", q.value) : ": not reached",
               q.name.starts_with("peak.") ? " (of the continuous signal, not of its samples)" : "");
    for (std::size_t i = 0; i < all.keys.size(); ++i)
      if (std::isfinite(q.derivatives[i]))
        fmt::print("  by {:<36} {:>22.14g} ± {}{}{}\n", all.keys[i], q.derivatives[i],
                   std::isfinite(q.errors[i]) ? fmt::format("{:<7.1e}", q.errors[i]) : "unknown",
                   std::isfinite(influence(all, q, i))
                       ? fmt::format("   relative {:.4g}", influence(all, q, i))
                       : "",
                   is_inexact(all, q, i) ? "   INEXACT" : "");
      else
        fmt::print("{}", wrapped(fmt::format("  by {:<36} no derivative: {}\n", all.keys[i], q.reasons[i])));
    if (const double sigma = propagated_deviation(q, deviations);
        !request.spread.empty() && std::isfinite(sigma))
      fmt::print("  standard deviation {:.4g} (first order)\n", sigma);
  }
  if (std::ranges::any_of(all.quantities, [&](const auto& q) {
        for (std::size_t i = 0; i < all.keys.size(); ++i)
          if (is_inexact(all, q, i)) return true;
        return false;
      }))
    fmt::print(
        "INEXACT: the error exceeds 1e-4 of the derivative's scale, or a run with other settings has no "
        "derivative;\nuse a smaller tolerance or step\n");
  draw_results(folder, Undrawn::is_error);
  if (all.stopped.empty()) {
    if (std::ranges::any_of(all.quantities, [](const auto& q) { return std::isfinite(q.value); })) return 0;
    fmt::print(stderr, "the run reaches none of the quantities\n");
    return 1;
  }
  fmt::print(stderr, "{}: stopped: {}\n", request.formulation, all.stopped);
  return 1;
} catch (const Interrupted&) {
  return interrupted(Kept::nothing);
}

}  // namespace

void sensitivity_verb(Program& program) {
  auto [options, request] = program.verb(
      "sensitivity", "compute derivatives of results with respect to keys of a scene", sensitivity);
  options.scene(request.scene).required();
  options
      .add("--of", request.of,
           "event.N.t, event.N.v_n_minus, event.N.impulse_n (N-th contact event), end.COLUMN, mean.COLUMN, "
           "peak.CHANNEL (of the continuous signal, not of its samples) or energy.KEY")
      .takes("QUANTITY")
      .required();
  options
      .add(
          "--to", request.to,
          "keys of the scene with one number, as surfaces.steel.restitution or gravity[1], or initial.COLUMN")
      .takes("KEY");
  options
      .add("--spread", request.spread,
           "standard deviations of keys, in their units, for first-order standard deviations of the "
           "quantities")
      .takes("KEY=DEVIATION");
  options.flag("--no-compile", request.no_compile, "derivatives by keys from differences, as a reference");
  options.formulation(request.formulation);
  options.set(request.overrides);
  options.output(request.output, "result folder; default out/NAME-sensitivity");
}

}  // namespace freeplay::cli
