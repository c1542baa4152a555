#include <CLI/CLI.hpp>

#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdlib>

#include "cli/commands.hpp"
#include "io/output_file.hpp"
#include "version.hpp"

using namespace freeplay;

namespace {

/// Set by a signal: runs end after their present step, with whole files. The program's own; the library has none.
std::atomic<bool> stop_requested{false};

}  // namespace

int main(int argc, char** argv) {
  // The first signal asks to stop; a second one ends the program.
  const auto stop = [](int signal) {
    stop_requested = true;
    std::signal(signal, SIG_DFL);
  };
  std::signal(SIGINT, stop);
  std::signal(SIGTERM, stop);
  std::signal(SIGPIPE, SIG_IGN);

  CLI::App app{"Freeplay: dynamics of mechanisms with clearance joints in two formulations"};
  app.set_version_flag("--version", fmt::format("freeplay {} ({})", version, commit));
  app.require_subcommand(0, 1);  // so that a word that is no command is named
  cli::Request request;
  request.stop = StopToken(stop_requested);
  const auto add = [&](const char* name, const char* what, cli::Command command) {
    auto* sub = app.add_subcommand(name, what);
    sub->add_option("scene", request.scene, "scene file")->required();
    sub->add_option("--set", request.overrides, "override a key, KEY=VALUE; may be repeated")
        ->allow_extra_args(false);
    sub->callback([&request, command] { request.command = command; });
    return sub;
  };
  auto* check = add("check", "read and validate a scene; print what it makes the solver carry", cli::check);
  check->add_flag("--why", request.why, "say why each thing is eliminated or left out");
  auto* run = app.add_subcommand("run", "solve a scene in one formulation");
  run->add_option("scene", request.scene, "scene file");
  run->add_option("--set", request.overrides, "override a key, KEY=VALUE; may be repeated")
      ->allow_extra_args(false);
  run->callback([&request] { request.command = cli::run; });
  run->add_option("--formulation", request.formulation, "penalty or nonsmooth")
      ->check(CLI::IsMember({"penalty", "nonsmooth"}));
  run->add_option("--accuracy", request.accuracy, "settings by docs/tradeoff.md instead of the scene's")
      ->check(CLI::IsMember({"fast", "balanced", "reference"}));
  run->add_option("-o,--output", request.output, "result folder; default out/NAME-FORMULATION");
  run->add_flag("--forces", request.forces, "write forces.csv too, as run.forces = true does");
  run->add_option("--resume", request.resume, "go on with the interrupted run in this folder");
  run->add_option("--checkpoint", request.checkpoint,
                  "seconds between checkpoints, from which --resume goes on; 0 for none")
      ->check(CLI::Validator(
          [](std::string& text) {
            char* end = nullptr;
            const double x = std::strtod(text.c_str(), &end);
            return end != text.c_str() && *end == 0 && x >= 0 && std::isfinite(x)
                       ? std::string()
                       : std::string("must be a number of seconds, 0 or more");
          },
          ""))
      ->capture_default_str();
  auto* compare = add("compare", "solve a scene in both formulations and compare them", cli::compare);
  compare->add_flag("--as-given", request.as_given,
                    "leave the impact law at the restitution asked for, unmatched");
  compare->add_flag("--forces", request.forces, "write forces.csv too, and draw its figures");
  compare->add_option("--accuracy", request.accuracy, "settings by docs/tradeoff.md instead of the scene's")
      ->check(CLI::IsMember({"fast", "balanced", "reference"}));
  compare->add_option("-o,--output", request.output, "result folder; default out/NAME");
  auto* figures = app.add_subcommand("figures", "draw the figures of a result folder again");
  figures->add_option("folder", request.scene, "folder made by run, compare, laws, drift or validate")
      ->required();
  figures->callback([&request] { request.command = cli::figures; });

  auto* drift =
      add("drift", "what each stabilisation of the penalty formulation does to a scene", cli::drift);
  drift->add_option("-o,--output", request.output, "result folder; default out/NAME-drift");
  auto* laws = app.add_subcommand("laws", "list the contact laws, or what each delivers");
  auto* drawn = laws->add_option("scene", request.scene, "draw the laws for this scene's first contact");
  laws->add_option("--restitution", request.restitution,
                   "restitution asked for: print what each law delivers")
      ->excludes(drawn);
  laws->add_option("--set", request.overrides, "override a key, KEY=VALUE; may be repeated")
      ->allow_extra_args(false)
      ->needs(drawn);
  laws->add_option("--mass", request.mass, "mass of the impact that is drawn, kg")->needs(drawn);
  laws->add_option("--speed", request.speed, "its speed of approach, m/s")->needs(drawn);
  laws->add_option("-o,--output", request.output, "result folder; default out/laws")->needs(drawn);
  laws->callback([&request] { request.command = cli::laws; });

  auto* sweep = app.add_subcommand("sweep", "run what is missing of a study, on all cores");
  sweep->add_option("study", request.scene, "study file")->required();
  sweep->add_option("-o,--output", request.output, "result folder; default out/NAME");
  sweep->add_option("--threads", request.threads, "how many runs at a time; default one for each core")
      ->check(CLI::Range(1, 1024));
  sweep->callback([&request] { request.command = cli::sweep; });

  auto* calibrate = app.add_subcommand("calibrate", "fit a study's unknowns to measured statistics");
  calibrate->add_option("study", request.scene, "study file with [calibrate]")->required();
  calibrate->add_option("-o,--output", request.output, "result folder; default out/NAME");
  calibrate->add_option("--threads", request.threads, "how many runs at a time; default one for each core")
      ->check(CLI::Range(1, 1024));
  calibrate->callback([&request] { request.command = cli::calibrate; });

  auto* validate = app.add_subcommand(
      "validate", "a scene against a measured file, or a study against published findings");
  validate->add_option("scene", request.scene, "scene file, or study file with claims")->required();
  auto* data = validate->add_option("--data", request.data, "CSV with t or crank_angle, and acceleration");
  validate->add_option("--set", request.overrides, "override a key of the scene, KEY=VALUE; may be repeated")
      ->allow_extra_args(false)
      ->needs(data);
  validate->add_option("-o,--output", request.output,
                       "result folder; default out/NAME-validation, of a study out/NAME");
  validate
      ->add_flag("--as-given", request.as_given,
                 "leave the impact law at the restitution asked for, unmatched")
      ->needs(data);
  validate
      ->add_option("--document", request.document,
                   "write a study's experiment.md and its figures into this folder")
      ->excludes(data);
  validate->callback([&request] { request.command = cli::validate; });

  auto* extremes =
      app.add_subcommand("extremes", "the map of what holds at the edges; fails on a silent error");
  extremes->add_option("-o,--output", request.output, "result folder");
  extremes->add_option("--document", request.document, "write extremes.md and its figure into this folder");
  extremes->callback([&request] { request.command = cli::extremes; });

  auto* tradeoff =
      app.add_subcommand("tradeoff", "what accuracy costs: every setting on the scenes of a study");
  tradeoff->add_option("study", request.scene, "study file")->required();
  tradeoff->add_option("--repeats", request.repeats, "runs of each setting, interleaved")
      ->check(CLI::Range(1, 1000));
  tradeoff->add_option("-o,--output", request.output, "result folder; default out/NAME");
  tradeoff->add_option("--document", request.document, "write tradeoff.md and its figures into this folder");
  tradeoff->callback([&request] { request.command = cli::tradeoff; });
  auto* advise =
      add("advise", "name the cheapest settings that keep an error, measured on this scene", cli::advise);
  advise->add_option("--error", request.error, "greatest error, per cent (1% or 1)")
      ->transform(CLI::Validator(
          [](std::string& text) {
            if (!text.empty() && text.back() == '%') text.pop_back();
            char* end = nullptr;
            const double x = std::strtod(text.c_str(), &end);
            return end != text.c_str() && *end == 0 && x > 0 && std::isfinite(x)
                       ? std::string()
                       : std::string("must be greater than 0 per cent, as 1% or 1");
          },
          ""));

  auto* verify = app.add_subcommand("verify", "judge every claim that the program makes of itself");
  verify->add_option("names", request.names, "sets of claims; default all");
  verify->add_option("-o,--output", request.output, "result folder");
  verify->add_option("--document", request.document,
                     "write verification.md and its figures into this folder");
  verify->callback([&request] { request.command = cli::verify; });

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  if (!request.command) {
    fmt::print(stderr, "{}", app.help());
    return 2;
  }
  try {
    return request.command(request);
  } catch (const ModelError& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 2;
  } catch (const SnapshotError& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 2;
  } catch (const OutputError& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "out of memory\n");
    return 1;
  } catch (const std::exception& e) {
    fmt::print(stderr, "freeplay: {}\n", e.what());
    return 1;
  }
}
