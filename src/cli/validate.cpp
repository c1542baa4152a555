// freeplay validate SCENE --data FILE: compares both formulations with a measurement.
#include "study/calibration/validate.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "cli/ending.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "cli/validate.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/read_scene.hpp"
#include "io/scene/section.hpp"
#include "plots/drawing/figure.hpp"
#include "values/table.hpp"

namespace freeplay::cli {
namespace {

std::string table(const Validation& v) {
  Table table(",measured,penalty,nonsmooth");
  const auto row = [&](const char* what, double measured, const auto& of) {
    const auto cell = [](double x) { return std::isfinite(x) ? fmt::format("{:.4g}", x) : std::string("-"); };
    table.row(what, cell(measured), cell(of(v.models[0])), cell(of(v.models[1])));
  };
  const double none = std::nan("");
  const auto metric = [&](const char* what, TurnMetrics::Name m) {
    row(what, v.measured.value[m], [m](const Agreement& a) { return a.metrics.value[m]; });
  };
  metric("median peak of a revolution (m/s²)", TurnMetrics::peak_median);
  metric("95 % of revolutions peak below (m/s²)", TurnMetrics::peak_95);
  metric("greatest (m/s²)", TurnMetrics::peak_max);
  row("peak ratio, median", none, [](const Agreement& a) { return a.peak_ratio; });
  row("peak ratio, greatest", none, [](const Agreement& a) { return a.greatest_ratio; });
  const auto property = [&](const char* what, Agreement::Name name, double unit = 1) {
    row(what, none, [&](const Agreement& a) { return unit * a.properties[name].difference.size; });
    row("  explained by uncertainty and scatter", none,
        [&](const Agreement& a) { return unit * a.properties[name].difference.limit; });
  };
  property("difference of mean revolutions (m/s² rms)", Agreement::waveform);
  row("offset of the measured signal (m/s²)", v.offset_removed ? none : v.offset.value,
      [](const Agreement& a) { return a.shift; });
  row("  its standard error", v.offset_removed ? none : v.offset.error,
      [](const Agreement& a) { return a.properties[Agreement::offset].difference.expected; });
  row("  explained by uncertainty and scatter", v.offset_removed ? none : v.offset.limit,
      [](const Agreement& a) { return a.properties[Agreement::offset].difference.limit; });
  if (v.offset_removed) {
    row("offset removed, a fitted value (m/s²)", v.offset.value, [&](const Agreement&) { return none; });
    row("  its standard error", v.offset.error, [&](const Agreement&) { return none; });
  }
  property("difference of peaks (%)", Agreement::peaks, 100);
  property("difference of peak angles (°)", Agreement::peak_angles, 180 / std::numbers::pi);
  property("difference of spectra (m/s² rms)", Agreement::spectrum);
  row("spectral distance", none, [](const Agreement& a) { return a.spectral_distance; });
  metric("dominant lines", TurnMetrics::lines);
  row("gain (measured / model)", none, [](const Agreement& a) { return a.sign * a.gain.mean; });
  row("phase lag of the model (°)", none, [](const Agreement& a) { return a.phase.mean; });
  row("phase shift applied to the model (°)", none, [](const Agreement& a) { return a.moved; });
  row("contact lost at (°)", none, [](const Agreement& a) { return a.loss_angle; });
  row("contact found at (°)", none, [](const Agreement& a) { return a.return_angle; });
  row("signal quiet from (°)", v.quiet.from, [](const Agreement& a) { return a.quiet.from; });
  row("signal quiet to (°)", v.quiet.to, [](const Agreement& a) { return a.quiet.to; });
  return table.terminal({44, 12, 12, 12});
}

/// Findings for each formulation, one a line.
std::string verdicts(const Validation& v) {
  std::string out;
  for (const auto& r : v.remarks) out += "note: " + r + "\n";
  for (const auto& a : v.models) {
    if (a.ending.status != Ending::Status::finished) continue;
    out += fmt::format("{} {}{}{}\n", a.formulation, text_of(a.verdict),
                       a.starts > 1 ? fmt::format(" (of {} starts, the nearest)", a.starts) : "",
                       a.power.empty() ? "" : ": " + a.power);
    for (const auto& f : a.findings) out += "  " + f + "\n";
    for (const auto& r : a.remarks) out += "  note: " + r + "\n";
  }
  return out;
}

int validate_data(const ValidateRequest& request) {
  const auto folder = result_folder(request.output, default_folder(request.scene, "-validation"));
  if (request.revolutions != 0 && !(request.revolutions >= 1 && request.revolutions <= 1e6))
    throw SceneError("validate: --revolutions must be from 1 to 1e6");
  auto with = request.conduct();
  if (request.as_given) with.matched = false;
  ResultSet set(folder, "validate");
  Progress progress;
  const ValidateSetup setup{
      .revolutions = request.revolutions,
      .remove_offset = request.remove_offset,
      .on_progress = [&](const std::string& what, double done) { progress.show(what, done); }};
  const auto v = freeplay::validate(request.scene, request.overrides, request.data, setup, with);
  progress.clear();
  if (request.stop()) return interrupted(Kept::nothing);
  if (v.offset.beyond() && !v.offset_removed)
    fmt::print(stderr, "{}",
               wrapped(fmt::format("warning: the measured signal has a constant offset of {:.3g} m/s² from "
                                   "the ideal mechanism's mean, beyond its uncertainty (standard error "
                                   "{:.2g}); --remove-offset subtracts it\n",
                                   v.offset.value, v.offset.error),
                       9));
  if (!v.plausibility.empty()) fmt::print(stderr, "{}", wrapped("question: " + v.plausibility + "\n", 10));
  fmt::print(
      "{} revolutions of {} at {:.4g} Hz; greatest ideal acceleration {:.4g} m/s²\n"
      "{:.4g} revolutions of the models after {:.4g} discarded{}\n{}\n\n{}",
      v.measured.peaks.size(), request.data, v.sampling, v.ideal_maximum, v.revolutions, v.discarded,
      v.revolutions != v.stated ? fmt::format(" (the scene's own run has {:.4g})", v.stated) : "",
      request.as_given ? "both use the input restitution (--as-given)"
                       : "nonsmooth uses the effective restitution of penalty (not with --as-given)",
      table(v));
  fmt::print("\n{}", wrapped(verdicts(v), 2));
  int status = 0;
  for (const auto& a : v.models)
    if (a.ending.status != Ending::Status::finished) {
      fmt::print(stderr, "{}: stopped: {}\n", a.formulation, a.ending.reason);
      status = 1;
    }
  write_json(set.place() / "validation.json", to_json(v, request.data, !request.as_given),
             provenance(*open_scene(request.scene, request.overrides)));
  write_file(set.place() / "overlay.csv", overlay_table(v).csv());
  set.commit();
  fmt::print("\nresults in {}\n", folder.string());
  if (status == 0) fmt::print("figures:\n  {}\n", plots::overlay.draw(folder).front().string());
  fmt::print("\n{}", wrapped(v.conclusion + "\n", 0));
  return status;
}

int validate(const ValidateRequest& given) {
  auto request = given;
  // A folder stands for its study.
  if (const auto study = std::filesystem::path(request.scene) / "study.toml";
      request.data.empty() && std::filesystem::exists(study))
    request.scene = study.string();
  if (request.data.empty() && !parse_toml(read_text(request.scene), request.scene).contains("claims"))
    throw SceneError(fmt::format("{}: a scene needs --data FILE, a study needs claims", request.scene));
  return request.data.empty() ? validate_study(request) : validate_data(request);
}

}  // namespace

void validate_verb(Program& program) {
  auto [options, request] =
      program.verb("validate", "compare a scene or a study with measurements", validate);
  options.add("scene", request.scene, "scene file, or study file with claims or its folder").required();
  const auto data =
      options
          .add("--data", request.data,
               "CSV file with t or crank_angle, and acceleration, or in the form of signals.csv")
          .takes("FILE");
  options.set(request.overrides, "override a key of the scene, KEY=VALUE; may be repeated").needs(data);
  options.output(request.output, "result folder; default out/NAME-validation, of a study out/NAME");
  options.flag("--as-given", request.as_given, "use the input restitution in the impact law, unmatched")
      .needs(data);
  options
      .flag("--remove-offset", request.remove_offset,
            "subtract the constant offset of the measured signal from the ideal mechanism's mean")
      .needs(data);
  options
      .add("--revolutions", request.revolutions,
           "compared revolutions of each model; default as many as the file has (20 to 200)")
      .takes("N")
      .needs(data);
  options.allow_outside(request.reach).excludes(data);
  options
      .add("--document", request.document, "write a study's experiment.md and its figures into this folder")
      .takes("FOLDER")
      .excludes(data);
}

}  // namespace freeplay::cli
