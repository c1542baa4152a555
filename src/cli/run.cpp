// freeplay run: solves a scene in one formulation, or continues an interrupted run.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/figures.hpp"
#include "cli/folders.hpp"
#include "cli/scene_report.hpp"
#include "cli/terminal.hpp"
#include "dynamics/system.hpp"
#include "facade/law_plugin.hpp"
#include "facade/run_folder.hpp"
#include "facade/simulation.hpp"
#include "io/files/input_file.hpp"
#include "io/files/recorded_run.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/section.hpp"
#include "mechanism/lubricated.hpp"
#include "mechanism/scene.hpp"
#include "plots/drawing/style.hpp"
#include "values/warning.hpp"

namespace freeplay::cli {
namespace {

struct RunRequest : Request {
  Reach reach = Reach::beside;  ///< permitted files of the scene
  std::string scene;
  std::vector<std::string> overrides;
  std::string formulation;
  std::string accuracy;                      ///< fast, balanced or reference; empty: the scene's own settings
  std::string output;                        ///< result folder
  bool forces = false;                       ///< write forces.csv too
  std::string resume;                        ///< folder of an interrupted run
  std::string from;                          ///< run.json of a run to repeat
  std::string law;                           ///< plugin of contact laws and load forces
  bool compile = false, no_compile = false;  ///< compile before the first step, or never
  double checkpoint = 30;                    ///< s of wall time between checkpoints
  double most_output = default_output_limit / 1e9;  ///< GB
  RunFigures figures;
};

/// Requires exactly one of the three ways to specify a run; throws SceneError otherwise.
void require_one_run(const RunRequest& request) {
  const int given = !request.scene.empty() + !request.resume.empty() + !request.from.empty();
  if (given == 0) throw SceneError("run needs a scene, --resume FOLDER, or --from RUN.json");
  if (given > 1)
    throw SceneError(fmt::format("{} takes the scene from {}; give only one of them",
                                 request.from.empty() ? "--resume" : "--from",
                                 request.from.empty() ? "its folder" : "run.json"));
  const bool changes = !request.formulation.empty() || !request.overrides.empty() ||
                       !request.accuracy.empty() || request.forces;
  if (!request.resume.empty() && (changes || !request.output.empty()))
    throw SceneError("--resume continues a run with its own settings: the only other option is --checkpoint");
  if (!request.from.empty() && changes)
    throw SceneError(
        "--from repeats a run with its own settings: the only other options are -o and "
        "--checkpoint");
}

/// Reads the run of a run.json, and sets its output folder.
RecordedRun recorded(const RunRequest& request, RunPlan& plan) {
  std::filesystem::path file = request.from;
  if (std::filesystem::is_directory(file)) file /= "run.json";
  auto run = read_run(file);
  run.setup.give(plan.outside);
  const auto beside = std::filesystem::absolute(file).lexically_normal().parent_path();
  plan.formulation = run.setup.formulation;
  plan.matched = run.setup.matched;
  plan.start = run.setup.start;
  // To reproduce the same files: no error estimate of first contacts if the recorded run has none.
  const auto text = read_file(file, most_of_a_result);
  plan.companion = text.find("\"first_touches_may_be_off_by\"") != text.npos ||
                   text.find("\"status\": \"finished\"") == text.npos;
  plan.folder = result_folder(request.output, beside.string() + "-again");
  std::error_code none;
  if (std::filesystem::equivalent(*plan.folder, beside, none))
    throw SceneError(fmt::format("{}: contains the run to be repeated; give another folder with -o",
                                 plan.folder->string()));
  if (run.identity.program != program_identity())
    fmt::print(stderr, "{}: written by freeplay {}, repeated by {}: results may not be bitwise identical\n",
               file.string(), program_name(run.identity.program), program_name(program_identity()));
  return run;
}

std::string penetration(const ContactSummary& c) {
  if (c.has_clearance()) return fmt::format("{:.3g} of the clearance", c.penetration_ratio);
  return fmt::format("{:.3g} m, {:.3g} of the {}", c.penetration, c.penetration_ratio,
                     c.measure == "radius" ? "radius of curvature" : "longest arm");
}

std::string film_summary(const FilmSummary& f) {
  return fmt::format(
      "  film: eccentricity ratio mean {:.3f}, greatest {:.3f}; least thickness {:.3g} m;\n  load mean "
      "{:.4g} N, greatest {:.4g} N; Sommerfeld number {:.4g}; power loss mean {:.3g} W\n",
      f.mean_ratio, f.greatest_ratio, f.least_thickness, f.mean_load, f.greatest_load, f.sommerfeld,
      f.mean_loss);
}

std::string bearing_summary(const BearingSummary& b) {
  auto text = fmt::format("{}: slides {:.4g} m in contact; greatest pressure {:.3g} Pa", b.joint, b.sliding,
                          b.greatest_pressure);
  const auto add = [&](const char* surface, const std::optional<double>& rate) {
    if (rate) text += fmt::format("; wear of the {} {:.3g} m²/s of its cross-section", surface, *rate);
  };
  add("bearing", b.bearing_wear_rate);
  add("journal", b.journal_wear_rate);
  return text + "\n";
}

std::vector<std::string> films_of(const Scene& scene) {
  std::vector<std::string> names;
  for (const auto& joint : scene.mechanism.joints)
    if (lubricated(scene.mechanism, name_of(joint))) names.push_back(name_of(joint));
  return names;
}

/// The contacts whose restitution depends on the approach speed.
std::vector<std::string> by_speed_of(const Scene& scene) {
  std::vector<std::string> names;
  if (std::ranges::none_of(scene.mechanism.surfaces, &Surface::restitution_by_speed)) return names;
  const System system(scene.mechanism);
  for (int k = 0; k < system.reported(); ++k)
    if (const auto& facts = system.contact_facts(k); facts.surface.restitution_by_speed())
      names.push_back(facts.name);
  return names;
}

int run(const RunRequest& request) {
  require_one_run(request);
  if (!request.figures.style.empty()) plots::choose_style(request.figures.style);
  RunPlan plan;
  plan.stop = request.stop;
  plan.checkpoint = request.checkpoint;
  if (request.compile && request.no_compile)
    throw SceneError("--compile and --no-compile exclude each other; give one of them or neither");
  if (request.compile) plan.compile = Compile::always;
  if (request.no_compile) plan.compile = Compile::never;
  plan.companion = true;
  plan.most_output = 1e9 * request.most_output;
  if (!request.law.empty()) {
    plan.outside = load_plugin(request.law);
    if (plan.outside.law && !request.formulation.empty() && request.formulation != "penalty")
      throw SceneError("--law-plugin: needs --formulation penalty; impact laws have no normal force");
  }
  Progress progress;
  Result summary;
  std::vector<std::string> films;  // joints whose lubricant film carries them without contact
  std::vector<std::string> by_speed;
  const auto name_contacts = [&](const Scene& scene) {
    films = films_of(scene);
    by_speed = by_speed_of(scene);
  };
  if (!request.resume.empty()) {
    plan.folder = real_folder(request.resume);
    plan.on_progress = [&](double done) { progress.show("resumed", done); };
    summary = resume_run(*plan.folder, plan);
    name_contacts(read_run(*plan.folder / "run.json").setup.scene);
  } else if (!request.from.empty()) {
    const auto run = recorded(request, plan);
    plan.on_progress = [&](double done) { progress.show(plan.formulation, done); };
    require_figures(request.figures, run.setup.scene, plan.formulation, *plan.folder);
    name_contacts(run.setup.scene);
    summary = run_scene(run.setup.scene, plan);
  } else {
    if (request.formulation.empty()) throw SceneError("--formulation is required: penalty or nonsmooth");
    auto overrides =
        with_accuracy(request.accuracy, {family_named(request.formulation).value()}, request.overrides);
    if (request.forces) overrides.push_back("run.forces=true");
    Scene scene = read_scene(request.scene, overrides, request.reach == Reach::anywhere);
    put(scene, plan.outside);
    ask(scene);
    name_contacts(scene);
    plan.formulation = request.formulation;
    plan.folder = result_folder(request.output, default_folder(scene.file, "-" + request.formulation));
    plan.on_progress = [&](double done) { progress.show(request.formulation, done); };
    require_figures(request.figures, scene, plan.formulation, *plan.folder);
    summary = run_scene(scene, plan);
  }
  progress.clear();
  fmt::print("{}: {:.6g} s in {} steps, {} right-hand sides, {:.3g} s CPU\n", summary.formulation,
             summary.t_end, summary.work.steps, summary.work.rhs, summary.cpu_seconds);
  if (!summary.assumed.empty()) fmt::print("{}", wrapped("start: " + summary.assumed + "\n", 7));
  const auto on_film = [&](const std::string& joint) { return std::ranges::count(films, joint) > 0; };
  for (const auto& c : summary.contacts) {
    auto text = c.name + ": ";
    if (!std::isnan(c.flight_fraction))  // of one pair
      text += fmt::format("{} {:.2f} %, impacts {:.2f} %, sustained contact {:.2f} %; ",
                          on_film(c.name) ? "on the film" : "flight", 100 * c.flight_fraction,
                          100 * c.impact_fraction, 100 * c.lasting_fraction);
    const auto delivered = c.model.restitution_delivered;
    text += fmt::format(
        "{} impact{};\n  restitution: input {:.4g}, effective {}{};\n  greatest penetration {}\n", c.impacts,
        c.impacts == 1 ? "" : "s", c.model.restitution_asked,
        std::isnan(delivered) ? "unknown" : fmt::format("{:.4g}", delivered),
        std::ranges::count(by_speed, c.name) > 0 ? " at low approach speeds" : "", penetration(c));
    if (c.film) text += film_summary(*c.film);
    fmt::print("{}", wrapped(text));
  }
  for (const auto& b : summary.bearings) fmt::print("{}", wrapped(bearing_summary(b)));
  if (std::isfinite(summary.ledger.closure()))
    fmt::print("energy balance closes to {:.2g} J of {:.3g} J\n", summary.ledger.closure(),
               summary.ledger.scale());
  for (const auto& note : summary.notes)
    fmt::print("{}", wrapped((is_warning(note) ? "" : "note: ") + note + "\n"));
  say_undetermined(summary);
  fmt::print("results in {}\n", plan.folder->string());
  if (summary.ending.status == Ending::Status::interrupted && has_checkpoint(*plan.folder))
    fmt::print("continue with: freeplay run --resume {}\n", plan.folder->string());
  if (summary.ending.status != Ending::Status::interrupted)
    draw_run(request.figures, *plan.folder, request.stop);
  return report(summary);
}

}  // namespace

void run_verb(Program& program) {
  auto [options, request] = program.verb("run", "solve a scene in one formulation", run);
  options.scene(request.scene);
  options.set(request.overrides);
  options.allow_outside(request.reach);
  options.add("--formulation", request.formulation, "formulation; required except with --resume and --from")
      .one_of(family_names());
  options
      .add("--law-plugin", request.law,
           "take contact forces from a compiled plugin; docs/reference/library.md")
      .takes("FILE");
  options.accuracy(request.accuracy);
  options.output(request.output, "result folder; default out/NAME-FORMULATION");
  options.flag("--forces", request.forces, "also write forces.csv, as run.forces = true does");
  options.add("--resume", request.resume, "continue the interrupted run in this folder").takes("FOLDER");
  options.add("--from", request.from, "repeat the run that this run.json records").takes("FILE");
  options.add("--checkpoint", request.checkpoint, "seconds between checkpoints for --resume; 0 for none")
      .number([](double x) { return x >= 0; }, "must be a number of seconds, 0 or more")
      .takes("SECONDS")
      .shows_default();
  options.limit_output(request.most_output);
  options.flag("--compile", request.compile, "compile the mechanism before the first step, not after 20,000");
  options.flag("--no-compile", request.no_compile, "never compile; the results are bitwise identical");
  options
      .add("--plot", request.figures.plot,
           "column to plot over time in a separate figure; may be repeated; a wrong name lists all")
      .takes("COLUMN[,COLUMN...]")
      .one_each();
  options.style(request.figures.style);
  options.flag("--no-figures", request.figures.none, "draw only the figures of --plot");
}

}  // namespace freeplay::cli
