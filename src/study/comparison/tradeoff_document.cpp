// The texts of `freeplay tradeoff`: the tables of its scenes, and the page docs/verification/tradeoff.md.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "study/comparison/shown.hpp"
#include "study/comparison/tradeoff.hpp"

namespace freeplay {
namespace {

/// Table of a scene's settings, for a terminal or as Markdown.
std::string settings(const TradeoffScene& t, bool markdown) {
  Table all("setting,events,state,energy,stat.,steps,rhs,pivots,CPU ms");
  Table few("setting,events,state,energy,stat.,rhs,CPU ms");  // for 80 columns
  for (const auto& m : t.measured) {
    const bool ended = m.ending.status == Ending::Status::finished;
    const bool touches = !t.reference(m.setting.family).touches.empty();
    const auto statistics = std::isnan(m.statistics)   ? "-"
                            : std::isinf(m.statistics) ? "stopped"
                                                       : fmt::format("{:.1f}", m.statistics);
    const auto label = m.setting.label();
    const auto events = !ended    ? "stopped"
                        : touches ? shown(m.errors.events)
                                  : "-",
               state = ended ? shown(m.errors.state) : "-", energy = ended ? shown(m.errors.energy) : "-";
    all.row(label, events, state, energy, statistics, m.work.steps, m.work.rhs, m.work.pivots,
            fmt::format("{:.3g} ({:.3g}..{:.3g})", 1e3 * m.cpu, 1e3 * m.cpu_low, 1e3 * m.cpu_high));
    few.row(label, events, state, energy, statistics, m.work.rhs, fmt::format("{:.3g}", 1e3 * m.cpu));
  }
  return markdown ? all.markdown() : few.terminal({29, 8, 8, 8, 8, 9, 9});
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

/// Summary: error and CPU time of the settings of `--accuracy`.
Table summary(const std::vector<TradeoffScene>& scenes) {
  Table table("scene,model error of penalty");
  for (const auto& family : families)
    for (const auto& accuracy : accuracies) table.column(fmt::format("{} *{}*", family.text, accuracy.text));
  for (const auto& t : scenes) {
    std::vector<Table::Cell> row{t.variant, shown(t.model_error)};
    for (const auto& family : families)
      for (const auto& accuracy : accuracies) {
        const auto label = setting_for(family.value, accuracy.value).label();
        const auto m = std::ranges::find_if(t.measured, [&](const Measured& one) {
          return one.setting.family == family.value && one.setting.label() == label;
        });
        const bool touches = !t.reference(family.value).touches.empty();
        row.emplace_back(m == t.measured.end() ? "-"
                         : m->ending.status != Ending::Status::finished
                             ? "stopped"
                             : fmt::format("{} in {:.3g} ms",
                                           shown(touches ? m->errors.events : m->errors.state),
                                           1e3 * m->cpu));
      }
    table.row(std::move(row));
  }
  return table;
}

/// Beginning of the document: the summary, with the figure of this name.
std::string page_summary(const Table& table, const std::string& figure) {
  auto out =
      "# Speed against accuracy\n\nThis page compares error and cost of all integrators and schemes on the "
      "scenes of a study, relative to a more accurate\nreference.\n\n## Summary\n\nError and CPU time of the "
      "settings of `--accuracy`. The error is that of contact events (time, approach speed, impulse),\nor of the "
      "velocities in scenes without contact events. The model error of penalty is due to its finite stiffness; "
      "no\nsetting reduces it.\n\n" +
      table.markdown();
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

}  // namespace

std::string tradeoff_text(const TradeoffScene& t) {
  return fmt::format("{} ({})\n{}\n{}{}\n", t.variant, t.name, heading(t), settings(t, false), orders(t));
}

Table tradeoff_table(const std::vector<TradeoffScene>& scenes) {
  Table table(
      "scene,formulation,method,fineness,events,state,energy,statistics,rhs,cpu_s,cpu_least_s,"
      "cpu_greatest_s");
  for (const auto& t : scenes)
    for (const auto& m : t.measured)
      if (m.ending.status == Ending::Status::finished)
        table.row(t.name, name_of(m.setting.family), m.setting.method(), m.setting.fineness,
                  t.reference(m.setting.family).touches.empty() ? NAN : m.errors.events, m.errors.state,
                  m.errors.energy, m.statistics, m.work.rhs, m.cpu, m.cpu_low, m.cpu_high);
  return table;
}

std::string tradeoff_page(const std::vector<TradeoffScene>& scenes, std::vector<std::string> figures,
                          const std::string& first, const std::string& command, int repeats) {
  std::string text;
  for (const auto& t : scenes)
    text += fmt::format("\n## {}\n\n{}\n{}\n{}", t.variant, heading(t), settings(t, true), orders(t));
  const bool shows_first = std::erase(figures, first) > 0;
  text += "\n## Figures\n";
  for (const auto& name : figures) text += fmt::format("\n![{0}](figures/{0})\n", name);
  return page_summary(summary(scenes), shows_first ? first : "") + page_definitions(command, repeats) + text;
}

}  // namespace freeplay
