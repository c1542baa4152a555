// freeplay tradeoff: cost and accuracy of all settings on the scenes of a study.
#include "study/comparison/tradeoff.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/default_folder.hpp"
#include "cli/document.hpp"
#include "cli/ending.hpp"
#include "cli/progress.hpp"
#include "cli/shown.hpp"
#include "cli/verb.hpp"
#include "facade/simulation.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/open_scene.hpp"
#include "plots/drawing/figure.hpp"
#include "study/settings/provenance.hpp"

namespace freeplay::cli {
namespace {

/// Table of a scene's settings, for a terminal or as Markdown.
std::string table(const TradeoffScene& t, bool markdown) {
  std::string out;
  const auto line = [&](auto... x) {
    if (markdown)
      out += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", x...);
    else  // without steps and pivots, to fit in 80 columns
      out += fmt::format("{0:<29}{1:>8}{2:>8}{3:>8}{4:>8}{6:>9}{8:>9}\n", x...);
  };
  line("setting", "events", "state", "energy", "stat.", "steps", "rhs", "pivots", "CPU ms");
  if (markdown) line("---", "---", "---", "---", "---", "---", "---", "---", "---");
  for (const auto& m : t.measured) {
    const bool ended = m.ending.status == Ending::Status::finished;
    const bool touches = !t.reference(m.setting.family).touches.empty();
    const auto statistics = std::isnan(m.statistics)   ? "-"
                            : std::isinf(m.statistics) ? "stopped"
                                                       : fmt::format("{:.1f}", m.statistics);
    line(m.setting.label(),
         !ended    ? "stopped"
         : touches ? shown(m.errors.events)
                   : "-",
         ended ? shown(m.errors.state) : "-", ended ? shown(m.errors.energy) : "-", statistics, m.work.steps,
         m.work.rhs, m.work.pivots,
         markdown ? fmt::format("{:.3g} ({:.3g}..{:.3g})", 1e3 * m.cpu, 1e3 * m.cpu_low, 1e3 * m.cpu_high)
                  : fmt::format("{:.3g}", 1e3 * m.cpu));
  }
  return out;
}

std::string heading(const TradeoffScene& t) {
  return fmt::format(
      "Evaluated on {} contact events up to {:.4g} s (penalty) and {} up to {:.4g} s\n(nonsmooth); references "
      "accurate to {} and {}.\nModel error of penalty (finite K, no numerics; two contact events): {}.\n"
      "Energy lost scatters by {} over starts.\n",
      t.penalty.touches.size(), t.penalty.horizon, t.nonsmooth.touches.size(), t.nonsmooth.horizon,
      shown(t.penalty.accuracy), shown(t.nonsmooth.accuracy), shown(t.model_error), shown(t.sampling_error));
}

std::string orders(const TradeoffScene& t) {
  std::vector<std::string> list;
  for (const auto& [method, order] : orders_in_work(t))
    list.push_back(fmt::format("{} {:.1f}", method, order));
  return fmt::format("Orders in work: {}.\n",
                     list.empty() ? "none" : fmt::format("{}", fmt::join(list, ", ")));
}

/// Row of the summary: error and CPU time of the settings of `--accuracy`.
std::string summary_row(const TradeoffScene& t, const std::string& title) {
  std::string out = fmt::format("| {} | {} |", title, shown(t.model_error));
  for (const auto& family : families)
    for (const auto& accuracy : accuracies) {
      const auto label = setting_for(family.value, accuracy.value).label();
      const auto m = std::ranges::find_if(t.measured, [&](const Measured& one) {
        return one.setting.family == family.value && one.setting.label() == label;
      });
      const bool touches = !t.reference(family.value).touches.empty();
      out += m == t.measured.end() ? " - |"
             : m->ending.status != Ending::Status::finished
                 ? " stopped |"
                 : fmt::format(" {} in {:.3g} ms |", shown(touches ? m->errors.events : m->errors.state),
                               1e3 * m->cpu);
    }
  return out + "\n";
}

/// Beginning of the document: the summary, with the figure of this name.
std::string page_summary(const std::string& rows, const std::string& figure) {
  std::string out =
      "# Speed against accuracy\n\nThis page compares error and cost of all integrators and schemes on the "
      "scenes of a study, relative to a more accurate\nreference.\n\n## Summary\n\nError and CPU time of the "
      "settings of `--accuracy`. The error is that of contact events (time, approach speed, impulse),\nor of the "
      "velocities in scenes without contact events. The model error of penalty is due to its finite stiffness; "
      "no\nsetting reduces it.\n\n| scene | model error of penalty |";
  std::string rule = "| --- | --- |";
  for (const auto& family : families)
    for (const auto& accuracy : accuracies) {
      out += fmt::format(" {} *{}* |", family.text, accuracy.text);
      rule += " --- |";
    }
  out += "\n" + rule + "\n" + rows;
  if (!figure.empty())
    out += fmt::format(
        "\n![{0}](figures/{0})\n*Error over evaluations of the right-hand side and over CPU time, for one scene; "
        "the other scenes are at the end.*\n",
        figure);
  return out;
}

/// Definitions of the errors, and the settings of `--accuracy`.
std::string page_definitions(const std::string& command, int repeats) {
  std::string text = fmt::format(
      "\n## Quantities and settings\n\nWritten by `{} --document docs/verification`. Errors: *events*, "
      "the greatest relative error of\ntimes (over the time since the last event), approach speeds and "
      "impulses of contact events up to the horizon; *state*, of the\nvelocities in the middle of the "
      "flight before the last contact event used (with fewer than two: before the first, or at the end); "
      "*energy*, the error of the energy balance over the whole run; *stat.*, the difference, in standard "
      "errors,\nof the mean energy loss or flight share (the worse of the two) over perturbed starts from "
      "that of an accurate\nsetting over other starts: 3.0 is Welch's bound at 1 % for eight starts each, "
      "so one setting in fifty exceeds it by chance. *Orders in work*: the order of an error in the number "
      "of right-hand sides, by least\nsquares over at least three settings with errors between twice the "
      "accuracy of the reference and 0.5; of events, or of the state for motions without contact events; "
      "given if the points are on a line.\nCounts do not depend on the machine; CPU is the median "
      "(least..greatest) of {} interleaved runs.\n",
      command, repeats);
  text += "\n`--accuracy` uses these rows of the tables:";
  for (const auto& [family, formulation] : families)
    text += fmt::format(
        " {} *fast* {}, *balanced* {}, *reference* {}{}", formulation,
        setting_for(family, Accuracy::fast).label(), setting_for(family, Accuracy::balanced).label(),
        setting_for(family, Accuracy::reference).label(), family == families.back().value ? ".\n" : ";");
  text +=
      "*fast* reproduces the mechanism's statistics, *balanced* is for studies, and *reference* has "
      "smaller errors than any model here.\nPenalty uses Adams-Bashforth-Moulton, which needs the fewest "
      "right-hand sides on the paper's rig, at tolerances that\nresolve the contact events. Nonsmooth uses "
      "the automatic scheme: event-driven, the cheapest at any accuracy, where events are separate,\nand "
      "time stepping with adaptive steps where they accumulate.\n";
  return text;
}

struct TradeoffRequest : Request {
  std::string scene;  ///< study file
  Reach reach = Reach::beside;
  int repeats = 3;       ///< runs of each setting
  std::string output;    ///< result folder
  std::string document;  ///< folder for tradeoff.md and its figures
};

int tradeoff(const TradeoffRequest& request) {
  const auto study = read_study(request.scene, request.reach);
  const auto folder = result_folder(request.output, default_folder(study.file, ""));
  std::vector<std::shared_ptr<const Scene>> scenes;  // read all before any run
  for (const auto& v : study.variants) scenes.push_back(open_scene(v.scene, v.overrides));
  nlohmann::json document;
  document["provenance"] = provenance(study);
  document["provenance"]["scene_file"] = study.file.string();
  ResultSet set(folder, "tradeoff");
  std::string csv =
      "scene,formulation,method,fineness,events,state,energy,statistics,rhs,cpu_s,cpu_least_s,cpu_greatest_"
      "s\n";
  std::string rows, text;         // of the summary, and the sections of the scenes
  std::string first_with_events;  // figure of the first scene with contact events
  Progress progress;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const auto& v = study.variants[i];
    const Sampling sampling{v.starts, v.revolutions, study.seed, study.perturbation};
    auto t = trade_off(*scenes[i], request.conduct(), request.repeats, sampling,
                       [&](double done) { progress.show(v.name, done); });
    progress.clear();
    if (request.stop()) return interrupted(Kept::nothing);
    t.name = v.name;
    fmt::print("{} ({})\n{}\n{}{}\n", v.title, v.name, heading(t), table(t, false), orders(t));
    std::fflush(stdout);
    rows += summary_row(t, v.title);
    if (first_with_events.empty() && !(t.penalty.touches.empty() && t.nonsmooth.touches.empty()))
      first_with_events = plots::file_name("tradeoff", v.name) + ".png";
    text += fmt::format("\n## {}\n\n{}\n{}", v.title, heading(t), table(t, true));
    text += "\n" + orders(t);
    document["scenes"][v.name] = to_json(t);
    document["scenes"][v.name]["scene_file"] = v.scene.lexically_normal().string();
    for (const auto& m : t.measured)
      if (m.ending.status == Ending::Status::finished)
        csv += fmt::format(
            "{},{},{},{},{},{},{},{},{},{},{},{}\n", v.name, name_of(m.setting.family), m.setting.method(),
            m.setting.fineness, t.reference(m.setting.family).touches.empty() ? NAN : m.errors.events,
            m.errors.state, m.errors.energy, m.statistics, m.work.rhs, m.cpu, m.cpu_low, m.cpu_high);
  }
  write_json(set.place() / "tradeoff.json", document);
  write_file(set.place() / "tradeoff.csv", csv);
  set.commit();
  const auto figures = plots::all(folder);
  if (!request.document.empty()) {
    const auto place = real_folder(request.document);
    const auto lock = lock_document(place, folder, "tradeoff");
    auto names = copy_figures(figures, place);
    const auto chosen = std::ranges::find(names, first_with_events);
    const auto figure = chosen == names.end() ? std::string() : *chosen;
    if (chosen != names.end()) names.erase(chosen);
    text += "\n## Figures\n";
    for (const auto& name : names) text += fmt::format("\n![{0}](figures/{0})\n", name);
    const auto command = fmt::format("freeplay tradeoff {}{}", request.scene,
                                     request.reach == Reach::anywhere ? " --allow-outside" : "");
    write_file(place / "tradeoff.md",
               page_summary(rows, figure) + page_definitions(command, request.repeats) + text);
  }
  fmt::print("results in {}\n", folder.string());
  return 0;
}

}  // namespace

void tradeoff_verb(Program& program) {
  auto [options, request] = program.verb(
      "tradeoff", "measure the cost of accuracy: all settings on the scenes of a study", tradeoff);
  options.add("study", request.scene, "study file").required();
  options.add("--repeats", request.repeats, "runs of each setting, interleaved").between(1, 1000);
  options.output(request.output, "result folder; default out/NAME");
  options.allow_outside(request.reach);
  options.add("--document", request.document, "write tradeoff.md and its figures into this folder")
      .takes("FOLDER");
}

}  // namespace freeplay::cli
