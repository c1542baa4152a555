// freeplay sensitivity: derivatives of results with respect to keys of a scene.
#include "facade/sensitivity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/default_folder.hpp"
#include "cli/ending.hpp"
#include "cli/verb.hpp"
#include "cli/wrapped.hpp"
#include "facade/identify.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/located.hpp"
#include "mechanism/scene.hpp"
#include "plots/drawing/figure.hpp"
#include "values/family.hpp"

namespace freeplay::cli {
namespace {

struct SensitivityVerb : Request {
  std::string scene, formulation = "nonsmooth";
  std::vector<std::string> overrides, of, to, spread;
  std::string output;       ///< result folder
  bool no_compile = false;  ///< general path for the variational equations
};

nlohmann::json number_or_null(double x) { return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(); }

/// A value below this part of its greatest change p dQ/dp is zero within the error of a run.
constexpr double rounding_part = 1e-10;

/// (p/Q) dQ/dp, the relative change of the quantity per relative change of the key. NaN without a derivative or if
/// the value is zero.
double influence(const Sensitivities& all, const Sensitivity& q, std::size_t key) {
  double greatest = 0;
  for (std::size_t i = 0; i < all.keys.size(); ++i)
    if (const double change = std::abs(q.derivatives[i] * all.key_values[i]); std::isfinite(change))
      greatest = std::max(greatest, change);
  return std::abs(q.value) > rounding_part * greatest ? q.derivatives[key] * all.key_values[key] / q.value
                                                      : NAN;
}

/// Standard deviations of the keys from KEY=VALUE; keys that are not in `to` are appended there.
std::vector<double> deviations_of(const std::vector<std::string>& spread, std::vector<std::string>& to) {
  std::vector<double> deviations(to.size());
  std::vector<std::string> given;
  for (const auto& text : spread) {
    const auto equals = text.rfind('=');
    double value = 0;
    const char* end = text.data() + text.size();
    const auto [rest, error] = equals == text.npos
                                   ? std::from_chars_result{text.data(), std::errc::invalid_argument}
                                   : std::from_chars(text.data() + equals + 1, end, value);
    if (error != std::errc() || rest != end || !(value >= 0) || !std::isfinite(value))
      throw SceneError(fmt::format(
          "--spread {}: must be KEY=DEVIATION, with a standard deviation of at least 0 in the unit of the key",
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

nlohmann::json quantity_json(const Sensitivities& all, const Sensitivity& q) {
  nlohmann::json derivatives = nlohmann::json::object(), influences = derivatives, reasons = derivatives,
                 errors = derivatives, inexact = nlohmann::json::array();
  std::string first;
  double condition = NAN;
  bool differentiable = true;
  for (std::size_t i = 0; i < all.keys.size(); ++i) {
    const bool known = std::isfinite(q.derivatives[i]);
    derivatives[all.keys[i]] = number_or_null(q.derivatives[i]);
    influences[all.keys[i]] = number_or_null(influence(all, q, i));
    errors[all.keys[i]] = number_or_null(q.errors[i]);
    if (is_inexact(all, q, i)) inexact.push_back(all.keys[i]);
    differentiable = differentiable && known;
    condition = std::fmax(condition, std::abs(influence(all, q, i)));  // of those that exist
    if (q.reasons[i].empty()) continue;
    reasons[all.keys[i]] = q.reasons[i];
    if (first.empty()) first = q.reasons[i];
  }
  return {{"name", q.name},
          {"value", number_or_null(q.value)},
          {"derivatives", derivatives},
          {"error", errors},
          {"inexact", inexact},
          {"relative_influence", influences},
          {"condition", number_or_null(condition)},
          {"differentiable", differentiable},
          {"reason", first},
          {"reasons", reasons}};
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
  nlohmann::json document;
  document["quantities"] = nlohmann::json::array();
  for (const auto& q : all.quantities) {
    document["quantities"].push_back(quantity_json(all, q));
    if (!request.spread.empty())
      document["quantities"].back()["standard_deviation"] =
          number_or_null(propagated_deviation(q, deviations));
  }
  document["keys"] = nlohmann::json::array();
  for (std::size_t i = 0; i < all.keys.size(); ++i) {
    document["keys"].push_back({{"name", all.keys[i]}, {"value", all.key_values[i]}});
    if (!request.spread.empty()) document["keys"].back()["standard_deviation"] = deviations[i];
  }
  document["formulation"] = request.formulation;
  document["cost_over_run"] = all.cost;
  document["stopped"] = all.stopped;
  document["provenance"] = provenance(scene, identify(scene, family_of(request.formulation), std::nullopt));
  write_json(set.place() / "sensitivity.json", document);
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
  fmt::print("results in {}\n", folder.string());
  for (const auto& path : plots::all(folder)) fmt::print("figure: {}\n", path.string());
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
      .add(
          "--spread", request.spread,
          "standard deviations of keys, in their units, for first-order standard deviations of the quantities")
      .takes("KEY=DEVIATION");
  options.flag("--no-compile", request.no_compile,
               "evaluate the variational equations by the general path, as a reference");
  options.add("--formulation", request.formulation, "penalty or nonsmooth")
      .one_of(family_names())
      .shows_default();
  options.set(request.overrides);
  options.output(request.output, "result folder; default out/NAME-sensitivity");
}

}  // namespace freeplay::cli
